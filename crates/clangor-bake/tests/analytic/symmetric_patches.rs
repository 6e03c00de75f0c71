//! The solver of symmetric patches against closed forms: the accelerated sphere at any frequency, ellipsoids
//! at low frequency.

use std::f64::consts::PI;

use clangor_bake::bem::symmetric_patches::SymmetricPatchSolver;
use clangor_bake::radiation::{RadiationSample, RadiationSolver};
use clangor_core::math::radial::reverse_bessel;
use clangor_core::math::spherical_harmonics::{index, solid_harmonics};
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;

/// p e^{sr} of each motion at x, for a body of bounding radius 1.
fn field(sample: &RadiationSample, x: DVec3) -> [Complex64; RIGID_DOFS] {
    let s = Complex64::I * sample.wavenumber;
    let order = (sample.coefficients[0].len() as f64).sqrt() as usize - 1;
    let (mut here, mut there, mut harmonics) = (Vec::new(), Vec::new(), Vec::new());
    let r = x.length();
    reverse_bessel(s, order, &mut here);
    reverse_bessel(s * r, order, &mut there);
    solid_harmonics(x / r, order, &mut harmonics);
    std::array::from_fn(|degree| {
        (0..=order)
            .map(|n| {
                let sum: Complex64 =
                    (n * n..(n + 1) * (n + 1)).map(|i| sample.coefficients[degree][i] * harmonics[i]).sum();
                sum * there[n] / here[n] * r.powi(-(n as i32 + 1))
            })
            .sum()
    })
}

/// p e^{sr} of a unit sphere accelerated along e: cos θ (s/r + 1/r²)/(s² + 2s + 2) e^s.
fn sphere(s: Complex64, e: DVec3, x: DVec3) -> Complex64 {
    let r = x.length();
    s.exp() * (s / r + 1.0 / (r * r)) / (s * s + 2.0 * s + 2.0) * (e.dot(x) / r)
}

const DIRECTIONS: [DVec3; 5] = [
    DVec3::new(1.0, 0.0, 0.0),
    DVec3::new(0.6, 0.0, -0.8),
    DVec3::new(0.48, 0.6, 0.64),
    DVec3::new(-2.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0),
    DVec3::new(0.1, -0.7, 0.707_106_781_186_547_5),
];

#[test]
fn a_sphere_has_its_exact_field_at_any_distance_and_rotations_are_silent() {
    let solver = SymmetricPatchSolver::ellipsoid(DVec3::ONE, 2.75, 1e-4).unwrap();
    let samples = solver.solve(&[0.02, 0.5, 1.0, 1.7, 2.75], 12).unwrap();
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    // Rotation about an axis through c is rotation about the centre and the translation c × α.
    let (centre, alpha) = (DVec3::new(0.3, -0.2, 0.5), DVec3::new(0.4, 1.0, -0.7));
    let moved = centre.cross(alpha);
    for sample in &samples {
        let s = Complex64::I * sample.wavenumber;
        for r in [1.2, 2.0, 8.0, 100.0] {
            let loudest = sphere(s, DVec3::X, r * DVec3::X).norm();
            for direction in DIRECTIONS {
                let x = r * direction;
                let found = field(sample, x);
                for degree in 0..3 {
                    let error = (found[degree] - sphere(s, axes[degree], x)).norm() / loudest;
                    // Residual seen: 7e-8.
                    assert!(error < 1e-5, "{} r = {r} motion {degree}: {error}", sample.wavenumber);
                    // Residual seen: 1e-18.
                    assert!(found[degree + 3].norm() < 1e-7 * loudest);
                }
                let about: Complex64 = (0..3).map(|i| moved[i] * found[i] + alpha[i] * found[i + 3]).sum();
                let error = (about - sphere(s, moved, x)).norm() / loudest;
                assert!(error < 1e-5, "off centre: {error}");
            }
        }
    }
}

