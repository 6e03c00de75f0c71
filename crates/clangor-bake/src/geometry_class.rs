//! What a mesh is: its axis of revolution and its mirror planes.

pub mod detect_axisymmetry;
pub mod mirror_symmetry;
