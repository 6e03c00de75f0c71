//! Properties of the modes of any body: rigid motions radiate as acceleration noise does, power at the
//! surface equals power in the far field, a ladder of wavenumbers agrees with direct solves, and there is no
//! spurious flux.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use crate::solids::{faces, shape};
use clangor_bake::bem::triangles::{Equation, TriangleSolver};
use clangor_bake::geometry_class::mirror_symmetry::mirror_planes;
use clangor_bake::mesh::remesh::{RemeshOptions, SymmetricMesh, remesh_symmetric};
use clangor_bake::modal_radiation::bem_transfer::BemModalSolver;
use clangor_bake::modal_radiation::normal_velocity_projection::NormalVelocityProjection;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_bake::radiation::{RadiationError, RadiationSolver};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::{DQuat, DVec3};
use num_complex::Complex64;

fn symmetric(mesh: &TriMesh, min_edge: f64, max_edge: f64) -> SymmetricMesh {
    let planes: Vec<DVec3> = mirror_planes(mesh, 1e-5).iter().map(|plane| plane.normal).collect();
    remesh_symmetric(mesh, &planes, &RemeshOptions::new(min_edge, max_edge)).expect("a mesh").0
}

fn solve(solver: &BemModalSolver, surface: &ModalSurface, motions: &[ModalMotion<'_>]) -> Vec<ModalTransfer> {
    solver.transfers(surface, motions, &mut |_| ControlFlow::Continue(())).expect("a solution")
}

/// Relative difference of coefficients up to the lower order.
fn apart(a: &[Complex64], b: &[Complex64]) -> f64 {
    let wrong: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
    let size: f64 = b.iter().map(|b| b.norm_sqr()).sum();
    (wrong / size).sqrt()
}

#[test]
fn rigid_translations_sound_as_acceleration_noise() {
    for (name, edges, reach, bound) in
        [("die:0.015x0.003", [7e-4, 1e-3], 3.0, 1e-3), ("key", [6e-4, 1.5e-3], 3.0, 1e-3)]
    {
        let mesh = shape(name);
        let acoustic = symmetric(&mesh, edges[0], edges[1]);
        let surface = faces(&mesh);
        let radius = surface.radius();
        let wavenumber = reach / radius;
        let rigid =
            TriangleSolver::try_symmetric(&acoustic, wavenumber, Equation::BurtonMiller).expect("small");
        let sample = rigid.solve(&[wavenumber], 12).expect("a solution").remove(0);
        let own = rigid.reference_radius();
        let solver = BemModalSolver::on(acoustic);
        for (axis, direction) in DVec3::AXES.into_iter().enumerate() {
            let shape = vec![direction; surface.nodes.len()];
            let transfer = solve(&solver, &surface, &[ModalMotion { wavenumber, shape: &shape }]).remove(0);
            let at = 1.7 * radius;
            let expected = ModalTransfer {
                order: 12,
                coefficients: sample.coefficients[axis].iter().map(|c| c / own).collect(),
            };
            // At the same places, whatever sphere normalises the multipoles.
            let (mut wrong, mut size) = (0.0, 0.0);
            for k in 0..60 {
                let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 60.0;
                let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
                let x = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z) * at;
                let here = transfer.undelayed(x / radius, wavenumber * radius) * radius;
                let there = expected.undelayed(x / own, wavenumber * own) * own;
                wrong += (here - there).norm_sqr();
                size += there.norm_sqr();
            }
            let seen = f64::sqrt(wrong / size);
            // Residuals seen: 3.3e-4 for the die, and below 1e-3 for the key, whose bound is 1e-3.
            assert!(seen < bound, "{name} {axis}: {seen:e}");
        }
    }
}

