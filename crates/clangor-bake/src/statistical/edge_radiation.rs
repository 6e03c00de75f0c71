//! Sound of bending waves at the free edge of a plate without a baffle, below coincidence.
//!
//! A plate fills x > 0 of the plane z = 0, with the same medium on both sides. A bending wave of wavenumber
//! k_b arrives at the angle θ and is reflected by the free edge (Kirchhoff):
//!
//! ```text
//! v = e^{−ik_y y} Σ_j A_j e^{−iα_j x}     α = −k_x, k_x, −iγ
//! k_x = k_b cos θ     k_y = k_b sin θ     γ² = k_b² + k_y²
//! ```
//!
//! The pressure is antisymmetric in z, thus 0 beside the plate. With κ² = k² − k_y² and Wiener and Hopf's
//! factors of √(α² − κ²), its transform along x and the power from both sides per length of the edge are
//!
//! ```text
//! |P₊| = ωρ |α − κ|^{−1/2} |Σ_j A_j/((α − α_j) √(α_j + κ))|
//! W    = (ωρ/2π) ∫_{−κ}^{κ} |Σ_j A_j/((α − α_j) √(α_j + κ))|² √((κ + α)/(κ − α)) dα
//! ```
//!
//! In a diffuse field every wave that arrives at the edge does so along all of it; the mean square velocity
//! is that of incident and reflected waves. With the perimeter Π and both faces A,
//!
//! ```text
//! σ = Π ⟨W⟩_θ/(ρ c A)
//! ```
//!
//! Not covered: corners, edges nearer to each other than a wavelength of sound, edges thicker than that.
//!
//! # Source
//!
//! \[Noble1958\] for the method, \[CremerHecklPetersson2005\] for the reflection.

use std::f64::consts::{FRAC_PI_2, PI};

use num_complex::Complex64;

/// Nodes of the means over the angle of incidence and over the direction of the sound.
const ANGLES: usize = 48;
const DIRECTIONS: usize = 48;

/// ⟨W⟩ k/(ρ c) of a wave of unit velocity, for μ = k_b/k above 1 and Poisson's ratio.
pub(super) fn edge_power(slowness: f64, poisson: f64) -> f64 {
    // Steeper waves have k_y > k, and radiate nothing.
    let steepest = slowness.recip().asin();
    let step = steepest / ANGLES as f64;
    let sum: f64 = (0..ANGLES).map(|i| power_at(slowness, poisson, step * (i as f64 + 0.5))).sum();
    sum * step / FRAC_PI_2
}

/// W k/(ρ c) of a wave that arrives at an angle to the normal of the edge; lengths over 1/k.
fn power_at(slowness: f64, poisson: f64, angle: f64) -> f64 {
    let (k_x, k_y) = (slowness * angle.cos(), slowness * angle.sin());
    let kappa = (1.0 - k_y * k_y).max(0.0).sqrt();
    let gamma = slowness.hypot(k_y);
    let [reflected, near] = reflection(k_x, k_y, gamma, poisson);
    let root = |alpha: Complex64| (alpha + kappa).sqrt();
    // The branch cut lies above the real axis: √−x = −i√x.
    let incoming = Complex64::new(0.0, -(k_x - kappa).max(0.0).sqrt());
    let evanescent = Complex64::new(0.0, -gamma);
    let waves = [
        (Complex64::from(-k_x), Complex64::ONE / incoming),
        (Complex64::from(k_x), reflected / root(Complex64::from(k_x))),
        (evanescent, near / root(evanescent)),
    ];
    // α = κ cos t.
    let step = PI / DIRECTIONS as f64;
    let sum: f64 = (0..DIRECTIONS)
        .map(|i| {
            let cosine = (step * (i as f64 + 0.5)).cos();
            let transform: Complex64 =
                waves.iter().map(|(pole, amplitude)| amplitude / (kappa * cosine - pole)).sum();
            transform.norm_sqr() * (1.0 + cosine)
        })
        .sum();
    kappa * sum * step / (2.0 * PI)
}

/// Amplitudes of the reflected wave and of the near field e^{−γx} at a free edge, for one that arrives with
/// amplitude 1: no moment, no shear force.
///
/// ```text
/// w_xx − ν k_y² w = 0     w_xxx − (2 − ν) k_y² w_x = 0
/// ```
fn reflection(k_x: f64, k_y: f64, gamma: f64, poisson: f64) -> [Complex64; 2] {
    let squared = k_y * k_y;
    let moment = -(k_x * k_x + poisson * squared);
    let near_moment = gamma * gamma - poisson * squared;
    let shear = k_x * (k_x * k_x + (2.0 - poisson) * squared);
    let near_shear = gamma * (-gamma * gamma + (2.0 - poisson) * squared);
    // (1 + R) moment + N near_moment = 0,   −i shear (1 − R) + N near_shear = 0.
    let i = Complex64::I;
    let per_sum = -moment / near_moment;
    let reflected = (i * shear - per_sum * near_shear) / (i * shear + per_sum * near_shear);
    [reflected, per_sum * (1.0 + reflected)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_edges_reflect_all() {
        for angle in [0.0, 0.4, 1.0, 1.5] {
            let (k_x, k_y): (f64, f64) = (f64::cos(angle), f64::sin(angle));
            let [reflected, near] = reflection(k_x, k_y, 1.0_f64.hypot(k_y), 0.3);
            assert!((reflected.norm() - 1.0).abs() < 1e-12, "{angle}: {reflected}");
            if angle == 0.0 {
                // A beam: R = −i, N = 1 − i; its end gives way four times as much as its middle.
                assert!(
                    (reflected + Complex64::I).norm() < 1e-12 && (near - (1.0 - Complex64::I)).norm() < 1e-12
                );
            }
        }
    }
}
