//! Bake of the modal soundbank: ellipsoids that replace small bodies without individual modes.
//!
//! \[FRAC\] §5. The modes of each ellipsoid are polynomials ([`ellipsoid_modes`]). Its radiation uses the
//! general solvers: the meridian where two axes are equal, triangles on an octant otherwise
//! ([`modal::radiate`](crate::modal::radiate)).
//!
//! An ellipsoid has all modes that a body of its proportions needs to 20 kHz, if its lowest mode is above
//! [`ModalSoundbankOptions::least_first_frequency`] and ‖(a, b, c)‖ below
//! [`ModalSoundbankOptions::largest_size`]. With S = min(f_p/f_least, largest) modes are baked to
//! 20 kHz × S/m. This is \[FRAC\]'s rule that the scale γ must be below 1, for ellipsoids of size S instead
//! of a metre.

pub mod ellipsoid_modes;
pub mod first_frequency;
pub mod sampling;
pub mod solid_polynomials;
pub mod surface;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::soundbank::modal_soundbank::{
    BankMaterial, EllipsoidMode, ModalSoundbank, ModalSoundbankError, RingingEllipsoid, parity_harmonics,
};
use glam::DVec3;

use crate::acceleration::BakeProgress;
use crate::geometry_class::bake_geometry::BakeGeometry;
use crate::modal::{ModalBakeError, ModalBakeOptions, ModalEvidence, radiate};
use ellipsoid_modes::BallPolynomials;
pub use first_frequency::{FirstFrequencyError, first_frequency, first_frequency_of_surface};
use surface::EllipsoidSurface;

/// Settings of the bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModalSoundbankOptions {
    /// Material of the ellipsoids, and the surrounding medium.
    pub material: BankMaterial,
    /// Upper limit of the band for bodies of any size \[Hz\].
    pub max_frequency: f64,
    /// Lowest first frequency of the bodies served \[Hz\].
    pub least_first_frequency: f64,
    /// ‖(a, b, c)‖ of the largest \[m\].
    pub largest_size: f64,
    /// Least a/c.
    pub thinnest: f64,
    /// Largest difference of log frequency between neighbours.
    pub spacing: f64,
    /// Degree of the polynomials.
    pub degree: usize,
    /// Level error of the transfers.
    pub accuracy: f64,
}

impl ModalSoundbankOptions {
    /// For bodies of a material, up to 20 kHz.
    pub fn new(material: BankMaterial) -> Self {
        ModalSoundbankOptions {
            material,
            max_frequency: 20_000.0,
            least_first_frequency: 1_000.0,
            largest_size: 0.12,
            thinnest: 0.025,
            spacing: 0.6,
            degree: 14,
            accuracy: 0.03,
        }
    }
}