#[test]
fn resonances_of_the_interior_do_no_harm() {
    // Zeros of j₀, j₁, j₂, where the equation without growth is singular.
    let resonances = [PI, 4.493_409_457_909, 5.763_459_196_895, 2.0 * PI, 7.725_251_836_938];
    let solver = SymmetricPatchSolver::ellipsoid(DVec3::ONE, 8.0, 1e-3).unwrap();
    for sample in solver.solve(&resonances, 10).unwrap() {
        let s = Complex64::I * sample.wavenumber;
        let exact = sphere(s, DVec3::Z, 2.0 * DVec3::Z);
        let error = (field(&sample, 2.0 * DVec3::Z)[2] - exact).norm() / exact.norm();
        // Residual seen: 1.6e-5.
        assert!(error < 1e-4, "{}: {error}", sample.wavenumber);
    }
}

/// ∫₀^∞ f(λ) dλ by the trapezoidal rule in ln λ.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    (-900..900).map(|k| (f64::from(k) * 0.05).exp()).map(|l| f(l) * l * 0.05).sum()
}

/// Lowest multipole of each motion of an ellipsoid with the longest semi-axis 1, at s = 0.
///
/// Translation along x: with α = abc ∫ dλ/((a²+λ)Δ), Δ² = (a²+λ)(b²+λ)(c²+λ), the added mass is α/(2−α) of
/// the displaced mass m, and p = (m + added mass) x/(4πr³). Rotation about x: p = C yz ∫_λ^∞
/// dλ/((b²+λ)(c²+λ)Δ), far away C yz (2/5) r^{−5}; with χ that integral from 0, the condition ∂p/∂n = −a_n at
/// λ = 0 gives C = (b² − c²)/(2/(abc) − (b² + c²) χ).
///
/// Source: \[Lamb\] §§114, 115.
fn lamb(axes: DVec3) -> [f64; RIGID_DOFS] {
    let square = axes * axes;
    let abc = axes.element_product();
    let delta = |l: f64| (square + l).element_product().sqrt();
    std::array::from_fn(|degree| {
        let i = degree % 3;
        if degree < 3 {
            let alpha = abc * integral(|l| 1.0 / ((square[i] + l) * delta(l)));
            let dipole = 4.0 / 3.0 * PI * abc * (1.0 + alpha / (2.0 - alpha));
            dipole / (4.0 * PI) / (0.75 / PI).sqrt()
        } else {
            let (b, c) = (square[(i + 1) % 3], square[(i + 2) % 3]);
            let chi = integral(|l| 1.0 / ((b + l) * (c + l) * delta(l)));
            (b - c) / (2.0 / abc - (b + c) * chi) * 0.4 / (15.0 / (4.0 * PI)).sqrt()
        }
    })
}

#[test]
fn ellipsoids_have_lambs_added_mass_and_inertia() {
    let places = [index(1, 1), index(1, -1), index(1, 0), index(2, -1), index(2, 1), index(2, -2)];
    for axes in [
        DVec3::new(1.0, 0.5, 0.25),
        DVec3::new(1.0, 1.0, 0.05),
        DVec3::new(1.0, 0.05, 0.05),
        DVec3::new(1.0, 0.8, 0.3),
        DVec3::new(0.2, 1.0, 0.6),
        DVec3::new(0.35, 0.12, 1.0),
    ] {
        let solver = SymmetricPatchSolver::ellipsoid(axes, 0.1, 1e-4).unwrap();
        let samples = solver.solve(&[1e-4], 6).unwrap();
        let exact = lamb(axes);
        for degree in 0..RIGID_DOFS {
            let found = samples[0].coefficients[degree][places[degree]];
            if exact[degree] == 0.0 {
                assert!(found.norm() < 1e-12, "{axes} motion {degree}: {found}");
                continue;
            }
            // The coefficient is that of p e^{sr} on r = 1.
            let s = Complex64::I * samples[0].wavenumber;
            let error = (found / (exact[degree] * s.exp()) - 1.0).norm();
            // Residual seen: 3e-6.
            assert!(error < 2e-4, "{axes} motion {degree}: {error} {found} {}", exact[degree]);
        }
    }
}
