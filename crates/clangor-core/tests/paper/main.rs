//! Papers: their printed numbers come out.

#[path = "../bodies/mod.rs"]
mod bodies;

mod contact;
mod ground_slab;
mod pan_representation;
