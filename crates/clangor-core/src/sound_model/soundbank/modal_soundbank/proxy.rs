//! Modal proxy: an ellipsoid of the bank, scaled and rotated to represent a body.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::{
    BankMaterial, MOST_POISSON_DIFFERENCE, MOST_SPEED_DIFFERENCE, ModalSoundbank, RingingEllipsoid,
    ShapeBasis, all_multipoles, normalised_ellipsoid,
};
use crate::sound_model::modal::model::ModalTransfer;

/// Properties of a body that determine its proxy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxyBody {
    /// Inertia about its centre of mass, in its frame [kg m²]; only proportions count.
    pub inertia: DMat3,
    /// Mass \[kg\], which determines the response to an impact.
    pub mass: f64,
    /// Its lowest frequency \[Hz\].
    pub first_frequency: f64,
    /// Its material, and the medium.
    pub material: BankMaterial,
    /// Highest frequency of the modes \[Hz\]; higher ones are left out.
    pub max_frequency: f64,
}

/// Error in the proxy of a body.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ModalProxyError {
    /// A number outside the range of bodies.
    #[error("the body has {what} {value}")]
    Body {
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// An invalid inertia.
    #[error("the body has an inertia that no body has")]
    Inertia,
    /// A material too different from that of the bank.
    #[error("a bank of {what} {bank} does not serve a body of {body}")]
    Material {
        /// Quantity that differs.
        what: &'static str,
        /// Its value in the bank.
        bank: f64,
        /// That of the body.
        body: f64,
    },
}

/// Mapping of a contact point from a body to its proxy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactMapping {
    /// The point of the proxy with the normal of the contact, \[FRAC\] App. F. Every impact on the face of a
    /// plate is mapped to the middle of the face, where most modes have a node.
    Normal,
    /// The point of the proxy in the direction from the centre of mass, after both are scaled to balls. Along
    /// the thickness of the body, only the side counts.
    #[default]
    Position,
}

/// A modal proxy of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalProxy {
    ellipsoid: Arc<RingingEllipsoid>,
    basis: Arc<ShapeBasis>,
    material: BankMaterial,
    /// Index of the ellipsoid in the bank.
    entry: usize,
    /// γ.
    scale: f64,
    /// Frequency of the body over that in the bank.
    frequency_factor: f64,
    /// U over that in the bank, for a body of this mass.
    shape_factor: f64,
    /// c_nm over those in the bank.
    transfer_factor: f64,
    /// From the frame of the body to that of the proxy.
    rotation: DMat3,
    /// Modes in the band.
    modes: usize,
}

