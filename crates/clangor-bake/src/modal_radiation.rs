//! Interface of the modal radiation solvers: the field of each mode of one body at the mode's own frequency.
//!
//! The exterior Neumann problem Δp + k²p = 0, ∂p/∂n = −ρ U(x)·n on the surface, outgoing, e^{+iωt}: the
//! pressure of a modal acceleration q̈ = 1, k = ω/c. The result is the transfer of
//! `clangor_core::sound_model::modal::model`.

pub mod axisymmetric;
pub mod bem_transfer;
pub mod fdtd_transfer;
#[cfg(feature = "gpu")]
pub mod gpu_transfers;
pub mod normal_velocity_projection;
pub mod surface_modes;
pub mod surface_motion;
mod truncation;

use std::ops::ControlFlow;

use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;

use crate::bem::triangles::MOST_ORDER;
use crate::radiation::RadiationError;

/// A mode to radiate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModalMotion<'a> {
    /// k = ω/c [1/m].
    pub wavenumber: f64,
    /// U at the nodes of the surface [kg^−½].
    pub shape: &'a [DVec3],
}

/// A solver of the modes of one body, in the frame with the centre of mass at the origin.
pub trait ModalSolver {
    /// The transfers of the modes, in the same order, as multipoles about the origin that are normalised on
    /// the sphere of `ModalSurface::radius`. `progress` receives the number of completed modes.
    ///
    /// # Errors
    /// [`RadiationError`].
    fn transfers(
        &self,
        surface: &ModalSurface,
        motions: &[ModalMotion<'_>],
        progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<ModalTransfer>, RadiationError>;

    /// Estimated CPU time \[s\] of the transfers of modes of these wavenumbers [1/m].
    fn seconds(&self, wavenumbers: &[f64]) -> f64;
}

/// Checks that the surface has faces, that every mode has a motion for every node, and that the multipole
/// order is supported.
fn check(surface: &ModalSurface, motions: &[ModalMotion<'_>]) -> Result<(), RadiationError> {
    let nodes = surface.nodes.len();
    let orders = |motion: &ModalMotion<'_>| (motion.wavenumber * surface.radius() + 4.0).ceil() as usize;
    if let Some(motion) = motions.iter().find(|motion| orders(motion) > MOST_ORDER) {
        let (order, wavenumber) = (orders(motion), motion.wavenumber);
        return Err(RadiationError::Orders { order, most: MOST_ORDER, wavenumber });
    }
    match motions.iter().find(|motion| motion.shape.len() != nodes) {
        Some(motion) => Err(RadiationError::Shape { given: motion.shape.len(), nodes }),
        None if surface.triangles.is_empty() && !motions.is_empty() => Err(RadiationError::Empty),
        None => Ok(()),
    }
}
