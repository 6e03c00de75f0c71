//! Properties of every spectrum: complete (Sturm count), small residuals, orthonormal shapes, independent of
//! the body's position and of the slicing of the band.

use clangor_bake::fem::{ElasticConstants, ElasticError, ElasticSystem};
use clangor_bake::mesh::tetrahedra::{TetMesh, shape_mesh};
use clangor_bake::modal_analysis::eigensolver::{ModalError, Modes, solve};
use clangor_core::material::presets::{CERAMIC, STEEL};
use clangor_core::shape::Shape;
use glam::{DQuat, DVec3};

fn system(mesh: &TetMesh) -> ElasticSystem {
    ElasticSystem::new(mesh, &ElasticConstants::of(&CERAMIC.material()).expect("an elastic material"))
}

fn mesh(text: &str, edge: f64) -> TetMesh {
    shape_mesh(&Shape::parse(text).expect("a shape"), edge).expect("a mesh")
}

/// The counts at all factorisations are those of the modes returned, and residuals are small.
fn check(name: &str, system: &ElasticSystem, modes: &Modes) {
    for (frequency, count) in &modes.counts {
        let found = modes.modes.iter().filter(|m| m.frequency < *frequency).count();
        assert_eq!(found, *count, "{name} at {frequency} Hz");
    }
    // Largest seen: 2.9e-8.
    assert!(modes.residual < 1e-6, "{name}: {:.1e}", modes.residual);
    // Every tenth mode against all others: wᵀM u is 1 or 0.
    let flat = |shape: &[DVec3]| -> Vec<f64> { shape.iter().flat_map(|u| u.to_array()).collect() };
    let mut heavy = vec![0.0; 3 * system.node_count()];
    for (i, mode) in modes.modes.iter().enumerate().step_by(10) {
        system.multiply_mass(&flat(&mode.shape), 1, &mut heavy);
        for (j, other) in modes.modes.iter().enumerate() {
            let product: f64 = flat(&other.shape).iter().zip(&heavy).map(|(x, y)| x * y).sum();
            let expected = if i == j { 1.0 } else { 0.0 };
            // Largest seen: 4e-9.
            assert!((product - expected).abs() < 1e-6, "{name}: {i} {j} {product:.2e}");
        }
    }
}

#[test]
fn every_counted_mode_is_found() {
    // Shape, element [m], limit [Hz].
    let bodies = [
        ("sphere:0.03", 0.015, 130e3),
        ("sphere:0.03", 0.010, 110e3),
        ("ellipsoid:0.03x0.03x0.02", 0.015, 120e3),
        ("ellipsoid:0.03x0.02x0.015", 0.015, 120e3),
        ("box:0.05x0.05x0.05", 0.0125, 80e3),
        ("box:0.05x0.04x0.03", 0.0125, 80e3),
        ("box:0.2x0.004x0.2", 0.02, 8e3),
        ("box:0.2x0.004x0.15", 0.02, 8e3),
        ("box:0.3x0.03x0.01", 0.015, 20e3),
        ("box:0.2x0.01x0.01", 0.01, 40e3),
        ("die:0.04x0", 0.01, 120e3),
        ("cylinder:0.05x0.005", 0.0125, 30e3),
        ("cylinder:0.01x0.1", 0.01, 80e3),
        ("cylinder:0.03x0.03", 0.015, 80e3),
        ("cylinder:0.02x0.002", 0.005, 60e3),
        ("coin", 0.003, 100e3),
        ("torus:0.04x0.01", 0.01, 40e3),
        ("torus:0.04x0.004", 0.004, 30e3),
        ("prism:5x0.03x0.02", 0.015, 80e3),
        ("rock:3x0.03", 0.015, 80e3),
        ("shard:1x0.05", 0.004, 30e3),
    ];
    for (text, edge, limit) in bodies {
        let system = system(&mesh(text, edge));
        let modes = solve(&system, limit).unwrap_or_else(|e| panic!("{text}: {e}"));
        check(text, &system, &modes);
    }
}

/// Ten CPU seconds: `cargo test --release -p clangor-bake --test property modes:: -- --ignored`.
#[test]
#[ignore = "ten seconds of CPU time"]
fn a_plate_with_hundreds_of_modes_is_complete() {
    let system = system(&mesh("box:0.4x0.004x0.4", 0.02));
    let modes = solve(&system, 40e3).expect("modes");
    assert!(modes.modes.len() >= 500, "{}", modes.modes.len());
    check("pane", &system, &modes);
}

#[test]
fn frequencies_do_not_depend_on_place_or_cut() {
    let original = mesh("box:0.05x0.04x0.03", 0.0125);
    let mut moved = original.clone();
    let turn = DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(-0.4);
    moved.nodes.iter_mut().for_each(|x| *x = turn * *x + DVec3::new(1.0, -2.0, 0.5));
    let frequencies = |mesh: &TetMesh, limit: f64| -> Vec<f64> {
        let modes = solve(&system(mesh), limit).expect("modes");
        modes.modes.iter().map(|m| m.frequency).collect()
    };
    let (a, b, c) = (frequencies(&original, 8e4), frequencies(&moved, 8e4), frequencies(&original, 1.2e5));
    assert!(a.len() == b.len() && a.len() < c.len());
    for ((a, b), c) in a.iter().zip(&b).zip(&c) {
        // Seen: 5e-11.
        assert!((a / b - 1.0).abs() < 1e-8 && (a / c - 1.0).abs() < 1e-8, "{a} {b} {c}");
    }
}

#[test]
fn bad_input_is_refused() {
    let system = system(&mesh("box:0.05x0.04x0.03", 0.025));
    assert!(matches!(solve(&system, f64::NAN), Err(ModalError::Frequency(_))));
    let Err(ModalError::Silent { first, .. }) = solve(&system, 100.0) else { panic!("modes below 100 Hz") };
    let modes = solve(&system, 1.01 * first).expect("modes");
    assert!((modes.modes[0].frequency / first - 1.0).abs() < 1e-6);
    let mut material = STEEL.material();
    material.poisson_ratio = 0.5;
    assert_eq!(ElasticConstants::of(&material), Err(ElasticError::PoissonRatio(0.5)));
    material.density = 0.0;
    assert_eq!(ElasticConstants::of(&material), Err(ElasticError::Density(0.0)));
    let [a, b] = [0.0, 3.0].map(|x| [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p + DVec3::X * x));
    let loose = TetMesh::straight([a, b].concat(), &[[0, 1, 2, 3], [4, 5, 6, 7]]).expect("two tetrahedra");
    assert_eq!(loose.parts(), 2);
    let constants = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
    assert!(solve(&ElasticSystem::new(&loose, &constants), 1e3).is_err());
}
