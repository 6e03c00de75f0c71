//! Class and symmetries of a geometry: ellipsoid, rounded box, axisymmetric body or mesh; axis of revolution
//! and mirror planes of a mesh.

pub mod bake_geometry;
pub mod detect_axisymmetry;
pub mod mirror_symmetry;
