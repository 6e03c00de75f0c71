//! The representations of the papers, kept for comparison: \[PAN\] and \[PROXY\] fields, \[FRAC\]'s ground
//! slab.
//!
//! Nothing here is on the main path. A field of ours is exact in distance and frequency; these are what was
//! printed.

pub mod pan_file;
pub mod pan_representation;
pub mod pan_sound;
pub mod slab;
