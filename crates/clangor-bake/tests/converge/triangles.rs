//! Galerkin boundary elements on successively finer spheres.

use std::f64::consts::PI;

use clangor_bake::bem::triangles::{Equation, TriangleSolver};
use clangor_bake::radiation::RadiationSolver;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_core::sound_model::acceleration::sphere_radiation::{SphereModel, SphereTransfer};
use num_complex::Complex64;

/// Relative error of the pressure on the surface of a sphere moving along z, and the longest edge.
fn surface_error(edge: f64, k: f64) -> (f64, f64) {
    let mut mesh = Shape::parse(&format!("sphere:1@{edge}")).unwrap().mesh();
    let scale = (4.0 / 3.0 * PI / MassProperties::of(&mesh).unwrap().volume).cbrt();
    mesh.vertices.iter_mut().for_each(|v| *v *= scale);
    let solver = TriangleSolver::try_new(&mesh, k, Equation::BurtonMiller).unwrap();
    let sample = &solver.solve(&[k], 2).unwrap()[0];
    let air = Medium { density: 1.0, sound_speed: 1.0 };
    let (mut wrong, mut size) = (0.0, 0.0);
    for (v, p) in mesh.vertices.iter().zip(&sample.surface_pressure) {
        let (re, im) = SphereTransfer::new(SphereModel::Exact, &air, 1.0, 1.0, v.normalize().z).at(k);
        let expected = Complex64::new(re, im);
        wrong += (p[2] - expected).norm_sqr();
        size += expected.norm_sqr();
    }
    ((wrong / size).sqrt(), 1.0 / (mesh.vertices.len() as f64).sqrt())
}

#[test]
fn the_error_falls_with_the_square_of_the_edge() {
    for k in [1.0, 4.4934, 8.0] {
        let rows: Vec<(f64, f64)> =
            [0.39, 0.233, 0.13].into_iter().map(|edge| surface_error(edge, k)).collect();
        let slope = (rows[0].0 / rows[2].0).ln() / (rows[0].1 / rows[2].1).ln();
        // Slopes seen: 1.96, 1.90, 2.6; errors 4e-3 at 812 vertices.
        assert!(slope > 1.8, "{k}: {rows:?}, slope {slope}");
    }
}