#[test]
fn power_leaves_the_surface_as_it_arrives() {
    let mesh = shape("box:0.03x0.02x0.012");
    let acoustic = symmetric(&mesh, 1.6e-3, 2.5e-3);
    let surface = faces(&mesh);
    let (whole, _) = acoustic.whole();
    let radius = surface.radius();
    let wavenumber = 3.0 / radius;
    // Bending without a parity.
    let motion =
        |x: DVec3| (40.0 * x.x + 0.7).sin() * DVec3::Z + DVec3::new(0.3, 0.2 * (150.0 * x.z).cos(), 0.0);
    let shape: Vec<DVec3> = surface.nodes.iter().map(|x| motion(*x)).collect();
    let solver = BemModalSolver::on(acoustic);
    let transfer = solve(&solver, &surface, &[ModalMotion { wavenumber, shape: &shape }]).remove(0);
    let far = transfer.power(wavenumber * radius) * radius.powi(4);
    let direct = TriangleSolver::try_new(&whole, wavenumber, Equation::BurtonMiller).expect("small");
    let accelerations: Vec<[f64; 3]> = (0..whole.triangles.len())
        .map(|t| whole.corners(t).map(|x| motion(x).dot(whole.area_vector(t).normalize())))
        .collect();
    let pressures = direct.surface_pressure(wavenumber, &accelerations).expect("a solution");
    // ½ ∫ Re(p v*) dS with v = a/(ikc), over both linear on each triangle.
    let near: f64 = (0..whole.triangles.len())
        .map(|t| {
            let p = whole.triangles[t].map(|v| pressures[v as usize].im);
            let a = accelerations[t];
            let total: f64 = (0..3).map(|i| p[i] * (a.iter().sum::<f64>() + a[i])).sum();
            -0.5 * total / 12.0 * whole.area_vector(t).length() / wavenumber
        })
        .sum();
    // Residual seen: 7e-4; with triangles of 0.8 to 1.5 mm 1e-4.
    assert!((near / far - 1.0).abs() < 2e-3, "{near:e} {far:e}");
}

#[test]
fn a_ladder_gives_what_the_wavenumbers_of_the_modes_do() {
    let mesh = shape("key");
    let acoustic = symmetric(&mesh, 1.4e-3, 2.9e-3);
    let surface = faces(&mesh);
    let radius = surface.radius();
    let count = 40;
    let shapes: Vec<Vec<DVec3>> = (0..count)
        .map(|i| {
            let bend = TAU * f64::from(i + 4) / 12.0 / radius;
            surface.nodes.iter().map(|x| (bend * x.x).cos() * DVec3::new(0.1, 0.5, 1.0)).collect()
        })
        .collect();
    let motion = |i: usize| ModalMotion {
        wavenumber: (0.6 + 7.4 * i as f64 / f64::from(count)) / radius,
        shape: &shapes[i],
    };
    let solver = BemModalSolver::on(acoustic);
    let motions: Vec<ModalMotion<'_>> = (0..shapes.len()).map(motion).collect();
    let together = solve(&solver, &surface, &motions);
    let mut worst = 0.0_f64;
    for i in [0, 7, 18, 29, 39] {
        let alone = solve(&solver, &surface, &motions[i..=i]).remove(0);
        let error = apart(&together[i].coefficients, &alone.coefficients);
        worst = worst.max(error);
    }
    // Residual seen: 1e-4.
    assert!(worst < 1e-3, "{worst}");
}

/// U = A x with trace A = 0 has no net flux. On a coarse mesh without symmetry, whose faces lie below the
/// sphere, it appears to have one: a monopole, stronger at low frequency than the true quadrupole.
#[test]
fn false_flux_is_not_heard() {
    let sphere = shape("sphere:1@0.3");
    let mut coarse = shape("sphere:1@0.5");
    coarse.vertices.iter_mut().for_each(|x| {
        let moved = *x + 0.15 * DVec3::new((3.0 * x.y).sin(), (2.0 * x.z + 0.4).cos(), (4.0 * x.x).sin());
        *x = moved.normalize();
    });
    let surface = faces(&coarse);
    let rotation = DQuat::from_scaled_axis(DVec3::new(0.3, -0.8, 0.5));
    let stretch = |x: DVec3| rotation * (DVec3::new(1.0, -1.0, 0.0) * (rotation.inverse() * x));
    let shape: Vec<DVec3> = surface.nodes.iter().map(|x| stretch(*x)).collect();
    let operator = NormalVelocityProjection::new(&surface, &sphere).expect("loads");
    let kappa = 0.05;
    let solver = TriangleSolver::try_new(&sphere, kappa, Equation::BurtonMiller).expect("small");
    let power = |loads: Vec<f64>| {
        let coefficients = solver.radiate(kappa, 4, 1.0, &[loads], None).expect("a solution").remove(0);
        ModalTransfer { order: 4, coefficients }.power(kappa)
    };
    // U·n is a harmonic of n = 2, with ∫ (U·n)² dΩ = 16π/15.
    let s = Complex64::new(0.0, kappa);
    let slope = -s - 3.0 + s * (2.0 * s + 3.0) / (s * s + 3.0 * s + 3.0);
    let mut coefficients = vec![Complex64::ZERO; 9];
    coefficients[6] = (TAU * 8.0 / 15.0).sqrt() / slope;
    let exact = ModalTransfer { order: 2, coefficients }.power(kappa);
    let (with, without) = (power(operator.of(&shape)) / exact, power(operator.interpolated(&shape)) / exact);
    // Seen: 0.89, for a body whose faces lie below the sphere, and 26.
    assert!((with - 1.0).abs() < 0.25 && without > 2.0, "{with} {without}");
}

