//! Frequencies of a free elastic sphere: H. Lamb (1881), "On the vibrations of an elastic sphere".
//!
//! With x = ω a / c_L, y = ω a / c_T and spherical Bessel functions j, torsional modes of degree l solve
//! (l − 1) j_l(y) = y j_{l+1}(y), and spheroidal ones T₁₁ T₂₂ = T₁₂ T₂₁ with
//!
//! ```text
//! T₁₁ = (l² − l − y²/2) j_l(x) + 2 x j_{l+1}(x)     T₁₂ = l (l + 1) [(l − 1) j_l(y) − y j_{l+1}(y)]
//! T₂₁ = (l − 1) j_l(x) − x j_{l+1}(x)               T₂₂ = (l² − 1 − y²/2) j_l(y) + y j_{l+1}(y)
//! ```
//!
//! (Eringen and Suhubi 1975, "Elastodynamics", volume 2, section 8.13); for l = 0, T₁₁ = 0. Each is 2 l + 1
//! modes.

use std::f64::consts::TAU;

use clangor_core::material::Material;

/// Degrees and largest y that are searched: the first thirty modes are among them.
const RIGID_DOFS: usize = 8;
const HIGHEST: f64 = 8.0;

/// Frequencies of a sphere of this radius \[m\], each as often as it has modes, from the lowest on \[Hz\].
pub fn frequencies(material: &Material, radius: f64) -> Vec<f64> {
    let nu = material.poisson_ratio;
    let shear_speed = (material.youngs_modulus / (2.0 * (1.0 + nu)) / material.density).sqrt();
    let wave_ratio = ((1.0 - 2.0 * nu) / (2.0 - 2.0 * nu)).sqrt();
    let mut all = Vec::new();
    for l in 0..RIGID_DOFS {
        let mut degree = roots(|y| spheroidal(l, y, wave_ratio));
        if l > 0 {
            degree.extend(roots(|y| torsional(l, y)));
        }
        all.extend(degree.into_iter().flat_map(|y| vec![y * shear_speed / (TAU * radius); 2 * l + 1]));
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Spherical Bessel function of the first kind, by its power series.
fn j(l: usize, x: f64) -> f64 {
    let mut term = (1..=l).map(|k| x / (2 * k + 1) as f64).product::<f64>();
    let mut sum = 0.0;
    for k in 1..100 {
        sum += term;
        term *= -0.5 * x * x / (k * (2 * l + 2 * k + 1)) as f64;
    }
    sum
}

fn torsional(l: usize, y: f64) -> f64 {
    (l as f64 - 1.0) * j(l, y) - y * j(l + 1, y)
}

fn spheroidal(l: usize, y: f64, wave_ratio: f64) -> f64 {
    let (x, n) = (y * wave_ratio, l as f64);
    let t11 = (n * n - n - 0.5 * y * y) * j(l, x) + 2.0 * x * j(l + 1, x);
    if l == 0 {
        return t11;
    }
    let t12 = n * (n + 1.0) * ((n - 1.0) * j(l, y) - y * j(l + 1, y));
    let t21 = (n - 1.0) * j(l, x) - x * j(l + 1, x);
    let t22 = (n * n - 1.0 - 0.5 * y * y) * j(l, y) + y * j(l + 1, y);
    t11 * t22 - t12 * t21
}

/// Roots by bisection, without the root 0 of the rigid motions.
fn roots(f: impl Fn(f64) -> f64) -> Vec<f64> {
    const STEP: f64 = 0.01;
    let grid = (50..).map(|k| STEP * f64::from(k)).take_while(|y| *y < HIGHEST);
    grid.filter(|y| f(*y) * f(y + STEP) < 0.0)
        .map(|y| {
            let (mut low, mut high) = (y, y + STEP);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if f(low) * f(middle) <= 0.0 { high = middle } else { low = middle }
            }
            0.5 * (low + high)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_roots_are_found() {
        // Lamb prints 2.501 for the first torsional mode and 2.640 (0.840 π) for the first spheroidal one at
        // ν = 1/4.
        let torsion = roots(|y| torsional(2, y))[0];
        let spheroid = roots(|y| spheroidal(2, y, (1.0_f64 / 3.0).sqrt()))[0];
        assert!((torsion - 2.501).abs() < 1e-3 && (spheroid - 2.640).abs() < 1e-3, "{torsion} {spheroid}");
    }
}
