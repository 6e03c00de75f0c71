//! Meshes for the solvers: triangles of a surface and tetrahedra of a volume.

pub(crate) mod axisymmetric_surface;
pub(crate) mod decimate;
pub(crate) mod draft_surface;
pub mod remesh;
pub mod tetrahedra;