#[test]
fn bad_input_and_interruption_are_errors() {
    let sphere = shape("sphere:1@0.5");
    let solver = BemModalSolver::try_new(&sphere, 1.0, 0.05).expect("a mesh");
    let surface = faces(&sphere);
    let shape = vec![DVec3::X; surface.nodes.len()];
    let motions = [ModalMotion { wavenumber: 1.0, shape: &shape }];
    let stopped = solver.transfers(&surface, &motions, &mut |_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(RadiationError::Interrupted));
    let mut go_on = |_| ControlFlow::Continue(());
    let nothing = ModalSurface { nodes: surface.nodes.clone(), triangles: Vec::new() };
    assert_eq!(solver.transfers(&nothing, &motions, &mut go_on), Err(RadiationError::Empty));
    let other = solver.transfers(&ModalSurface::default(), &motions, &mut go_on);
    assert_eq!(other, Err(RadiationError::Shape { given: shape.len(), nodes: 0 }));
    let fast = [ModalMotion { wavenumber: 1e3, shape: &shape }];
    let refused = solver.transfers(&surface, &fast, &mut go_on);
    assert!(matches!(refused, Err(RadiationError::Orders { .. })));
    let open = TriMesh { vertices: sphere.vertices.clone(), triangles: sphere.triangles[1..].to_vec() };
    assert!(BemModalSolver::try_new(&open, 1.0, 0.05).is_err());
    assert!(BemModalSolver::try_new(&sphere, f64::NAN, 0.05).is_err());
    assert!(solve(&solver, &surface, &[]).is_empty());
}

#[test]
fn few_motions_and_many_have_the_same_multipoles() {
    const ORDER: usize = 4;
    let mesh = shape("ellipsoid:0.03x0.02x0.011@0.008");
    let (k, radius) = (150.0, 0.03);
    let solver = TriangleSolver::try_new(&mesh, k, Equation::BurtonMiller).expect("small");
    let load = |motion: usize| -> Vec<f64> {
        (0..mesh.vertices.len()).map(|v| ((v * (motion + 2)) as f64).sin() * 1e-5).collect()
    };
    // Three motions are solved for themselves; more than there are harmonics, for the harmonics.
    let few: Vec<Vec<f64>> = (0..3).map(load).collect();
    let many: Vec<Vec<f64>> = few.iter().cycle().take((ORDER + 1).pow(2) + 2).cloned().collect();
    let harmonics = solver.surface_harmonics(ORDER + 2, radius).expect("little memory");
    let by_motion = solver.radiate(k, ORDER, radius, &few, None).expect("finite");
    let by_harmonic = solver.radiate(k, ORDER, radius, &many, Some(&harmonics)).expect("finite");
    for (a, b) in by_motion.iter().zip(&by_harmonic) {
        // Solutions in single precision.
        assert!(apart(a, b) < 3e-5, "{:.1e}", apart(a, b));
    }
    // Harmonics that are kept are those computed on the way.
    let kept = solver.radiate(k, ORDER, radius, &few, Some(&harmonics)).expect("finite");
    for (a, b) in by_motion.iter().zip(&kept) {
        assert!(apart(a, b) < 1e-7, "{:.1e}", apart(a, b));
    }
}

#[test]
fn a_turned_body_sounds_the_same_on_any_number_of_threads() {
    // With mirror planes off the axes, so that multipoles are rotated, and orders that differ.
    let mut mesh = shape("key");
    mesh.vertices
        .iter_mut()
        .for_each(|v| *v = DQuat::from_rotation_x(0.4) * (DQuat::from_rotation_z(0.7) * *v));
    let acoustic = symmetric(&mesh, 1e-3, 2.5e-3);
    let surface = faces(&mesh);
    let shape = vec![DVec3::X; surface.nodes.len()];
    let reaches = [0.5, 1.0, 2.0, 3.0, 4.0, 6.0];
    let motions = reaches.map(|reach| ModalMotion { wavenumber: reach / surface.radius(), shape: &shape });
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| solve(&BemModalSolver::on(acoustic.clone()), &surface, &motions))
    };
    let one = with(1);
    assert!(one.iter().any(|transfer| transfer.order != one[0].order));
    assert!(one == with(3));
}
