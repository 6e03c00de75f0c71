//! A thin elastic plate without edges: its constants, and how it gives way to a force at a point.
//!
//! ```text
//! D = E h³/(12 (1−ν²))     m″ = ρ h     Z = F/v = 8 √(D m″)     ω_c = c² √(m″/D)
//! ```
//!
//! Z is real and the same at every frequency: Cremer, Heckl, Petersson, *Structure-Borne Sound* (2005),
//! section 5.1. A body that hits the plate loses energy to it by Zener's parameter \[Zener1941\]
//!
//! ```text
//! λ = Y m/T₀ ∝ V^{1/5}     T₀ = (m/(k √V))^{2/5}     Y = 1/Z
//! ```
//!
//! with the mass m, the stiffness k of F = k d^{3/2}, and the approach speed V.
//!
//! Not covered: shear and rotary inertia, which count where a bending wave is shorter than six thicknesses.

use super::Material;

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinPlate {
    /// Bending stiffness D \[N m\].
    pub bending_stiffness: f64,
    /// Mass per area m″ \[kg/m²\].
    pub mass_per_area: f64,
}

impl ThinPlate {
    /// Of a material and a thickness \[m\].
    pub fn new(material: &Material, thickness: f64) -> Self {
        let Material { density, youngs_modulus, poisson_ratio, .. } = *material;
        let plane_strain = youngs_modulus / (1.0 - poisson_ratio * poisson_ratio);
        ThinPlate {
            bending_stiffness: plane_strain * thickness.powi(3) / 12.0,
            mass_per_area: density * thickness,
        }
    }

    /// Z = 8 √(D m″), force over velocity at the driven point [N s/m].
    pub fn point_impedance(&self) -> f64 {
        8.0 * (self.bending_stiffness * self.mass_per_area).sqrt()
    }

    /// Y = 1/Z [m/(N s)].
    pub fn point_mobility(&self) -> f64 {
        self.point_impedance().recip()
    }

    /// ω_c [rad/s], at which bending waves have the speed of sound \[m/s\].
    pub fn coincidence(&self, sound_speed: f64) -> f64 {
        sound_speed * sound_speed * (self.mass_per_area / self.bending_stiffness).sqrt()
    }

    /// Phase speed of bending waves [m/s] at ω [rad/s]; energy is twice as fast.
    pub fn bending_speed(&self, omega: f64) -> f64 {
        (omega * (self.bending_stiffness / self.mass_per_area).sqrt()).sqrt()
    }
}

/// Zener's λ of a body that hits at 1 m/s a plate of this point mobility [m/(N s)]; `inverse_mass` [1/kg],
/// `stiffness` k [N/m^1.5]. It grows as V^{1/5}; 0 without a mass or a mobility.
pub fn inelasticity(mobility: f64, inverse_mass: f64, stiffness: f64) -> f64 {
    if mobility > 0.0 && inverse_mass > 0.0 {
        mobility / inverse_mass * (inverse_mass * stiffness).powf(0.4)
    } else {
        0.0
    }
}
