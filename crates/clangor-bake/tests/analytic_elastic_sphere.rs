//! A free elastic sphere against the exact roots of Lamb (1881), "On the vibrations of an elastic sphere".
//!
//! With x = ω a / c_L, y = ω a / c_T and spherical Bessel functions j, torsional modes of degree l solve
//!
//! ```text
//! (l − 1) j_l(y) = y j_{l+1}(y)
//! ```
//!
//! and spheroidal ones T₁₁ T₂₂ = T₁₂ T₂₁ with the tractions of the longitudinal and of the transverse wave:
//!
//! ```text
//! T₁₁ = (l² − l − y²/2) j_l(x) + 2 x j_{l+1}(x)     T₁₂ = l (l + 1) [(l − 1) j_l(y) − y j_{l+1}(y)]
//! T₂₁ = (l − 1) j_l(x) − x j_{l+1}(x)               T₂₂ = (l² − 1 − y²/2) j_l(y) + y j_{l+1}(y)
//! ```
//!
//! (Eringen and Suhubi 1975, "Elastodynamics", volume 2, section 8.13); for l = 0, T₁₁ = 0. Each is 2 l + 1 modes.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor::material::Material;
use clangor::material::presets::GLASS;
use clangor_bake::acceleration_noise::BakeGeometry;
use clangor_bake::elasticity::{ElasticConstants, ElasticSystem};
use clangor_bake::modes::solve;
use clangor_bake::tetrahedra::ball::ellipsoid;
use clangor_bake::vibration::{VibrationOptions, vibration};
use glam::DVec3;

const RADIUS: f64 = 0.025;

/// Spherical Bessel function of the first kind, by its power series: x stays below 10.
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

/// Roots of f between 0.5 and 8.
fn roots(f: impl Fn(f64) -> f64) -> Vec<f64> {
    let grid = (0..1500).map(|k| 0.5 + 0.005 * k as f64);
    let bracket = grid.filter(|y| f(*y) * f(y + 0.005) < 0.0);
    bracket
        .map(|y| {
            let (mut low, mut high) = (y, y + 0.005);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if f(low) * f(middle) <= 0.0 { high = middle } else { low = middle }
            }
            0.5 * (low + high)
        })
        .collect()
}

/// Frequencies of a sphere, each as often as it has modes \[Hz\].
fn exact(material: &Material) -> Vec<f64> {
    let nu = material.poisson_ratio;
    let shear_speed = (material.youngs_modulus / (2.0 * (1.0 + nu)) / material.density).sqrt();
    let wave_ratio = ((1.0 - 2.0 * nu) / (2.0 - 2.0 * nu)).sqrt();
    let mut all = Vec::new();
    for l in 0..8 {
        let mut degree = roots(|y| spheroidal(l, y, wave_ratio));
        if l > 0 {
            degree.extend(roots(|y| torsional(l, y)));
        }
        all.extend(degree.into_iter().flat_map(|y| vec![y * shear_speed / (TAU * RADIUS); 2 * l + 1]));
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Largest relative error of the first 20 modes, which must not be out of order by more.
fn worst_error(poisson_ratio: f64, divisions: usize) -> f64 {
    let material = Material { poisson_ratio, ..GLASS.material() };
    let exact = exact(&material);
    let mesh = ellipsoid(DVec3::splat(RADIUS), divisions).expect("a ball");
    assert!(mesh.nodes.len() <= 10_000, "{}", mesh.nodes.len());
    let constants = ElasticConstants::of(&material).expect("an elastic material");
    let modes = solve(&ElasticSystem::new(&mesh, &constants), 1.005 * exact[19]).expect("modes");
    assert!(modes.modes.len() >= 20 && modes.residual < 1e-6, "{} {}", modes.modes.len(), modes.residual);
    modes.modes.iter().zip(&exact).map(|(m, f)| (m.frequency / f - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn known_roots_are_found() {
    let all = |nu: f64| {
        let wave_ratio = ((1.0 - 2.0 * nu) / (2.0 - 2.0 * nu)).sqrt();
        [roots(|y| torsional(2, y))[0], roots(|y| spheroidal(2, y, wave_ratio))[0]]
    };
    // Lamb prints 2.501 for the first torsional mode and 2.640 (0.840 π) for the first spheroidal one at ν = 1/4.
    let [torsion, spheroid] = all(0.25);
    assert!((torsion - 2.501).abs() < 1e-3 && (spheroid - 2.640).abs() < 1e-3, "{torsion} {spheroid}");
}

#[test]
fn the_first_twenty_modes_are_the_exact_ones() {
    for nu in [0.2, 0.34] {
        let error = worst_error(nu, 6);
        // Seen: 3.8e-4, 4.5e-4.
        assert!(error < 1e-3, "nu = {nu}: {error:.2e}");
    }
}

/// Estimated over true errors of the first 20 modes, and the largest true error.
fn estimates(semi_axes: DVec3, accuracy: f64) -> (Vec<f64>, f64) {
    let material = GLASS.material();
    let exact = exact(&material);
    let constants = ElasticConstants::of(&material).expect("an elastic material");
    let geometry = BakeGeometry::Ellipsoid { semi_axes };
    let options = VibrationOptions { accuracy, ..VibrationOptions::to(1.005 * exact[19]) };
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let found = vibration(&geometry, &constants, &options, &mut go_on).expect("modes");
    assert!(found.modes.len() >= 20, "{}", found.modes.len());
    let errors: Vec<f64> = found.modes.iter().zip(&exact).map(|(m, f)| m.frequency / f - 1.0).collect();
    let ratios = found.modes.iter().zip(&errors).map(|(m, e)| m.mesh_error / e).collect();
    (ratios, errors.into_iter().fold(0.0, f64::max))
}

#[test]
fn the_estimated_error_of_tetrahedra_is_the_true_one() {
    // A hair from a body of revolution about y, which would not be filled with tetrahedra.
    let (ratios, worst) = estimates(DVec3::new(RADIUS, RADIUS, RADIUS * (1.0 + 1e-9)), 5e-3);
    // Seen: 0.72 to 0.91, 9e-4.
    assert!(ratios.iter().all(|r| *r > 0.5 && *r < 1.5), "{ratios:.2?}");
    assert!(worst < 5e-3, "{worst:.1e}");
}

#[test]
fn a_section_gives_the_exact_modes() {
    let (ratios, worst) = estimates(DVec3::splat(RADIUS), 1e-5);
    // Seen: 7e-6 on 920 nodes; 1.9 to 2.9.
    assert!(worst < 1e-5, "{worst:.1e}");
    assert!(ratios.iter().all(|r| *r > 0.7 && *r < 10.0), "{ratios:.2?}");
}
