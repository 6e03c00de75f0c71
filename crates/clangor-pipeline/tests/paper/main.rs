//! Papers: their printed numbers come out.

#[path = "../broken_tile/mod.rs"]
mod broken_tile;

mod compact_drops;
mod fracture_sound;
mod pan_modes;
