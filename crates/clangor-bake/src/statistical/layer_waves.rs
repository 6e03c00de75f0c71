//! Waves of an elastic layer with free faces, from a thin plate to a half-space: how a face gives way to a
//! normal force, and the slowest wave along it.
//!
//! A normal stress on one face is half a symmetric and half an antisymmetric one. With k along the layer,
//! d = h/2, α² = k² − k_L², β² = k² − k_T², the displacement of the face per stress is (Rayleigh, Lamb)
//!
//! ```text
//! C_a = −α k_T²/μ [(k²+β²)² tanh αd − 4k²αβ tanh βd]      C_s: coth for tanh
//! Re Y = −(ω/2π) Im ∫₀^∞ ½ (C_a + C_s) k dk
//! ```
//!
//! A thin layer has Re Y = 1/(8√(Dm″)), a thick one that of a half-space, ω²β/(μ c_T) \[MillerPursey1955\].
//! Re Y is the mean over frequencies within [`SMOOTHING`], because a layer without losses has poles at its
//! cut-offs: inertia is taken at ω²(1 − iε). The wave k_s is the root of the antisymmetric denominator above
//! k_T: a bending wave, and Rayleigh's wave on a thick layer.
//!
//! # Source
//!
//! \[Lamb1917\]; \[CremerHecklPetersson2005\], section 5.

use std::f64::consts::TAU;

use clangor_core::material::Material;
use num_complex::Complex64;

/// ε, relative width of the mean over ω².
const SMOOTHING: f64 = 0.05;
/// Steps of the integral to 2 k_s, and from there, logarithmically, to [`FARTHEST`] k_s.
const NEAR_STEPS: usize = 3000;
const FAR_STEPS: usize = 200;
const FARTHEST: f64 = 60.0;
/// Real part from which tanh is 1 to the last bit.
const SATURATED: f64 = 20.0;

/// An elastic layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layer {
    /// h \[m\].
    pub(super) thickness: f64,
    /// c_T [m/s].
    pub(super) shear_speed: f64,
    /// c_L [m/s]; infinite for an incompressible material.
    pub(super) pressure_speed: f64,
    /// μ \[Pa\].
    pub(super) shear_modulus: f64,
}

impl Layer {
    /// Of a material and a thickness \[m\].
    pub(super) fn new(material: &Material, thickness: f64) -> Self {
        let Material { youngs_modulus, poisson_ratio, density, .. } = *material;
        let shear_modulus = 0.5 * youngs_modulus / (1.0 + poisson_ratio);
        let shear_speed = (shear_modulus / density).sqrt();
        let pressure_speed = shear_speed * ((2.0 - 2.0 * poisson_ratio) / (1.0 - 2.0 * poisson_ratio)).sqrt();
        Layer { thickness, shear_speed, pressure_speed, shear_modulus }
    }

    /// k_s [1/m] at ω [rad/s].
    pub(super) fn surface_wavenumber(&self, omega: f64) -> f64 {
        let k_t = omega / self.shear_speed;
        let k_l = omega / self.pressure_speed;
        let half = 0.5 * self.thickness;
        // Positive at k_T, negative far above.
        let above = |k: f64| {
            let (a, b) = ((k * k - k_l * k_l).sqrt(), (k * k - k_t * k_t).max(0.0).sqrt());
            let sum = k * k + b * b;
            sum * sum * (a * half).tanh() < 4.0 * k * k * a * b * (b * half).tanh()
        };
        let [mut low, mut high] = [k_t, 2.0 * k_t];
        while !above(high) && high < 1e9 * k_t {
            (low, high) = (high, 2.0 * high);
        }
        while high - low > 1e-12 * high {
            let middle = 0.5 * (low + high);
            *(if above(middle) { &mut high } else { &mut low }) = middle;
        }
        0.5 * (low + high)
    }

    /// Re Y of a normal force at a point of a face [m/(N s)], at ω [rad/s].
    pub(super) fn mobility(&self, omega: f64) -> f64 {
        let wave = self.surface_wavenumber(omega);
        let lossy = Complex64::new(1.0, -SMOOTHING);
        let k_t2 = (omega / self.shear_speed).powi(2) * lossy;
        let k_l2 = (omega / self.pressure_speed).powi(2) * lossy;
        let integrand = |k: f64| k * self.compliance(k * k, k_t2, k_l2).im;
        let step = 2.0 * wave / NEAR_STEPS as f64;
        let near: f64 = (1..NEAR_STEPS).map(|i| integrand(step * i as f64)).sum::<f64>() * step;
        let edge = 0.5 * step * integrand(2.0 * wave);
        // k = 2 k_s e^t.
        let far_step = (0.5 * FARTHEST).ln() / FAR_STEPS as f64;
        let far: f64 = (0..FAR_STEPS)
            .map(|i| {
                let k = 2.0 * wave * (far_step * (i as f64 + 0.5)).exp();
                k * integrand(k)
            })
            .sum::<f64>()
            * far_step;
        -omega / TAU * (near + edge + far)
    }

    /// ½ (C_a + C_s) [m/Pa] at k² [1/m²].
    fn compliance(&self, k2: f64, k_t2: Complex64, k_l2: Complex64) -> Complex64 {
        let (a, b) = ((k2 - k_l2).sqrt(), (k2 - k_t2).sqrt());
        let half = 0.5 * self.thickness;
        let (ta, tb) = (tanh(a * half), tanh(b * half));
        let sum = (2.0 * k2 - k_t2) * (2.0 * k2 - k_t2);
        let cross = 4.0 * k2 * a * b;
        let antisymmetric = (sum * ta - cross * tb).inv();
        let symmetric = (sum / ta - cross / tb).inv();
        -0.5 * a * k_t2 / self.shear_modulus * (antisymmetric + symmetric)
    }
}

/// tanh of a number with Re ≥ 0, without overflow.
fn tanh(x: Complex64) -> Complex64 {
    if x.re > SATURATED {
        return Complex64::ONE;
    }
    let e = (-2.0 * x).exp();
    (1.0 - e) / (1.0 + e)
}

#[cfg(test)]
mod tests {
    use clangor_core::contact::compliant::half_space_radiation;
    use clangor_core::material::{ThinPlate, presets};

    use super::*;

    #[test]
    fn a_thin_layer_is_a_plate_and_a_thick_one_a_half_space() {
        for preset in [presets::STEEL, presets::GLASS, presets::WOOD] {
            let material = preset.material();
            let speed = Layer::new(&material, 1.0).shear_speed;
            // ωh/c_T = 0.02.
            let thin = Layer::new(&material, 1e-3);
            let omega = 0.02 * speed / 1e-3;
            let plate = ThinPlate::new(&material, 1e-3);
            let ratio = thin.mobility(omega) / plate.point_mobility();
            println!("{}: thin {ratio:.4}", material.name);
            assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
            let ratio = thin.surface_wavenumber(omega) * plate.bending_speed(omega) / omega;
            println!("{}: bending {ratio:.4}", material.name);
            assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
            // ωh/c_T = 60.
            let thick = Layer::new(&material, 1.0);
            let omega = 60.0 * speed;
            let half_space =
                half_space_radiation(material.youngs_modulus, material.poisson_ratio, material.density);
            let ratio = thick.mobility(omega) / (omega * omega * half_space);
            println!("{}: thick {ratio:.4}", material.name);
            assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
        }
    }
}
