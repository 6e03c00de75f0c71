//! Triangles at many wavenumbers of a band, from tables, against the same systems assembled one by one.

use clangor_bake::bem::triangles::{Equation, TriangleSolver};
use clangor_bake::mesh::remesh::{RemeshOptions, remesh_symmetric};
use clangor_bake::radiation::{RadiationSample, RadiationSolver};
use clangor_core::shape::Shape;
use glam::DVec3;
use num_complex::Complex64;

/// Highest order of the multipoles.
const ORDER: usize = 10;

/// Level errors of the six motions, and of the pressures on the surface.
fn errors(sample: &RadiationSample, exact: &RadiationSample) -> [f64; 2] {
    assert_eq!(sample.wavenumber, exact.wavenumber);
    let norm = |values: &[Complex64]| values.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    let apart = |a: &[Complex64], b: &[Complex64]| {
        norm(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>()) / norm(b)
    };
    let of_motion =
        |s: &RadiationSample, d: usize| s.surface_pressure.iter().map(|p| p[d]).collect::<Vec<_>>();
    let far = (0..3).map(|d| apart(&sample.coefficients[d], &exact.coefficients[d]));
    let near = (0..3).map(|d| apart(&of_motion(sample, d), &of_motion(exact, d)));
    [far.fold(0.0, f64::max), near.fold(0.0, f64::max)]
}

#[test]
fn cross_tables_of_a_band_give_the_systems_assembled_one_by_one() {
    // A cup of unit size, whole and divided by its two mirror planes.
    let cup = Shape::parse("bowl").expect("a shape").mesh();
    let radius = cup.bounding_radius(DVec3::ZERO);
    let options = RemeshOptions::new(0.09 * radius, 0.25 * radius);
    let highest = 7.0 / radius;
    let wavenumbers = [0.05, 0.2, 0.51, 0.83, 1.0].map(|share| share * highest);
    for planes in [vec![], vec![DVec3::X, DVec3::Z]] {
        let (mesh, _) = remesh_symmetric(&cup, &planes, &options).expect("a mesh");
        let single = TriangleSolver::try_symmetric(&mesh, highest, Equation::BurtonMiller).expect("small");
        let exact = single.solve(&wavenumbers, ORDER).expect("finite");
        for error in [1e-3, 1e-5] {
            let swept = single.clone().for_many_wavenumbers(highest, error);
            let found = swept.solve(&wavenumbers, ORDER).expect("finite");
            for (found, exact) in found.iter().zip(&exact) {
                let seen = errors(found, exact);
                // Residuals seen: 0.29 of the error, 0.42 of the smaller one.
                assert!(seen.iter().all(|e| *e < 0.7 * error), "{error:e}: {seen:?}");
            }
            // Below the band nothing is interpolated.
            assert_eq!(found[0], exact[0]);
            // One by one, and in another order, the bits are the same.
            let again = single.clone().for_many_wavenumbers(highest, error);
            for (k, sample) in wavenumbers.iter().zip(&found).rev() {
                assert_eq!(again.solve(&[*k], ORDER).expect("finite")[0], *sample);
            }
        }
    }
}

/// The same for motions of the surface that no rigid motion is, in all parities.
#[test]
fn cross_tables_of_a_band_give_the_transfers_of_systems_assembled_one_by_one() {
    let cup = Shape::parse("bowl").expect("a shape").mesh();
    let radius = cup.bounding_radius(DVec3::ZERO);
    let options = RemeshOptions::new(0.09 * radius, 0.25 * radius);
    let highest = 7.0 / radius;
    for planes in [vec![], vec![DVec3::X, DVec3::Z]] {
        let (mesh, _) = remesh_symmetric(&cup, &planes, &options).expect("a mesh");
        let (whole, _) = mesh.whole();
        let load = |f: &dyn Fn(DVec3) -> f64| whole.vertices.iter().map(|v| f(*v / radius)).collect();
        let loads: [Vec<f64>; 3] = [load(&|x| x.x * x.y), load(&|x| x.z * x.z), load(&|x| x.x * x.z * x.y)];
        let single = TriangleSolver::try_symmetric(&mesh, highest, Equation::BurtonMiller).expect("small");
        for error in [1e-3, 1e-5] {
            let swept = single.clone().for_many_motions(highest, error);
            for share in [0.05, 0.2, 0.51, 0.83, 1.0] {
                let [found, exact] = [&swept, &single].map(|solver| {
                    solver.radiate(share * highest, ORDER, radius, &loads, None).expect("finite")
                });
                let norm = |values: &[Complex64]| values.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
                for (found, exact) in found.iter().zip(&exact) {
                    let off: Vec<Complex64> = found.iter().zip(exact).map(|(a, b)| a - b).collect();
                    let seen = norm(&off) / norm(exact);
                    // Residuals seen: 0.14 of the error, 0.18 of the smaller one.
                    assert!(seen < 0.4 * error, "{error:e} {share}: {seen:e}");
                }
            }
        }
    }
}
