//! The response f of a half-space as a sum of surface waves: f(P) = Σ wⱼ / (P² − σⱼ).
//!
//! f is analytic in P² except for Rayleigh's pole on the real axis and two cuts that begin at m² and n². The
//! cuts may run anywhere below the axis, as the waves pass above: here straight down, or 30° to a side.
//! Cauchy's integral around them gives a wave for each element of a cut, with half the jump of f across it,
//! over π, as weight. The trapezoidal rule in the logarithm of the distance from the branch point turns that
//! into a sum. Between the cuts f may have a leaking pole: the cuts turn away from it.
//!
//! Far from both branch points the two cuts are merged: two waves become one at the mean of their squares.

use std::f64::consts::{FRAC_PI_2, PI};

use num_complex::Complex64;

use super::half_space::HalfSpace;
use crate::math::complex_root::sqrt;

/// Step along a cut in the logarithm: the rule is good to about e^{−2π·(angle to the nearest
/// singularity)/step}.
const STEP: f64 = 0.6;
/// Nearest wave, over n².
const NEAREST: f64 = 1e-4;
/// Farthest wave, over the larger of 1 and n²; the rest of the cut is added to its weight.
const FARTHEST: f64 = 1e5;
/// Distance over n² − m² from which on the two cuts are merged.
const MERGED: f64 = 30.0;

/// Wave of the solid to which a term belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// Rayleigh's surface wave.
    Rayleigh,
    /// Pressure waves along the surface.
    Pressure,
    /// Shear waves along the surface.
    Shear,
    /// A wave that leaks into the ground.
    Leaking,
}

impl Branch {
    /// Its index in a list of Rayleigh's, pressure, shear and leaking waves.
    pub(super) fn index(self) -> usize {
        self as usize
    }
}

/// A term w / (P² − σ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// σ: square of the wave's slowness times c; Im σ ≤ 0, and it decays along the surface.
    pub square: Complex64,
    /// w.
    pub weight: Complex64,
    /// Wave that it is part of.
    pub branch: Branch,
}

/// √z with the cut along e^{iψ}, −π < ψ < 0; positive for positive z.
fn turned_sqrt(z: Complex64, turn: f64) -> Complex64 {
    let half = Complex64::from_polar(1.0, 0.5 * (turn + PI));
    half * sqrt(z / (half * half))
}

/// The poles of a half-space.
pub fn poles(solid: &HalfSpace) -> Vec<Pole> {
    let (m2, n2) = (solid.pressure_square, solid.shear_square);
    let roots = solid.cubic_roots().map(|y| n2 * y);
    let turn = direction_of_cuts(&roots, m2, n2);
    let along = Complex64::from_polar(1.0, turn);
    let root_of = |z| turned_sqrt(z, turn);

    let mut poles = Vec::new();
    for (index, root) in roots.into_iter().enumerate() {
        let (a, b) = (root_of(root - m2), root_of(root - n2));
        let size = ((2.0 * root - n2) * (2.0 * root - n2)).norm();
        // The roots are zeros of r or of r̄: only those of r are poles, and none above the axis.
        if root.im > 1e-12 * n2 || solid.rayleigh(root, a, b).norm() > 1e-6 * size || size < 1e-9 * n2 * n2 {
            continue;
        }
        let slope = 4.0 * (2.0 * root - n2) - 4.0 * a * b - 2.0 * root * (a / b + b / a);
        let branch = if index == 0 { Branch::Rayleigh } else { Branch::Leaking };
        poles.push(Pole { square: root, weight: -n2 * a / slope, branch });
    }

    let farthest = FARTHEST * n2.max(1.0);
    let count = ((farthest / (NEAREST * n2)).ln() / STEP).ceil() as usize;
    for i in 0..=count {
        let distance = NEAREST * n2 * (STEP * i as f64).exp();
        // The jump grows as d^½ near the branch point and falls so far from it: omitted terms are geometric
        // series.
        let ends = match i {
            0 => 1.0 / (1.0 - (-1.5 * STEP).exp()),
            i if i == count => 1.0 / (1.0 - (-0.5 * STEP).exp()),
            _ => 1.0,
        };
        let scale = Complex64::I * along * (0.5 / PI * STEP * distance * ends);
        let right = distance.sqrt() * Complex64::from_polar(1.0, 0.5 * turn);
        let pressure = m2 + along * distance;
        let b = root_of(pressure - n2);
        let jump = solid.admittance_with(pressure, right, b) - solid.admittance_with(pressure, -right, b);
        let pressure = Pole { square: pressure, weight: jump * scale, branch: Branch::Pressure };
        let shear = n2 + along * distance;
        let a = root_of(shear - m2);
        let jump = solid.admittance_with(shear, a, right) - solid.admittance_with(shear, a, -right);
        let shear = Pole { square: shear, weight: jump * scale, branch: Branch::Shear };
        if distance < MERGED * (n2 - m2) {
            poles.extend([pressure, shear]);
        } else {
            let weight = pressure.weight + shear.weight;
            let square = (pressure.weight * pressure.square + shear.weight * shear.square) / weight;
            poles.push(Pole { square, weight, branch: Branch::Shear });
        }
    }
    poles
}

