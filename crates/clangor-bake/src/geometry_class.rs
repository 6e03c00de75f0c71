//! Class and symmetries of a geometry: ellipsoid, rounded box, axisymmetric body or mesh; axis of revolution
//! and mirror planes of a mesh.

pub mod agreement;
pub mod bake_geometry;
pub mod detect_axisymmetry;
mod exact_forms;
pub mod flat_plate;
mod form_surface;
pub(crate) mod inner_creases;
pub mod mirror_symmetry;
pub(crate) mod outside;
mod recognise;
mod section_corners;
pub mod solver_choice;
