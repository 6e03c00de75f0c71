//! Modal source: frequencies and damping of the modes of a body, their transfers, and their response to
//! impacts.
//!
//! Radiation adds to the damping. A mode of acceleration amplitude 1 has the energy E = ½/ω² and radiates the
//! power P = ρR⁴/c × [`power`](crate::sound_model::modal::model::ModalTransfer::power), so that its loss
//! factor is
//!
//! ```text
//! η_rad = P/(ωE) = 2ωP,   ξ = ξ_material + η_rad/2
//! ```
//!
//! Each mode is treated separately: the coupling of modes of nearly equal frequency through the air is
//! neglected.

use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use super::transfer::{TransferEvaluator, TransferMemory};
use super::{ModalPressure, ModalSettings};
use crate::contact::ModesAtContact;
use crate::material::Damping;
use crate::material::damping::DampingError;
use crate::medium::Medium;
use crate::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use crate::sound_model::modal::surface::SurfaceLocator;
use crate::sound_model::soundbank::modal_soundbank::{ContactMapping, ModalProxy};
use crate::synthesis::modal::resonator_bank::Resonance;

/// Error in the modes of a body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModalError {
    /// An inconsistent model.
    #[error("mode {mode} at {frequency} Hz has {what}")]
    BadMode {
        /// Index of the mode.
        mode: usize,
        /// Its frequency \[Hz\].
        frequency: f64,
        /// The fault.
        what: &'static str,
    },
    /// A radius, density or medium that is not positive.
    #[error("the model has {what} {value}")]
    BadModel {
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Invalid damping.
    #[error("damping: {0}")]
    Damping(#[from] DampingError),
}

/// See the module.
#[derive(Clone, Debug)]
pub struct ModalSource {
    shapes: Shapes,
    /// R \[m\].
    radius: f64,
    medium: Medium,
    resonances: Vec<Resonance>,
    transfers: TransferEvaluator,
    pressure: ModalPressure,
    contact_damping: f64,
}

/// Reusable memory for the modal impulses of an impact.
#[derive(Clone, Debug, Default)]
pub struct StrikeMemory {
    harmonics: Vec<f64>,
    motions: Vec<DVec3>,
}

/// Shapes of the modes.
#[derive(Clone, Debug)]
enum Shapes {
    /// Modes of the body itself.
    Own { model: Arc<ModalModel>, locator: SurfaceLocator },
    /// Modes of an ellipsoid.
    Proxy { proxy: Box<ModalProxy>, mapping: ContactMapping },
}

impl ModalSource {
    /// Prepares a model with the damping of a material.
    ///
    /// # Errors
    /// [`ModalError`] for a model of bad numbers or lists of the wrong length.
    pub fn new(
        model: Arc<ModalModel>,
        damping: &Damping,
        settings: &ModalSettings,
    ) -> Result<Self, ModalError> {
        check(&model)?;
        let (radius, medium) = (model.radius, model.medium);
        let modes: Vec<_> = model.modes.iter().map(|mode| (mode.frequency, mode.transfer.as_ref())).collect();
        let (mut resonances, transfers) = prepared(&modes, radius, &medium, damping, settings)?;
        for (resonance, mode) in resonances.iter_mut().zip(&model.modes) {
            resonance.damping_ratio += mode.support_damping_ratio();
        }
        let locator = SurfaceLocator::new(&model.surface);
        let shapes = Shapes::Own { model, locator };
        Self::with(shapes, radius, medium, resonances, transfers, settings)
    }

    /// Prepares an ellipsoid as proxy of a body with this damping, with its own transfers or others.
    ///
    /// # Errors
    /// [`ModalError`] for transfers whose number of modes differs from that of the ellipsoid.
    pub fn of_proxy(
        proxy: ModalProxy,
        mapping: ContactMapping,
        transfers: &[ModalTransfer],
        damping: &Damping,
        settings: &ModalSettings,
    ) -> Result<Self, ModalError> {
        if transfers.len() != proxy.mode_count() {
            return Err(ModalError::BadModel { what: "transfers of", value: transfers.len() as f64 });
        }
        let (radius, medium) = (proxy.radius(), proxy.material().medium);
        let modes: Vec<_> =
            transfers.iter().enumerate().map(|(i, t)| (proxy.frequency(i), Some(t))).collect();
        let (resonances, transfers) = prepared(&modes, radius, &medium, damping, settings)?;
        let shapes = Shapes::Proxy { proxy: Box::new(proxy), mapping };
        Self::with(shapes, radius, medium, resonances, transfers, settings)
    }

    fn with(
        shapes: Shapes,
        radius: f64,
        medium: Medium,
        resonances: Vec<Resonance>,
        transfers: TransferEvaluator,
        settings: &ModalSettings,
    ) -> Result<Self, ModalError> {
        let ModalSettings { pressure, contact_damping, .. } = *settings;
        if !(contact_damping >= 0.0 && contact_damping.is_finite()) {
            return Err(ModalError::BadModel { what: "a contact damping of", value: contact_damping });
        }
        Ok(ModalSource { shapes, radius, medium, resonances, transfers, pressure, contact_damping })
    }

    /// Bounding radius of the body or its proxy \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Frequencies and damping, radiation included, in the order of the model.
    pub fn resonances(&self) -> &[Resonance] {
        &self.resonances
    }

    /// Number of modes that are those of the body; synthetic ones come after them.
    pub(super) fn known_modes(&self) -> usize {
        match &self.shapes {
            Shapes::Own { model, .. } => model.known_modes().len(),
            Shapes::Proxy { .. } => self.resonances.len(),
        }
    }

    /// Transfer from modes to pressure.
    pub fn pressure(&self) -> ModalPressure {
        self.pressure
    }

    /// c of the contact damping [N s/m].
    pub fn contact_damping(&self) -> f64 {
        self.contact_damping
    }

    /// U [kg^−½] of every mode at the place of the surface nearest to a point \[m\] whose outer normal fits
    /// the one given. On a proxy, the contact mapping gives the place. All in the frame of the body.
    pub(super) fn motions(&self, place: DVec3, normal: DVec3, values: &mut Vec<DVec3>) {
        values.clear();
        match &self.shapes {
            Shapes::Own { model, locator } => match locator.nearest(place) {
                Some(place) => {
                    values.extend(model.modes.iter().map(|mode| place.interpolate(&mode.shape)));
                }
                None => values.resize(model.modes.len(), DVec3::ZERO),
            },
            Shapes::Proxy { proxy, mapping } => {
                let direction = proxy.contact(place, normal, *mapping);
                proxy.motions(direction, &mut Vec::new(), values);
                let to_body = proxy.rotation().transpose();
                values.iter_mut().for_each(|u| *u = to_body * *u);
            }
        }
    }

    /// The modes at contact points \[m\] with impulses [N s], both in the frame of the body. On a proxy, the
    /// contact mapping gives the places, with the normals against the impulses.
    pub fn at_contact(&self, points: &[(DVec3, DVec3)]) -> ModesAtContact {
        let motions = |(place, impulse): &(DVec3, DVec3)| {
            let mut values = Vec::new();
            self.motions(*place, -*impulse, &mut values);
            values
        };
        ModesAtContact {
            frequencies: self.resonances.iter().map(|resonance| resonance.frequency).collect(),
            damping_ratios: self.resonances.iter().map(|resonance| resonance.damping_ratio).collect(),
            motions: points.iter().map(motions).collect(),
        }
    }

    /// Adds ½ c (n·U)² × `part` [1/s] of a contact point to the decay of each mode. Place \[m\] and unit
    /// normal are in the frame of the body.
    pub(super) fn add_contact_decay(&self, place: DVec3, normal: DVec3, part: f64, values: &mut [f64]) {
        let add =
            |(value, along): (&mut f64, f64)| *value += 0.5 * self.contact_damping * along * along * part;
        match &self.shapes {
            Shapes::Own { model, locator } => {
                let Some(place) = locator.nearest(place) else { return };
                let along = model.modes.iter().map(|mode| place.interpolate(&mode.shape).dot(normal));
                values.iter_mut().zip(along).for_each(add);
            }
            Shapes::Proxy { proxy, mapping } => {
                let (mut harmonics, mut motions) = (Vec::new(), Vec::new());
                // The sign of the normal does not matter: modes have parities.
                proxy.motions(proxy.contact(place, normal, *mapping), &mut harmonics, &mut motions);
                let normal = proxy.rotation() * normal;
                values.iter_mut().zip(motions.iter().map(|u| u.dot(normal))).for_each(add);
            }
        }
    }

    /// Number of coefficients of all transfers.
    pub fn transfer_coefficients(&self) -> usize {
        self.transfers.coefficients()
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
        let place = match &self.shapes {
            Shapes::Own { .. } => place,
            Shapes::Proxy { proxy, .. } => proxy.rotation() * place,
        };
        self.transfers.evaluate_some(place / self.radius, wanted, memory, values);
        let scale = self.medium.density * self.radius;
        values.iter_mut().for_each(|value| *value *= scale);
    }

    /// ∫ Q dt = Σ U(x)·j of every mode, for impulses j [N s] at points x \[m\], both in the frame of the
    /// body. A point off the surface acts at the nearest place on it. On a proxy, the contact mapping gives
    /// the place, with the normal against the impulse.
    pub fn amplitudes(&self, points: &[(DVec3, DVec3)], memory: &mut StrikeMemory, values: &mut Vec<f64>) {
        values.clear();
        values.resize(self.resonances.len(), 0.0);
        match &self.shapes {
            Shapes::Own { model, locator } => {
                for (point, impulse) in points {
                    let Some(place) = locator.nearest(*point) else { continue };
                    for (value, mode) in values.iter_mut().zip(&model.modes) {
                        *value += place.interpolate(&mode.shape).dot(*impulse);
                    }
                }
            }
            Shapes::Proxy { proxy, mapping } => {
                let StrikeMemory { harmonics, motions } = memory;
                for (point, impulse) in points {
                    let place = proxy.contact(*point, -*impulse, *mapping);
                    proxy.motions(place, harmonics, motions);
                    let impulse = proxy.rotation() * *impulse;
                    values.iter_mut().zip(&*motions).for_each(|(value, u)| *value += u.dot(impulse));
                }
            }
        }
    }
}

/// Frequencies with damping, and transfers, of modes of these frequencies \[Hz\].
fn prepared(
    modes: &[(f64, Option<&ModalTransfer>)],
    radius: f64,
    medium: &Medium,
    damping: &Damping,
    settings: &ModalSettings,
) -> Result<(Vec<Resonance>, TransferEvaluator), ModalError> {
    damping.check()?;
    let crossing = std::f64::consts::TAU * radius / medium.sound_speed;
    let resonance = |(frequency, transfer): &(f64, Option<&ModalTransfer>)| {
        let radiated = match transfer {
            Some(transfer) if settings.radiation_damping => {
                radiated_ratio(transfer, *frequency, radius, medium)
            }
            _ => 0.0,
        };
        Resonance { frequency: *frequency, damping_ratio: damping.damping_ratio(*frequency) + radiated }
    };
    let transfers = TransferEvaluator::new(
        modes.iter().map(|(frequency, transfer)| (*transfer, crossing * frequency)),
        settings.orders,
    );
    Ok((modes.iter().map(resonance).collect(), transfers))
}

/// η_rad/2 of a mode; 0 without a transfer.
pub fn radiation_ratio(model: &ModalModel, mode: &ModalMode) -> f64 {
    let transfer = mode.transfer.as_ref();
    transfer.map_or(0.0, |transfer| radiated_ratio(transfer, mode.frequency, model.radius, &model.medium))
}

fn radiated_ratio(transfer: &ModalTransfer, frequency: f64, radius: f64, medium: &Medium) -> f64 {
    let omega = std::f64::consts::TAU * frequency;
    let unit = medium.density * radius.powi(4) / medium.sound_speed;
    omega * unit * transfer.power(omega * radius / medium.sound_speed)
}

/// Rejects an invalid model.
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
