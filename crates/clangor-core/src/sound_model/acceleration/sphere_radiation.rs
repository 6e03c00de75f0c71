//! Pressure of a rigid sphere that is accelerated along a line.
//!
//! A rigid sphere of radius a with acceleration A(t) radiates a pure dipole. With W = c/a the transfer from
//! acceleration to pressure at distance r and angle θ from the acceleration is
//!
//! ```text
//! P/A = ρ c² a cosθ (iω/(c r) + 1/r²) / (2W² − ω² + 2iWω) · e^{−iω(r−a)/c}
//! ```
//!
//! exact at every frequency and distance r ≥ a, near field included: the solution of Koss and Alfredson
//! (1973). Because of the two poles W(−1 ± i), the sound rings at ka = 1 and decays as e^{−ct/a}. Rotation of
//! a sphere radiates nothing.
//!
//! Its limit for ka → 0 in the far field is \[HW\] eq. (1), iω ρ a³ cosθ / (2 c r) · e^{−iωr/c}. That limit
//! is too loud by √(1 + (ka)⁴/4), 10 % at ka = 0.957. It stays selectable for comparison.

use crate::medium::Medium;

/// Field of an accelerated sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SphereModel {
    /// The exact field.
    #[default]
    Exact,
    /// The compact dipole of \[HW\] eq. (1): far field of a sphere much smaller than the wavelength.
    CompactDipole,
}

/// Transfer from acceleration [m/s²] to pressure \[Pa\] at one point, as a rational function of ω and a
/// delay:
///
/// `P/A = [a₀ + a₁ω² + iω (b₀ + b₁ω²)] / (d₀ + d₁ω⁴) · e^{−iω delay}`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereTransfer {
    /// a₀, a₁ of the real part.
    pub real: [f64; 2],
    /// b₀, b₁ of the imaginary part.
    pub imaginary: [f64; 2],
    /// d₀, d₁ of the denominator, which is positive at every ω.
    pub denominator: [f64; 2],
    /// Time from the acceleration to the first sound \[s\].
    pub delay: f64,
}

impl SphereTransfer {
    /// The transfer of a sphere of `radius` a \[m\] to a point at `distance` r ≥ a \[m\] from its centre,
    /// `cosine` of the angle between acceleration and direction to the point.
    ///
    /// With D = 2W² − ω² + 2iWω the denominator is |D|² = 4W⁴ + ω⁴ and the numerator (iω/(cr) + 1/r²) D*.
    pub fn new(model: SphereModel, medium: &Medium, radius: f64, distance: f64, cosine: f64) -> Self {
        let Medium { density: rho, sound_speed: c } = *medium;
        match model {
            SphereModel::Exact => {
                let w = c / radius;
                let scale = rho * c * c * radius * cosine;
                let far = scale / (c * distance);
                let near = scale / (distance * distance);
                SphereTransfer {
                    real: [2.0 * w * w * near, 2.0 * w * far - near],
                    imaginary: [2.0 * w * w * far - 2.0 * w * near, -far],
                    denominator: [4.0 * w.powi(4), 1.0],
                    delay: (distance - radius) / c,
                }
            }
            SphereModel::CompactDipole => SphereTransfer {
                real: [0.0, 0.0],
                imaginary: [rho * radius.powi(3) * cosine / (2.0 * c * distance), 0.0],
                denominator: [1.0, 0.0],
                delay: distance / c,
            },
        }
    }

    /// Real and imaginary part of P/A [Pa s²/m] at `omega` [rad/s] without the delay.
    pub fn undelayed(&self, omega: f64) -> (f64, f64) {
        let square = omega * omega;
        let scale = 1.0 / (self.denominator[0] + self.denominator[1] * square * square);
        (
            scale * (self.real[0] + self.real[1] * square),
            scale * omega * (self.imaginary[0] + self.imaginary[1] * square),
        )
    }

    /// Real and imaginary part of P/A [Pa s²/m] at `omega` [rad/s].
    pub fn at(&self, omega: f64) -> (f64, f64) {
        let (re, im) = self.undelayed(omega);
        let (sin, cos) = (-omega * self.delay).sin_cos();
        (re * cos - im * sin, re * sin + im * cos)
    }

    /// Time in which the ringing after the acceleration falls by the factor e^−`folds` \[s\].
    pub fn decay_time(medium: &Medium, radius: f64, folds: f64) -> f64 {
        folds * radius / medium.sound_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compact_dipole_is_the_low_frequency_far_field() {
        let air = Medium::AIR;
        let (radius, distance) = (0.0075, 50.0);
        let exact = SphereTransfer::new(SphereModel::Exact, &air, radius, distance, 0.7);
        let compact = SphereTransfer::new(SphereModel::CompactDipole, &air, radius, distance, 0.7);
        let magnitude = |(re, im): (f64, f64)| f64::hypot(re, im);
        for ka in [0.05, 0.957, 1.5_f64] {
            let omega = ka * air.sound_speed / radius;
            let ratio = magnitude(compact.at(omega)) / magnitude(exact.at(omega));
            // The excess is √(1 + (ka)⁴/4); the near field at 50 m adds 1/(2 (kr)²), 4.5e-6 at ka = 0.05.
            assert!((ratio / (1.0 + ka.powi(4) / 4.0).sqrt() - 1.0).abs() < 1e-5, "ka = {ka}: {ratio}");
        }
    }
}