/// ψ of the cuts: down, or the side that is farther from a leaking pole.
fn direction_of_cuts(roots: &[Complex64; 3], m2: f64, n2: f64) -> f64 {
    let leaking = roots.iter().find(|root| root.im < -1e-12 * n2);
    let Some(leaking) = leaking.map(|root| (root - m2).arg()) else { return -FRAC_PI_2 };
    let away = |turn: &f64| (turn - leaking).abs();
    [-FRAC_PI_2, -FRAC_PI_2 - PI / 6.0, -FRAC_PI_2 + PI / 6.0]
        .into_iter()
        .max_by(|a, b| away(a).total_cmp(&away(b)))
        .unwrap_or(-FRAC_PI_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::presets::STEEL;
    use crate::medium::Medium;

    #[test]
    fn the_sum_is_the_response() {
        for poisson_ratio in [0.02, 0.05, 0.19, 0.25, 0.262, 0.264, 0.29, 0.33, 0.4, 0.49] {
            for stiffness in [2e11, 1e8, 1e6] {
                let material = crate::material::Material {
                    poisson_ratio,
                    youngs_modulus: stiffness,
                    ..STEEL.material()
                };
                let solid = HalfSpace::try_new(&material, Medium::AIR.sound_speed).unwrap();
                let n = solid.shear_square.sqrt();
                let rayleigh = n * solid.cubic_roots()[0].re.sqrt();
                let terms = poles(&solid);
                let worst = (0..1500)
                    .map(|i| n * (-7.0 + f64::from(i) * 0.007).exp())
                    .filter(|p| (p / rayleigh - 1.0).abs() > 1e-3 && *p < 10.0 * n.max(1.0))
                    // The first wave is a hundredth of n from the branch point; the sum does not resolve
                    // anything nearer.
                    .filter(|p| {
                        let from = |square: f64| (p * p - square).abs() > 3e-3 * n * n;
                        from(solid.pressure_square) && from(solid.shear_square)
                    })
                    .map(|p| {
                        let square = Complex64::new(p * p, 0.0);
                        let sum: Complex64 = terms.iter().map(|t| t.weight / (square - t.square)).sum();
                        (sum - solid.admittance(square)).norm() * (p + n)
                    })
                    .fold(0.0, f64::max);
                // f is of the order of 1/(P + n). Residual seen: 3.4e-3 (ν = 0.33), 2e-5 where no leaking
                // pole is near.
                assert!(worst < 4e-3, "ν = {poisson_ratio}, E = {stiffness}: {worst:e} of {}", terms.len());
                assert!(terms.iter().all(|t| t.square.im <= 0.0));
            }
        }
    }
}
