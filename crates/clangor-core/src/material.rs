//! Materials: elasticity for the contact, losses for the motion, damping and strength for the sound.

pub mod damping;
pub mod pair_restitution;
mod plate_restitution;
pub mod presets;
pub mod thin_plate;

pub use damping::Damping;
pub use pair_restitution::PairRestitution;
pub use plate_restitution::plate_restitution;
pub use thin_plate::ThinPlate;

use pair_restitution::geometric_mean;

/// An isotropic elastic material with the contact and loss coefficients that dynamics and sound need.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name as the scene writes it.
    pub name: String,
    /// Density ρ \[kg/m³\].
    pub density: f64,
    /// Young's modulus E \[Pa\].
    pub youngs_modulus: f64,
    /// Poisson's ratio ν \[-\].
    pub poisson_ratio: f64,
    /// Coefficient of restitution e of a contact \[-\], 0 to 1, without the vibration of the bodies.
    pub restitution: f64,
    /// Approach speed [m/s] at which a viscous contact has that restitution; without it, all speeds have it.
    pub restitution_speed: Option<f64>,
    /// Restitution of whole bodies \[-\], with the vibration of those of everyday shapes, for thin bodies
    /// whose vibration is not known; without it, that of the contact.
    pub rigid_restitution: Option<f64>,
    /// Yield strength Y \[Pa\]: with it, hard impacts lose energy by plastic flow as well.
    pub yield_strength: Option<f64>,
    /// Coulomb friction coefficient μ \[-\].
    pub friction: f64,
    /// Rolling loss length \[m\]: a rolling contact resists with a couple of at most this length times the
    /// normal force.
    pub rolling_loss: f64,
    /// Internal damping.
    pub damping: Damping,
    /// Tensile strength \[Pa\], if known.
    pub tensile_strength: Option<f64>,
    /// Critical energy release rate G_c \[J/m²\], if known.
    pub fracture_energy: Option<f64>,
    /// Source of the numbers.
    pub source: String,
}

impl Material {
    /// The material with a restitution that holds at every speed.
    #[must_use]
    pub fn with_restitution(self, restitution: f64) -> Self {
        Material { restitution, restitution_speed: None, rigid_restitution: None, ..self }
    }

    /// The material of a body whose vibration is not known.
    #[must_use]
    pub fn rigid(self) -> Self {
        match self.rigid_restitution {
            Some(restitution) => Material { restitution, restitution_speed: None, ..self },
            None => self,
        }
    }

    /// Plane-strain compliance (1 − ν²)/E [1/Pa], the body's share of 1/E* in \[PAN\] eq. (8).
    pub fn contact_compliance(&self) -> f64 {
        (1.0 - self.poisson_ratio * self.poisson_ratio) / self.youngs_modulus
    }
}

/// Coefficients of a pair of materials in contact.
///
/// Restitution at each speed and friction are geometric means, rolling loss is the larger of the two.
/// Materials carry their own numbers, so a rule is needed; this one is symmetric, leaves a pair of equals
/// unchanged, and gives 0 if either is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairCoefficients {
    /// Coefficient of restitution e at each approach speed.
    pub restitution: PairRestitution,
    /// Coulomb friction coefficient μ \[-\].
    pub friction: f64,
    /// Rolling loss length \[m\].
    pub rolling_loss: f64,
}

impl PairCoefficients {
    /// Combines two materials.
    pub fn of(a: &Material, b: &Material) -> Self {
        PairCoefficients {
            restitution: PairRestitution::of(a, b),
            friction: geometric_mean(a.friction, b.friction),
            rolling_loss: a.rolling_loss.max(b.rolling_loss),
        }
    }
}
