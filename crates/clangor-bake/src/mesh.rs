//! Meshes for the solvers: triangles of a surface and tetrahedra of a volume.

pub(crate) mod decimate;
pub(crate) mod draft_surface;
pub mod remesh;
pub(crate) mod revolution;
pub mod tetrahedra;
