//! Meshes for the solvers: triangles of a surface and tetrahedra of a volume.

pub(crate) mod decimate;
pub mod remesh;
pub mod tetrahedra;
