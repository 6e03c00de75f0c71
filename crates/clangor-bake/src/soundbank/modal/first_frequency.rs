//! The lowest frequency of a body by finite elements, the only input of its modal proxy. For a fragment
//! [`solid_polynomials`](super::solid_polynomials) compute it a hundred times faster.

use clangor_core::geometry::tri_mesh::TriMesh;

use crate::fem::{ElasticConstants, ElasticSystem};
use crate::mesh::tetrahedra::TetMesh;
use crate::mesh::tetrahedra::isosurface_stuffing::{StuffingError, stuff};
use crate::modal_analysis::eigensolver::{ModalError, lowest_frequency};

/// Elements along the longest extent of a body.
const ELEMENTS: f64 = 6.0;

/// Reasons why the lowest frequency cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum FirstFrequencyError {
    /// The body cannot be filled with tetrahedra.
    #[error(transparent)]
    Mesh(#[from] StuffingError),
    /// The eigensolver failed.
    #[error(transparent)]
    Mode(#[from] ModalError),
}

/// The lowest frequency \[Hz\] of a free body with this tetrahedral mesh.
///
/// # Errors
/// [`ModalError`].
pub fn first_frequency(mesh: &TetMesh, constants: &ElasticConstants) -> Result<f64, ModalError> {
    lowest_frequency(&ElasticSystem::new(mesh, constants), constants)
}

/// The lowest frequency \[Hz\] of a free body with this surface, on a coarse grid.
///
/// # Errors
/// [`FirstFrequencyError`].
pub fn first_frequency_of_surface(
    surface: &TriMesh,
    constants: &ElasticConstants,
) -> Result<f64, FirstFrequencyError> {
    let (low, high) = surface.bounds();
    let (mesh, _) = stuff(surface, (high - low).max_element() / ELEMENTS)?;
    Ok(first_frequency(&mesh, constants)?)
}
