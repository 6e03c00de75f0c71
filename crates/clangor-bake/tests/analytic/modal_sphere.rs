//! Vibrating spheres at any frequency, including resonances of the interior, against the closed form.
//!
//! A normal acceleration Y_n makes the pressure p = a Y_n/(n + 1 + s² θₙ₋₁(s)/θₙ(s)), s = ika, on the
//! surface.

use std::f64::consts::PI;

use clangor_bake::bem::axisymmetric::AxisymmetricOptions;
use clangor_bake::bem::axisymmetric::azimuthal::{AzimuthalSolver, RingWave};
use clangor_bake::mesh::tetrahedra::ball::ellipsoid;
use clangor_bake::modal_radiation::axisymmetric::AxisymmetricModalSolver;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_core::geometry::meridian::Meridian;
use clangor_core::math::radial::{outgoing, reverse_bessel};
use clangor_core::math::spherical_harmonics::{count, index, solid_harmonics};
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;
use num_complex::Complex64;

/// ka, with zeros of j₀, j₁, j₂ and j₅ among them.
const WAVENUMBERS: [f64; 16] = [
    0.1,
    0.5,
    1.0,
    2.0,
    PI,
    4.493_409_457_909,
    5.763_459_196_894,
    6.8,
    7.725_251_836_937,
    9.355_812_111_043,
    9.0,
    12.966_530_172_774,
    14.066_193_912_832,
    16.354_709_639_350,
    18.0,
    20.0,
];

/// p/(a Y_n) on the surface.
fn exact(n: usize, ka: f64) -> Complex64 {
    let s = Complex64::new(0.0, ka);
    let mut theta = Vec::new();
    reverse_bessel(s, n, &mut theta);
    let slope = if n == 0 { s } else { s * s * theta[n - 1] / theta[n] };
    1.0 / ((n + 1) as f64 + slope)
}

/// Power of one multipole on the sphere of radius 1.
fn power(n: usize, coefficient: Complex64, wavenumber: f64) -> f64 {
    let mut coefficients = vec![Complex64::ZERO; count(n)];
    coefficients[n * n] = coefficient;
    ModalTransfer { order: n, coefficients }.power(wavenumber)
}

#[test]
fn orders_around_the_axis_radiate_as_they_should() {
    let radius = 0.7;
    let ball = Meridian::spheroid(radius, radius).expect("a ball");
    let solver = AzimuthalSolver::new(&ball, radius, AxisymmetricOptions::new(0.0));
    let mut values = Vec::new();
    let (mut on_surface, mut away) = (0.0_f64, 0.0_f64);
    for ka in WAVENUMBERS {
        let mesh = solver.mesh(ka / radius).expect("panels");
        for (n, m) in [(0, 0), (1, 0), (1, 1), (2, 1), (2, 2), (5, 0), (5, 3), (5, 5)] {
            let accelerations: Vec<f64> = mesh
                .nodes()
                .map(|node| {
                    let x = node.position / radius;
                    solid_harmonics(DVec3::new(x.x, 0.0, x.y), n, &mut values);
                    values[index(n, m as isize)]
                })
                .collect();
            let wave =
                RingWave { wavenumber: ka / radius, order: m, accelerations: vec![accelerations.clone()] };
            let field = solver.solve(&mesh, &[wave]).expect("fields").remove(0).remove(0);
            let expected = exact(n, ka) * radius;
            let loudest = accelerations.iter().map(|a| a.abs()).fold(0.0, f64::max) * expected.norm();
            let gap = field
                .pressure
                .iter()
                .zip(&accelerations)
                .map(|(p, a)| (p - expected * a).norm() / loudest)
                .fold(0.0, f64::max);
            on_surface = on_surface.max(gap);
            let leaving = expected * Complex64::new(0.0, ka).exp();
            let far = (0..field.coefficients.len())
                .map(|i| {
                    let c = field.coefficients[i] - if i == n { leaving } else { Complex64::ZERO };
                    power(i, c, ka).sqrt()
                })
                .sum::<f64>()
                / power(n, leaving, ka).sqrt();
            if 2.0 * ka * ka * power(n, leaving / radius, ka) > 1e-4 {
                away = away.max(far);
            }
            if gap > 1e-5 || far > 1e-5 {
                println!("ka {ka} n {n} m {m}: surface {gap:.1e} away {far:.1e}");
            }
        }
    }
    println!("surface {on_surface:.1e}, away {away:.1e}");
    // Residuals seen: 5.5e-7, 1.1e-6.
    assert!(on_surface < 1e-5 && away < 1e-5, "{on_surface:e} {away:e}");
}

#[test]
fn modes_of_a_sphere_radiate_as_they_should() {
    let mesh = ellipsoid(DVec3::ONE, 8).expect("a mesh");
    let surface = ModalSurface { nodes: mesh.nodes.clone(), triangles: mesh.surface() };
    let ball = Meridian::spheroid(1.0, 1.0).expect("a ball");
    // Any axis works.
    let solver = AxisymmetricModalSolver::new(&ball, DVec3::new(0.48, -0.6, 0.64));
    let mut values = Vec::new();
    let shapes: Vec<(usize, usize, Vec<DVec3>)> = [(0, 0), (1, 1), (1, -1), (2, 0), (5, -3)]
        .map(|(n, m)| {
            let i = index(n, m);
            let shape = surface.nodes.iter().map(|x| {
                solid_harmonics(x.normalize_or(DVec3::X), n, &mut values);
                x.normalize_or_zero() * values[i]
            });
            (n, i, shape.collect())
        })
        .into();
    let mut worst = 0.0_f64;
    for at_first in [0.1, 1.0, 4.493_409_457_909, 9.355_812_111_043, 20.0] {
        // Different frequencies, so that they are not grouped as one degenerate set.
        let apart = |i: usize| at_first * (1.0 + 1e-5 * i as f64);
        let motions: Vec<ModalMotion<'_>> = shapes
            .iter()
            .enumerate()
            .map(|(i, (_, _, shape))| ModalMotion { wavenumber: apart(i), shape })
            .collect();
        let transfers = solver
            .transfers(&surface, &motions, &mut |_| std::ops::ControlFlow::Continue(()))
            .expect("transfers");
        for (motion, (transfer, (n, i, _))) in motions.iter().zip(transfers.iter().zip(&shapes)) {
            let ka = motion.wavenumber;
            let expected = exact(*n, ka) * Complex64::new(0.0, ka).exp();
            let exact_power = power(*n, expected, ka);
            // Efficiency against a piston of the same mean square velocity.
            let efficiency = exact_power * 2.0 * ka * ka;
            let loud = transfer.power(ka) / exact_power - 1.0;
            let at = DVec3::new(1.2, -0.7, 1.6);
            solid_harmonics(at.normalize(), *n, &mut values);
            let mut waves = Vec::new();
            outgoing(Complex64::new(0.0, ka), at.length(), *n, &mut waves);
            let size = expected * waves[*n];
            let field = (transfer.undelayed(at, ka) - size * values[*i]).norm() / size.norm();
            println!("ka {ka} n {n}: field {field:.1e} power {loud:.1e} efficiency {efficiency:.1e}");
            if efficiency > 1e-4 {
                worst = worst.max(field).max(0.5 * loud.abs());
            }
        }
    }
    // Residual seen: 4e-4, of the elements of the surface.
    assert!(worst < 1e-3, "{worst:e}");
}
