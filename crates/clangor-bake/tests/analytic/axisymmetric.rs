//! Axisymmetric bodies against closed forms: the sphere at any frequency, spheroids at low frequency.

use std::f64::consts::PI;

use clangor_bake::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use clangor_bake::radiation::RadiationSolver;
use clangor_core::geometry::meridian::Meridian;
use clangor_core::math::spherical_harmonics::index;
use glam::DVec3;
use num_complex::Complex64;

/// Largest error of all coefficients of a ball of radius a, over a.
fn sphere_error(a: f64, wavenumbers: &[f64], damped: bool) -> f64 {
    let meridian = Meridian::spheroid(a, a).expect("a ball");
    let highest = wavenumbers.iter().copied().fold(0.0, f64::max);
    // Any axis works: the coefficients are in the frame of the body.
    let axis = DVec3::new(0.3, -0.5, 0.8);
    let solver = AxisymmetricSolver::new(&meridian, axis, AxisymmetricOptions::new(highest));
    assert_eq!(solver.is_damped(), damped);
    let mut worst = 0.0_f64;
    for sample in solver.solve(wavenumbers, 5).expect("fields") {
        // p(a) = a cos θ (1 + s)/(2 + 2s + s²), s = ika.
        let s = Complex64::I * sample.wavenumber * a;
        let exact = a * (1.0 + s) / (2.0 + 2.0 * s + s * s) * s.exp() / (0.75 / PI).sqrt();
        for degree in 0..6 {
            for n in 0..=5 {
                for m in -(n as isize)..=n as isize {
                    let own = n == 1 && degree == [1, 2, 0][(m + 1) as usize];
                    let expected = if own { exact } else { Complex64::ZERO };
                    worst = worst.max((sample.coefficients[degree][index(n, m)] - expected).norm() / a);
                }
            }
        }
    }
    worst
}

#[test]
fn a_sphere_radiates_its_exact_dipole_and_does_not_hear_its_spin() {
    // Residual seen: 1.4e-8.
    let error = sphere_error(0.8, &[0.0, 0.01, 1.0, 1.5], false);
    assert!(error < 1e-7, "{error:e}");
}

#[test]
fn a_sphere_is_right_at_the_resonances_of_its_inside() {
    // ka = π, 4.4934 (zeros of j₀ and j₁), 7.7253; residual seen: 8e-7.
    let error = sphere_error(1.0, &[PI, 4.493_409_457_909, 7.725_251_836_937], true);
    println!("resonances: {error:.1e}");
    assert!(error < 1e-5, "{error:e}");
}

/// Lamb's α for motion along and across the axis of a spheroid (Hydrodynamics, §§ 114, 373).
fn lamb(across: f64, along: f64) -> (f64, f64) {
    if along < across {
        let e = (1.0 - (along / across).powi(2)).sqrt();
        let q = (1.0 - e * e).sqrt();
        (2.0 / (e * e) * (1.0 - q / e * e.asin()), q / e.powi(3) * e.asin() - (1.0 - e * e) / (e * e))
    } else {
        let e = (1.0 - (across / along).powi(2)).sqrt();
        let l = ((1.0 + e) / (1.0 - e)).ln();
        let q = 1.0 - e * e;
        (2.0 * q / e.powi(3) * (0.5 * l - e), 1.0 / (e * e) - 0.5 * q / e.powi(3) * l)
    }
}

#[test]
fn spheroids_have_the_added_mass_of_lamb_moving_and_turning() {
    for (across, along) in [(20.0, 1.0), (1.0, 20.0), (1.0, 0.5), (1.0, 1.3)] {
        let meridian = Meridian::spheroid(across, along).expect("a spheroid");
        let solver = AxisymmetricSolver::new(&meridian, DVec3::Y, AxisymmetricOptions::new(1e-6));
        let radius = solver.reference_radius();
        let samples = solver.solve(&[0.0], 3).expect("a field");
        let c = &samples[0].coefficients;
        let volume = 4.0 / 3.0 * PI * across * across * along;
        let (alpha, beta) = lamb(across, along);
        for (degree, alpha) in [(0, beta), (1, alpha), (2, beta)] {
            // Dipole moment V (1 + k), k = α/(2 − α).
            let dipole = volume * 2.0 / (2.0 - alpha) / (4.0 * PI * radius * radius) / (0.75 / PI).sqrt();
            let found = c[degree][index(1, [1, -1, 0][degree])];
            let error = (found - dipole).norm() / dipole;
            // Residual seen: 2.2e-8.
            println!("{across} {along} degree {degree}: {error:.1e}");
            assert!(error < 1e-6, "{across} {along} degree {degree}: {error:e}");
        }
        // Rotation about x: p = D yz on the surface, D from the added inertia. The moment combines p and a_n.
        let (b, c_square) = (along * along, across * across);
        let (sum, gap) = (b + c_square, b - c_square);
        let moment = sum * gap * (beta - alpha) / (2.0 * gap + sum * (alpha - beta)) + gap;
        let quadrupole = (15.0 / (4.0 * PI)).sqrt() * volume * moment / (25.0 * radius.powi(3));
        let error = (c[3][index(2, -1)] - quadrupole).norm() / quadrupole.abs();
        // Residual seen: 2.2e-8.
        println!("{across} {along} turning: {error:.1e}");
        assert!(error < 1e-5, "{across} {along} turning: {error:e} {} {quadrupole}", c[3][index(2, -1)]);
        assert!(c[4].iter().all(|x| *x == Complex64::ZERO), "turning about the axis moves nothing");
    }
}