/// Reasons why the bake fails.
#[derive(Debug, thiserror::Error)]
pub enum ModalSoundbankBakeError {
    /// The radiation of an ellipsoid failed.
    #[error("ellipsoid {semi_axes}: {source}")]
    Ellipsoid {
        /// Its semi-axes \[m\].
        semi_axes: DVec3,
        /// Cause.
        source: ModalBakeError,
    },
    /// Invalid option.
    #[error("{what} is {value}")]
    Options {
        /// Name of the option.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The baked data do not form a valid bank.
    #[error(transparent)]
    Bank(#[from] ModalSoundbankError),
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

/// Bakes a bank. `progress` receives the completed part.
///
/// # Errors
/// [`ModalSoundbankBakeError`].
pub fn build_bank(
    options: &ModalSoundbankOptions,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<ModalSoundbank, ModalSoundbankBakeError> {
    let polynomials = BallPolynomials::new(options.degree);
    let samples = sampling::samples(&polynomials, options)?;
    let mut entries = Vec::with_capacity(samples.len());
    for (at, semi_axes) in samples.iter().enumerate() {
        let mut on_progress = |p: &BakeProgress| progress((at as f64 + p.done) / samples.len() as f64);
        entries.push(ringing_ellipsoid(&polynomials, *semi_axes, options, &mut on_progress)?);
    }
    Ok(ModalSoundbank::try_new(options.material, options.degree, entries)?)
}

/// f_p \[Hz\] of an ellipsoid of a metre of this material, from ω of one of E = ρ = 1.
fn in_hertz(material: &BankMaterial, angular_frequency: f64) -> f64 {
    angular_frequency * material.speed() / TAU
}

/// Bakes one ellipsoid, a ≤ b ≤ c with a² + b² + c² = 1 m².
///
/// # Errors
/// [`ModalSoundbankBakeError`].
pub fn ringing_ellipsoid(
    polynomials: &BallPolynomials,
    semi_axes: DVec3,
    options: &ModalSoundbankOptions,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<RingingEllipsoid, ModalSoundbankBakeError> {
    // Band of the ellipsoid, from its lowest frequency.
    let material = &options.material;
    let first = in_hertz(material, polynomials.first(semi_axes, material.poisson_ratio));
    let size = (first / options.least_first_frequency).min(options.largest_size);
    // At least one mode is needed for scaling, however large the body.
    let max_frequency = (options.max_frequency * size).max(1.01 * first);
    // Modes, then their radiation.
    let mut model = modal_model(polynomials, semi_axes, material, max_frequency);
    let geometry = BakeGeometry::Ellipsoid { semi_axes };
    let settings = ModalBakeOptions {
        max_frequency,
        accuracy: options.accuracy,
        ..ModalBakeOptions::new(material.medium)
    };
    let mut evidence = ModalEvidence::default();
    match radiate(&geometry, &mut model.model, &mut evidence, &settings, progress) {
        Err(ModalBakeError::Interrupted) => return Err(ModalSoundbankBakeError::Interrupted),
        Err(source) => return Err(ModalSoundbankBakeError::Ellipsoid { semi_axes, source }),
        Ok(()) => {}
    }
    // Keep the coefficients of each mode's parity.
    let modes = model.model.modes.into_iter().zip(model.modes).map(|(mode, own)| EllipsoidMode {
        transfer: mode.transfer.as_ref().map_or_else(Vec::new, |t| of_parity(t, own.parity)),
        order: mode.transfer.as_ref().map_or(0, |t| t.order),
        ..own
    });
    Ok(RingingEllipsoid { semi_axes, max_frequency, modes: modes.collect() })
}

/// The coefficients of a transfer that have a parity.
fn of_parity(transfer: &ModalTransfer, parity: u8) -> Vec<num_complex::Complex64> {
    parity_harmonics(parity, transfer.order).iter().map(|at| transfer.coefficients[*at as usize]).collect()
}

/// The same modes on a surface and by harmonics.
pub struct SampledModes {
    /// On a surface, without transfers.
    pub model: ModalModel,
    /// By harmonics, without transfers.
    pub modes: Vec<EllipsoidMode>,
}

/// All modes below a frequency \[Hz\] of an ellipsoid of these semi-axes \[m\].
pub fn modal_model(
    polynomials: &BallPolynomials,
    semi_axes: DVec3,
    material: &BankMaterial,
    max_frequency: f64,
) -> SampledModes {
    // Modes in dimensionless form; scale frequencies and shapes to the material.
    let limit = TAU * max_frequency / material.speed();
    let found = polynomials.modes(semi_axes, material.poisson_ratio, limit);
    let surface = EllipsoidSurface::new(semi_axes, polynomials.degree());
    let root = material.density.sqrt();
    let (mut modes, mut sampled) = (Vec::new(), Vec::new());
    for mode in found {
        let frequency = in_hertz(material, mode.angular_frequency);
        let shape = mode.shape.map(|component| component.iter().map(|u| u / root).collect::<Vec<f64>>());
        sampled.push(ModalMode {
            frequency,
            mesh_error: f64::NAN,
            support_damping: 0.0,
            shape: surface.motion(mode.parity, &shape),
            transfer: None,
        });
        modes.push(EllipsoidMode { frequency, parity: mode.parity, shape, order: 0, transfer: Vec::new() });
    }
    let model = ModalModel {
        radius: semi_axes.max_element(),
        medium: material.medium,
        density: material.density,
        max_frequency,
        statistical_above: None,
        surface: surface.surface,
        modes: sampled,
    };
    SampledModes { model, modes }
}
