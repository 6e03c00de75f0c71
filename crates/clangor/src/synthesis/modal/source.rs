//! A ringing body, ready to be played: frequencies and damping of its modes, transfers, and what a blow does to each.
//!
//! Radiation damps as well. A mode of acceleration amplitude 1 has the energy E = ½/ω² and radiates the power
//! P = ρR⁴/c × [`power`](crate::model::modal_model::ModalTransfer::power), so that its loss factor is
//!
//! ```text
//! η_rad = P/(ωE) = 2ωP,   ξ = ξ_material + η_rad/2
//! ```
//!
//! Each mode by itself: that the air also couples modes of nearly one frequency is left out.

use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use super::bank::Resonance;
use super::transfer::{TransferEvaluator, TransferMemory};
use super::{ModalPressure, ModalSettings};
use crate::material::Damping;
use crate::material::damping::DampingError;
use crate::model::modal_model::{ModalMode, ModalModel};
use crate::model::modal_surface::SurfaceLocator;

/// Why a body cannot ring.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModalError {
    /// A model that contradicts itself.
    #[error("mode {mode} at {frequency} Hz has {what}")]
    BadMode {
        /// Which mode.
        mode: usize,
        /// Its frequency \[Hz\].
        frequency: f64,
        /// What is wrong.
        what: &'static str,
    },
    /// A radius, density or medium that is not positive.
    #[error("the model has {what} {value}")]
    BadModel {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Damping that is none.
    #[error("damping: {0}")]
    Damping(#[from] DampingError),
}

/// See the module.
#[derive(Clone, Debug)]
pub struct ModalSource {
    model: Arc<ModalModel>,
    resonances: Vec<Resonance>,
    transfers: TransferEvaluator,
    locator: SurfaceLocator,
    pressure: ModalPressure,
    contact_damping: f64,
}

impl ModalSource {
    /// Prepares a model in a material of this damping.
    ///
    /// # Errors
    /// [`ModalError`] for a model of bad numbers or lists of the wrong length.
    pub fn new(
        model: Arc<ModalModel>,
        damping: &Damping,
        settings: &ModalSettings,
    ) -> Result<Self, ModalError> {
        damping.check()?;
        check(&model)?;
        let crossing = std::f64::consts::TAU * model.radius / model.medium.sound_speed;
        let resonances = model
            .modes
            .iter()
            .map(|mode| {
                let radiated = if settings.radiation_damping { radiation_ratio(&model, mode) } else { 0.0 };
                let damping_ratio = damping.damping_ratio(mode.frequency) + radiated;
                Resonance { frequency: mode.frequency, damping_ratio }
            })
            .collect();
        let transfers = TransferEvaluator::new(
            model.modes.iter().map(|mode| (mode.transfer.as_ref(), crossing * mode.frequency)),
            settings.orders,
        );
        let locator = SurfaceLocator::new(&model.surface);
        let ModalSettings { pressure, contact_damping, .. } = *settings;
        if !(contact_damping >= 0.0 && contact_damping.is_finite()) {
            return Err(ModalError::BadModel { what: "a contact damping of", value: contact_damping });
        }
        Ok(ModalSource { model, resonances, transfers, locator, pressure, contact_damping })
    }

    /// The model.
    pub fn model(&self) -> &ModalModel {
        &self.model
    }

    /// Frequencies and damping, radiation included, in the order of the model.
    pub fn resonances(&self) -> &[Resonance] {
        &self.resonances
    }

    /// How modes become pressure.
    pub fn pressure(&self) -> ModalPressure {
        self.pressure
    }

    /// c of the contact damping [N s/m].
    pub fn contact_damping(&self) -> f64 {
        self.contact_damping
    }

    /// Adds ½ c (n·U)² × `part` [1/s] of a touching point to what each mode has of it; place \[m\] and unit normal in the
    /// frame of the body.
    pub(super) fn add_contact_decay(&self, place: DVec3, normal: DVec3, part: f64, values: &mut [f64]) {
        let Some(place) = self.locator.nearest(place) else { return };
        for (value, mode) in values.iter_mut().zip(&self.model.modes) {
            let along = place.interpolate(&mode.shape).dot(normal);
            *value += 0.5 * self.contact_damping * along * along * part;
        }
    }

    /// Highest order of the transfers.
    pub fn max_order(&self) -> usize {
        self.transfers.max_order()
    }

    /// H \[Pa s²/kg^½·m\], pressure per modal acceleration without the delay, of every mode at a place
    /// [m, frame of the body]; within the bounding sphere that on it.
    pub fn transfers(&self, place: DVec3, memory: &mut TransferMemory, values: &mut Vec<Complex64>) {
        self.transfers_of(place, |_| true, memory, values);
    }

    /// The same for some modes; 0 for the others.
    pub(super) fn transfers_of(
        &self,
        place: DVec3,
        wanted: impl Fn(usize) -> bool,
        memory: &mut TransferMemory,
        values: &mut Vec<Complex64>,
    ) {
        self.transfers.evaluate_some(place / self.model.radius, wanted, memory, values);
        let scale = self.model.medium.density * self.model.radius;
        values.iter_mut().for_each(|value| *value *= scale);
    }

    /// ∫ Q dt = Σ U(x)·j of every mode, for impulses j [N s] at points x \[m\], both in the frame of the body. A point off
    /// the surface acts at the nearest place on it.
    pub fn amplitudes(&self, points: &[(DVec3, DVec3)], values: &mut Vec<f64>) {
        values.clear();
        values.resize(self.model.modes.len(), 0.0);
        for (point, impulse) in points {
            let Some(place) = self.locator.nearest(*point) else { continue };
            for (value, mode) in values.iter_mut().zip(&self.model.modes) {
                *value += place.interpolate(&mode.shape).dot(*impulse);
            }
        }
    }
}

/// η_rad/2 of a mode; 0 without a transfer.
pub fn radiation_ratio(model: &ModalModel, mode: &ModalMode) -> f64 {
    let Some(transfer) = &mode.transfer else { return 0.0 };
    let omega = std::f64::consts::TAU * mode.frequency;
    let medium = &model.medium;
    let unit = medium.density * model.radius.powi(4) / medium.sound_speed;
    omega * unit * transfer.power(omega * model.radius / medium.sound_speed)
}

/// Refuses a model that cannot be played.
fn check(model: &ModalModel) -> Result<(), ModalError> {
    let medium = &model.medium;
    for (what, value) in [
        ("the radius", model.radius),
        ("the density of the medium", medium.density),
        ("the speed of sound", medium.sound_speed),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(ModalError::BadModel { what, value });
        }
    }
    let nodes = model.surface.nodes.len();
    if model.surface.triangles.iter().flatten().any(|node| *node as usize >= nodes) {
        return Err(ModalError::BadModel { what: "a triangle of unknown nodes among", value: nodes as f64 });
    }
    for (index, mode) in model.modes.iter().enumerate() {
        let bad = |what| Err(ModalError::BadMode { mode: index, frequency: mode.frequency, what });
        if !(mode.frequency > 0.0 && mode.frequency.is_finite()) {
            return bad("no positive frequency");
        }
        if mode.shape.len() != nodes {
            return bad("a shape for other nodes than those of the surface");
        }
        if mode.shape.iter().any(|u| !u.is_finite()) {
            return bad("a shape that is not finite");
        }
        if let Some(transfer) = &mode.transfer {
            if transfer.coefficients.len() != (transfer.order + 1).pow(2) {
                return bad("a transfer of the wrong number of coefficients");
            }
            if transfer.coefficients.iter().any(|c| !c.is_finite()) {
                return bad("a transfer that is not finite");
            }
        }
    }
    Ok(())
}
