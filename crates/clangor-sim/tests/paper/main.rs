//! Papers: their printed numbers come out.

#[cfg(feature = "fracture")]
#[path = "../brittle/mod.rs"]
mod brittle;

mod fracture_toughness;
