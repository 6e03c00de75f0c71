//! Strength and toughness of a body of the scene that may break, shared by all its pieces.
//!
//! A scratch of depth d weakens a scored body there to K/(1.12 √(π d)), K = √(E G_c/(1 − ν²)) (Griffith,
//! Irwin).

use std::f64::consts::PI;

use clangor_bake::fem::ElasticConstants;
use clangor_core::body::Body;
use clangor_core::contact::contact_side::rayleigh_speed;
use clangor_core::scene::breaking::{Breaking, Score};

use super::error::FractureError;

/// Factor of the stress intensity of a shallow crack in an edge (Irwin 1958).
const EDGE_CRACK: f64 = 1.12;
/// Speed of cracks that branch, over that of Rayleigh waves \[FinebergMarder1999\].
const CRACK_SPEED: f64 = 0.5;

/// A body of the scene that may break, with all its pieces.
pub(super) struct Family {
    pub(super) breaking: Breaking,
    pub(super) constants: ElasticConstants,
    pub(super) strength: f64,
    pub(super) fracture_energy: f64,
    /// σ_c² (1 − 2ν²/(1 − ν))/(2E): energy density at which an element reaches the strength \[J/m³\].
    pub(super) critical_density: f64,
    youngs_modulus: f64,
    poisson_ratio: f64,
    /// Speed of cracks \[m/s\].
    pub(super) crack_speed: f64,
    pub(super) smallest_piece: f64,
    /// Name of the body of the scene.
    pub(super) name: String,
    /// Present number of pieces, and number of pieces ever made.
    pub(super) pieces: usize,
    pub(super) born: usize,
}

impl Family {
    pub(super) fn of(body: &Body, breaking: Breaking) -> Result<Self, FractureError> {
        let material = &body.material;
        let unknown = |number| FractureError::Unknown { material: material.name.clone(), number };
        let strength = material.tensile_strength.ok_or_else(|| unknown("tensile_strength"))?;
        let fracture_energy = material.fracture_energy.ok_or_else(|| unknown("fracture_energy"))?;
        let constants = ElasticConstants::of(material)?;
        let nu = material.poisson_ratio;
        let volume = body.mass / material.density;
        let mut family = Family {
            smallest_piece: breaking.smallest_piece.map_or(1e-3 * volume, |edge| edge.powi(3)),
            breaking,
            constants,
            strength,
            fracture_energy,
            critical_density: 0.0,
            youngs_modulus: material.youngs_modulus,
            poisson_ratio: nu,
            crack_speed: CRACK_SPEED * rayleigh_speed(material),
            name: body.name.clone(),
            pieces: 1,
            born: 0,
        };
        family.critical_density = family.least_strength().powi(2) * (1.0 - 2.0 * nu * nu / (1.0 - nu))
            / (2.0 * material.youngs_modulus);
        Ok(family)
    }

    /// Strength beside a scratch \[Pa\], at most that of the material.
    pub(super) fn strength_at(&self, score: &Score) -> f64 {
        let plane_strain = 1.0 - self.poisson_ratio * self.poisson_ratio;
        let toughness = (self.youngs_modulus * self.fracture_energy / plane_strain).sqrt();
        // At zero depth the quotient is infinite.
        self.strength.min(toughness / (EDGE_CRACK * (PI * score.depth).sqrt()))
    }

    /// The least strength of the body \[Pa\], over all scratches.
    pub(super) fn least_strength(&self) -> f64 {
        self.breaking.scores.iter().map(|score| self.strength_at(score)).fold(self.strength, f64::min)
    }
}
