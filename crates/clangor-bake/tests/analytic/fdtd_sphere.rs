//! The time-domain solver on a sphere, compared with the exact field from 100 Hz to 20 kHz (for a ball of 7.5
//! mm).

use std::f64::consts::PI;
use std::ops::ControlFlow;

use clangor_bake::fdtd::{Boundary, WaveOptions, WaveSolver};
use clangor_bake::radiation::RadiationSample;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::radial::reverse_bessel;
use clangor_core::math::spherical_harmonics::{count, index};
use clangor_core::medium::Medium;
use clangor_core::shape::{Form, Shape};
use clangor_core::sound_model::acceleration::sphere_radiation::{SphereModel, SphereTransfer};
use glam::DVec3;
use num_complex::Complex64;

const ORDER: usize = 8;
const WAVENUMBERS: [f64; 8] = [0.0137, 0.1, 0.5, 1.0, 1.5, 2.0, 2.4, 2.75];
/// Coefficient of the dipole of each translation.
const DIPOLES: [(usize, isize); 3] = [(1, 1), (1, -1), (1, 0)];

/// A sphere of radius 1; the facets take 5e-5 of its volume.
fn sphere(middle: DVec3) -> TriMesh {
    let mut mesh = Shape::try_new(Form::Sphere { radius: 1.0 }, Some(0.02)).unwrap().mesh();
    mesh.vertices.iter_mut().for_each(|v| *v += middle);
    mesh
}

fn run(mesh: &TriMesh, cells_per_unit: f64, boundary: Boundary) -> Vec<RadiationSample> {
    let spacing = 1.0 / cells_per_unit;
    let options = WaveOptions { max_wavenumber: 2.75, spacing, order: ORDER, boundary, longest: 8.0 };
    let solver = WaveSolver::try_new(mesh, options).unwrap();
    solver.run(&|_| ControlFlow::Continue(())).unwrap().samples(&WAVENUMBERS, ORDER)
}

/// Root mean square over the sphere of radius 1.5 R, up to a factor.
fn size(coefficients: &[Complex64], kr: f64) -> f64 {
    let (mut there, mut here) = (vec![], vec![]);
    let s = Complex64::new(0.0, kr);
    reverse_bessel(1.5 * s, ORDER, &mut there);
    reverse_bessel(s, ORDER, &mut here);
    let term = |i: usize| {
        let n = i.isqrt();
        (coefficients[i] * there[n] / here[n] * 1.5_f64.powi(-(n as i32 + 1))).norm_sqr()
    };
    (0..count(ORDER)).map(term).sum::<f64>().sqrt()
}

fn exact(k: f64) -> Complex64 {
    let unit = Medium { density: 1.0, sound_speed: 1.0 };
    let (re, im) = SphereTransfer::new(SphereModel::Exact, &unit, 1.0, 1.0, 1.0).at(k);
    Complex64::new(re, im) * Complex64::new(0.0, k).exp() / (0.75 / PI).sqrt()
}

/// Largest relative error of the three translations at any wavenumber.
fn error(samples: &[RadiationSample]) -> f64 {
    let mut worst = 0.0_f64;
    for (k, sample) in WAVENUMBERS.iter().zip(samples) {
        for (coefficients, (n, m)) in sample.coefficients.iter().zip(DIPOLES) {
            let mut difference = coefficients.clone();
            difference[index(n, m)] -= exact(*k);
            worst = worst.max(size(&difference, *k) / size(coefficients, *k));
        }
    }
    worst
}

#[test]
fn cut_cells_are_accurate_and_of_second_order() {
    let errors = [5.3, 8.0, 12.0].map(|cells| {
        let samples = run(&sphere(DVec3::ZERO), cells, Boundary::CutCells);
        for (k, sample) in WAVENUMBERS.iter().zip(&samples) {
            for rotation in &sample.coefficients[3..] {
                // Rotation radiates nothing. Residual seen: 4e-6, rounding of f32 and of the facets.
                assert!(size(rotation, *k) < 1e-4 * size(&sample.coefficients[0], *k));
            }
        }
        error(&samples)
    });
    // Seen: 0.43 %, 0.19 %, 0.10 %.
    assert!(errors[1] < 3e-3, "{errors:?}");
    let slope = (errors[0] / errors[2]).ln() / f64::ln(12.0 / 5.3);
    // Seen: 1.805.
    assert!(slope > 1.8, "{slope} {errors:?}");
}

#[test]
fn staircases_are_several_per_cent_wrong() {
    let error = error(&run(&sphere(DVec3::ZERO), 8.0, Boundary::Staircase));
    // Seen: 9.1 %.
    assert!((0.03..0.2).contains(&error), "{error}");
}

#[test]
fn rotation_about_a_point_off_centre_is_a_translation() {
    let middle = DVec3::new(0.4, 0.0, 0.3);
    let samples = run(&sphere(middle), 6.0, Boundary::CutCells);
    for (k, sample) in WAVENUMBERS.iter().zip(&samples) {
        let translations = &sample.coefficients;
        for axis in 0..3 {
            // e × d of a rotation about the origin.
            let shift = DVec3::AXES[axis].cross(middle);
            let expected: Vec<Complex64> = (0..count(ORDER))
                .map(|i| (0..3).map(|a| shift[a] * translations[a][i]).sum::<Complex64>())
                .collect();
            let difference: Vec<Complex64> =
                expected.iter().zip(&sample.coefficients[3 + axis]).map(|(a, b)| a - b).collect();
            let largest = size(&translations[0], 1.5 * k);
            // Residual seen: 3.6e-6.
            assert!(size(&difference, 1.5 * k) < 1e-4 * largest, "{k} {axis}");
        }
    }
}

#[test]
fn a_shell_of_half_a_cell_lets_nothing_through() {
    let mut shell = sphere(DVec3::ZERO);
    let first = shell.vertices.len() as u32;
    let inside: Vec<DVec3> = shell.vertices.iter().map(|v| 0.94 * *v).collect();
    let flipped: Vec<[u32; 3]> =
        shell.triangles.iter().map(|[a, b, c]| [a + first, c + first, b + first]).collect();
    shell.vertices.extend(inside);
    shell.triangles.extend(flipped);
    let spacing = 1.0 / 8.0;
    let options = WaveOptions {
        max_wavenumber: 2.75,
        spacing,
        order: ORDER,
        boundary: Boundary::CutCells,
        longest: 8.0,
    };
    let solver = WaveSolver::try_new(&shell, options).unwrap();
    assert!(solver.closed_cells() > 100);
    let samples = solver.run(&|_| ControlFlow::Continue(())).unwrap().samples(&WAVENUMBERS, ORDER);
    // A leak would be strongest at the resonance of the interior, k = 2.2. Remainder: the wall is up to a
    // cell thicker. Seen: 0.16.
    assert!(error(&samples) < 0.2, "{}", error(&samples));
}
