//! Lamb's problem: the surface of an elastic half-space under a vertical force at a point.
//!
//! In slownesses times c, with m = c/c_P and n = c/c_S, a harmonic force F of angular frequency ω moves the
//! surface against its direction by −(c/ωμ) F f(P) in the wave of horizontal slowness P:
//!
//! ```text
//! f(P) = −n² √(P²−m²) / r(P),   r = (2P²−n²)² − 4P² √(P²−m²) √(P²−n²)   (Rayleigh's function)
//! ```
//!
//! With r̄ the same as r but with a plus, r r̄ is a cubic in P² (Rayleigh's, 1885). One root is the slowness
//! of Rayleigh's wave. The other two are zeros of r̄ and give, for Poisson's ratio above 0.263, waves that
//! leak into the ground.
//!
//! For a step force, the displacement over time has a closed form at every distance: Pekeris 1955 for ν = ¼,
//! Mooney 1974 and Kausel 2012 for any ν.

use num_complex::Complex64;

use crate::material::Material;
use crate::math::complex_root::sqrt;

/// Error in the material of a ground.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GroundError {
    /// A number outside the range of elastic solids.
    #[error("the ground of \"{material}\" cannot sound: its {what} is {value}")]
    Material {
        /// The material.
        material: String,
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// An invalid medium above the ground.
    #[error(
        "the ground cannot sound where the speed of sound is {value} m/s and the density {density} kg/m³"
    )]
    Medium {
        /// Speed of sound [m/s].
        value: f64,
        /// Density [kg/m³].
        density: f64,
    },
}

/// An elastic half-space, with slownesses relative to waves of speed c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Shear modulus μ \[Pa\].
    pub shear_modulus: f64,
    /// Density \[kg/m³\].
    pub density: f64,
    /// Poisson's ratio ν \[-\].
    pub poisson_ratio: f64,
    /// m² = (c/c_P)², c_P the speed of pressure waves.
    pub pressure_square: f64,
    /// n² = (c/c_S)², c_S the speed of shear waves.
    pub shear_square: f64,
}

impl HalfSpace {
    /// The half-space of a material, with slownesses in units of 1/`sound_speed` \[s/m\].
    ///
    /// # Errors
    /// [`GroundError`] unless density and stiffness are positive and −1 < ν < ½.
    pub fn try_new(material: &Material, sound_speed: f64) -> Result<Self, GroundError> {
        let refused =
            |what, value| Err(GroundError::Material { material: material.name.clone(), what, value });
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let Material { density, youngs_modulus, poisson_ratio, .. } = *material;
        if !positive(density) {
            return refused("density", density);
        }
        if !positive(youngs_modulus) {
            return refused("Young's modulus", youngs_modulus);
        }
        if !(poisson_ratio > -1.0 && poisson_ratio < 0.5) {
            return refused("Poisson's ratio", poisson_ratio);
        }
        if !positive(sound_speed) {
            return Err(GroundError::Medium { value: sound_speed, density: 0.0 });
        }
        let shear_modulus = 0.5 * youngs_modulus / (1.0 + poisson_ratio);
        let shear_square = density * sound_speed * sound_speed / shear_modulus;
        Ok(HalfSpace {
            shear_modulus,
            density,
            poisson_ratio,
            pressure_square: speed_ratio_square(poisson_ratio) * shear_square,
            shear_square,
        })
    }

    /// Speed of shear waves c_S [m/s].
    pub fn shear_speed(&self) -> f64 {
        (self.shear_modulus / self.density).sqrt()
    }

    /// Speed of pressure waves c_P [m/s].
    pub fn pressure_speed(&self) -> f64 {
        self.shear_speed() / speed_ratio_square(self.poisson_ratio).sqrt()
    }

    /// Speed of Rayleigh waves [m/s].
    pub fn rayleigh_speed(&self) -> f64 {
        self.shear_speed() / self.cubic_roots()[0].re.sqrt()
    }

    /// f at P², on or above the real axis, for waves that leave the force and go down.
    pub fn admittance(&self, square: Complex64) -> Complex64 {
        // On the axis the roots are those of the upper side.
        let above = |z: Complex64| Complex64::new(z.re, z.im.max(0.0));
        let pressure = sqrt(above(square - self.pressure_square));
        let shear = sqrt(above(square - self.shear_square));
        self.admittance_with(square, pressure, shear)
    }

    /// f at P² with these √(P²−m²) and √(P²−n²).
    pub(super) fn admittance_with(
        &self,
        square: Complex64,
        pressure: Complex64,
        shear: Complex64,
    ) -> Complex64 {
        -self.shear_square * pressure / self.rayleigh(square, pressure, shear)
    }

    /// r at P² with these roots.
    pub(super) fn rayleigh(&self, square: Complex64, pressure: Complex64, shear: Complex64) -> Complex64 {
        let double = 2.0 * square - self.shear_square;
        double * double - 4.0 * square * pressure * shear
    }

    /// The zeros of r r̄ in P² c_S²/c²: Rayleigh's wave first, then the other two.
    pub(super) fn cubic_roots(&self) -> [Complex64; 3] {
        let ratio = speed_ratio_square(self.poisson_ratio);
        // y³ − 8y² + (24 − 16 m²/n²) y − 16 (1 − m²/n²) with y = 1/P²: one real root between 0 and 1.
        let (b, c, d) = (-8.0, 24.0 - 16.0 * ratio, -16.0 * (1.0 - ratio));
        let value = |y: f64| ((y + b) * y + c) * y + d;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if value(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let rayleigh = 0.5 * (low + high);
        // The remaining quadratic: y² + (b + y₁) y + (c + (b + y₁) y₁).
        let half = -0.5 * (b + rayleigh);
        let product = c + (b + rayleigh) * rayleigh;
        let root = sqrt(Complex64::new(half * half - product, 0.0));
        [Complex64::new(rayleigh, 0.0), half + root, half - root].map(|y| 1.0 / y)
    }

    /// U in u = F U / (2πμr): displacement in the direction of a step force F at t = 0, at distance r, with τ
    /// = c_S t/r. Its limit for large τ is 1 − ν (Boussinesq).
    pub fn step_displacement(&self, tau: f64) -> f64 {
        let ratio = speed_ratio_square(self.poisson_ratio);
        let roots = self.cubic_roots();
        let square = tau * tau;
        let last = 1.0 - self.poisson_ratio;
        if tau <= 0.0 || square <= ratio {
            return 0.0;
        }
        if square >= roots[0].re {
            return last;
        }
        let part = |j: usize, above: Complex64, below: Complex64| {
            let (k, l) = ((j + 1) % 3, (j + 2) % 3);
            let apart = (roots[j] - roots[k]) * (roots[j] - roots[l]);
            ((roots[j] - 0.5).powi(2) * sqrt(above) / (apart * sqrt(below))).re
        };
        // Before the arrival of Rayleigh's wave both roots change sign.
        let coming = part(0, roots[0] - ratio, roots[0] - square);
        if square >= 1.0 {
            return last * (1.0 - coming);
        }
        let others: f64 = (1..3).map(|j| part(j, ratio - roots[j], square - roots[j])).sum();
        last * 0.5 * (1.0 - coming - others)
    }
}

/// (c_S/c_P)² = (1 − 2ν) / (2 (1 − ν)).
fn speed_ratio_square(poisson_ratio: f64) -> f64 {
    0.5 * (1.0 - 2.0 * poisson_ratio) / (1.0 - poisson_ratio)
}
