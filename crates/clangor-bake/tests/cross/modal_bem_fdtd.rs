//! Modes by boundary elements against modes by finite differences, several in one run.

use std::ops::ControlFlow;

use crate::solids::{faces, shape};
use clangor_bake::modal_radiation::bem_transfer::BemModalSolver;
use clangor_bake::modal_radiation::fdtd_transfer::FdtdModalSolver;
use clangor_bake::modal_radiation::surface_modes::SurfaceModes;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;

fn solve(
    solver: &dyn ModalSolver,
    surface: &ModalSurface,
    motions: &[ModalMotion<'_>],
) -> Vec<ModalTransfer> {
    solver.transfers(surface, motions, &mut |_| ControlFlow::Continue(())).expect("a solution")
}

/// Errors of field and power of five motions that stretch, bend and twist, at wavenumbers up to `kappa`/R.
/// The finite differences run several together.
fn compare(name: &str, kappa: f64, spacing: f64, accuracy: f64) -> Vec<[f64; 2]> {
    let mesh = shape(name);
    let surface = faces(&mesh);
    let radius = surface.radius();
    let motions: [fn(DVec3) -> DVec3; 5] = [
        |x| DVec3::new(x.x, -0.5 * x.y, -0.5 * x.z),
        |x| DVec3::new(0.0, x.x * x.z, 0.3 * x.x * x.x - 0.1),
        |x| DVec3::new(-x.y, x.x, 0.0) * x.z,
        |x| DVec3::Z * (2.0 * x.x).cos(),
        |x| x * (1.0 + x.x + 0.5 * x.y),
    ];
    let shapes: Vec<Vec<DVec3>> =
        motions.iter().map(|u| surface.nodes.iter().map(|x| u(*x / radius)).collect()).collect();
    let motion =
        |(i, shape): (usize, &Vec<DVec3>)| (kappa * (0.3 + 0.7 * i as f64 / 4.0) / radius, shape.clone());
    let described: Vec<(f64, Vec<DVec3>)> = shapes.iter().enumerate().map(motion).collect();
    let motions: Vec<ModalMotion<'_>> =
        described.iter().map(|(wavenumber, shape)| ModalMotion { wavenumber: *wavenumber, shape }).collect();
    let highest = kappa / radius;
    let elements = BemModalSolver::try_new(&mesh, highest, accuracy).expect("a mesh");
    let waves = FdtdModalSolver::with_spacing(&mesh, highest, spacing).expect("a grid");
    let (a, b) = (solve(&elements, &surface, &motions), solve(&waves, &surface, &motions));
    let mut errors = Vec::new();
    for ((a, b), motion) in a.iter().zip(&b).zip(&motions) {
        let kappa = motion.wavenumber * radius;
        let (mut wrong, mut size) = (0.0, 0.0);
        for k in 0..80 {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 80.0;
            let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
            let x = 2.0 * DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            let (here, there) = (b.undelayed(x, kappa), a.undelayed(x, kappa));
            wrong += (here - there).norm_sqr();
            size += there.norm_sqr();
        }
        let power = b.power(kappa) / a.power(kappa) - 1.0;
        errors.push([f64::sqrt(wrong / size), power.abs()]);
    }
    errors
}

#[test]
fn modes_of_a_die_sound_alike() {
    let errors = compare("die:0.015x0.003", 4.0, 8e-4, 5e-3);
    for (i, [field, power]) in errors.iter().enumerate() {
        // Residuals seen: 0.5 % and 0.7 %; 3.6 % and 3.4 % of the twist, which radiates from the edges only.
        let bound = if i == 2 { 0.06 } else { 0.015 };
        assert!(*field < bound && *power < bound, "{errors:?}");
    }
}

#[test]
fn the_chooser_takes_elements_where_they_are_few_and_waves_where_they_are_too_many() {
    let key = shape("key");
    let method = |surface: &TriMesh, kappa: f64| {
        let highest = kappa / surface.bounding_radius(DVec3::ZERO);
        SurfaceModes::try_new(surface, highest, 10, 0.03).expect("a method").method()
    };
    assert_eq!(method(&key, 4.0), "boundary elements on triangles");
    let rock = shape("rock:3x0.1");
    assert_eq!(method(&rock, 45.0), "finite differences in time");
}