impl ModalProxy {
    pub(super) fn new(bank: &ModalSoundbank, body: &ProxyBody) -> Result<Self, ModalProxyError> {
        let ProxyBody { inertia, mass, first_frequency, material, max_frequency } = *body;
        for (what, value) in [
            ("a lowest frequency of", first_frequency),
            ("the mass", mass),
            ("the density", material.density),
            ("Young's modulus", material.youngs_modulus),
            ("a medium of density", material.medium.density),
            ("a medium of sound speed", material.medium.sound_speed),
            ("a highest frequency of", max_frequency),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ModalProxyError::Body { what, value });
            }
        }
        serves(&bank.material, &material)?;
        // Entry nearest to the proportions of inertia.
        let (semi_axes, rotation) = normalised_ellipsoid(inertia).ok_or(ModalProxyError::Inertia)?;
        let entry = bank.nearest(semi_axes);
        let ellipsoid = Arc::clone(&bank.entries[entry]);
        // γ from the lowest frequencies; factors of U and c_nm from γ and the masses.
        let frequency_factor = first_frequency / ellipsoid.modes[0].frequency;
        let scale = material.speed() / bank.material.speed() / frequency_factor;
        let transfer_factor = (bank.material.density / material.density).sqrt() * scale.powf(-1.5);
        let volume = 4.0 / 3.0 * PI * ellipsoid.semi_axes.element_product();
        let shape_factor = (bank.material.density * volume / mass).sqrt();
        let modes = ellipsoid.modes.partition_point(|m| m.frequency * frequency_factor < max_frequency);
        let basis = Arc::clone(&bank.basis);
        Ok(ModalProxy {
            ellipsoid,
            basis,
            material,
            entry,
            scale,
            frequency_factor,
            shape_factor,
            transfer_factor,
            rotation,
            modes,
        })
    }

    /// Index of the ellipsoid in the bank.
    pub fn entry(&self) -> usize {
        self.entry
    }

    /// γ.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// a ≤ b ≤ c \[m\] along x, y, z of the proxy.
    pub fn semi_axes(&self) -> DVec3 {
        self.scale * self.ellipsoid.semi_axes
    }

    /// R \[m\].
    pub fn radius(&self) -> f64 {
        self.semi_axes().z
    }

    /// From the frame of the body to that of the proxy.
    pub fn rotation(&self) -> DMat3 {
        self.rotation
    }

    /// Its material, and the medium.
    pub fn material(&self) -> &BankMaterial {
        &self.material
    }

    /// Number of modes in the band.
    pub fn mode_count(&self) -> usize {
        self.modes
    }

    /// All modes below this frequency \[Hz\] are present.
    pub fn complete_below(&self) -> f64 {
        self.ellipsoid.max_frequency * self.frequency_factor
    }

    /// ω/2π of a mode \[Hz\].
    pub fn frequency(&self, mode: usize) -> f64 {
        self.ellipsoid.modes[mode].frequency * self.frequency_factor
    }

    /// The transfer of a mode, in the frame of the proxy.
    pub fn transfer(&self, mode: usize) -> ModalTransfer {
        let own = &self.ellipsoid.modes[mode];
        ModalTransfer { order: own.order, coefficients: all_multipoles(own, self.transfer_factor) }
    }

    /// Direction ξ, frame of the proxy, at which a contact acts. The place on the body \[m\] and the outer
    /// normal there are in the frame of the body; the normal may have any length.
    pub fn contact(&self, place: DVec3, normal: DVec3, mapping: ContactMapping) -> DVec3 {
        let axes = self.ellipsoid.semi_axes;
        let by_normal = || (axes * (self.rotation * normal)).try_normalize();
        let by_place = || (self.rotation * place / axes).try_normalize();
        let found = match mapping {
            ContactMapping::Normal => by_normal(),
            ContactMapping::Position => by_place().or_else(by_normal),
        };
        found.unwrap_or(DVec3::Z)
    }

    /// The point \[m\] of the proxy's surface in a direction ξ, both in the frame of the proxy.
    pub fn surface_point(&self, direction: DVec3) -> DVec3 {
        self.semi_axes() * direction
    }

    /// U [kg^−½] of all modes in a direction ξ, both in the frame of the proxy; `harmonics` is working
    /// memory.
    pub fn motions(&self, direction: DVec3, harmonics: &mut Vec<f64>, motions: &mut Vec<DVec3>) {
        self.basis.table.evaluate(direction, harmonics);
        motions.clear();
        let modes = self.ellipsoid.modes[..self.modes].iter();
        motions.extend(modes.map(|mode| self.shape_factor * self.basis.motion(mode, harmonics)));
    }
}

/// Checks that a bank can represent bodies of another material.
///
/// # Errors
/// [`ModalProxyError::Material`].
pub fn serves(own: &BankMaterial, material: &BankMaterial) -> Result<(), ModalProxyError> {
    let number = |m: &BankMaterial| m.speed() / m.medium.sound_speed;
    let (bank, body) = (number(own), number(material));
    let speeds = (body / bank - 1.0).abs();
    if speeds.is_nan() || speeds > MOST_SPEED_DIFFERENCE {
        let what = "a speed of sound, over that of the medium, of";
        return Err(ModalProxyError::Material { what, bank, body });
    }
    let (bank, body) = (own.poisson_ratio, material.poisson_ratio);
    let ratios = (bank - body).abs();
    if ratios.is_nan() || ratios > MOST_POISSON_DIFFERENCE {
        return Err(ModalProxyError::Material { what: "Poisson's ratio", bank, body });
    }
    Ok(())
}
