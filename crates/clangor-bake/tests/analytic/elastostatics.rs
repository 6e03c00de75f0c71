//! Stress of free bars and blocks against closed forms: uniform strain, tension, four-point bending.

use clangor_bake::fem::ElasticConstants;
use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_bake::stress::{Deformation, StressBody, StressOptions, SymmetricTensor};
use clangor_core::material::presets::GLASS;
use glam::{DMat3, DVec3};

fn glass() -> ElasticConstants {
    ElasticConstants::of(&GLASS.material()).expect("an elastic material")
}

fn body(mesh: TetMesh) -> StressBody {
    StressBody::new(mesh, &glass(), &StressOptions::default()).expect("a body")
}

/// A block whose inner corners are displaced, so that all elements differ.
fn irregular_block(edges: DVec3, cells: [usize; 3]) -> TetMesh {
    let mesh = block(edges, cells).expect("a block");
    let inside = |x: DVec3| (0..3).all(|a| x[a].abs() < 0.499 * edges[a]);
    let cell = edges / DVec3::from_array(cells.map(|n| n as f64));
    let points = mesh.nodes[..mesh.corners]
        .iter()
        .enumerate()
        .map(|(n, x)| {
            let n = n as f64;
            let away = DVec3::new((3.1 * n).sin(), (4.3 * n).sin(), (5.7 * n).sin());
            if inside(*x) { *x + 0.15 * cell * away } else { *x }
        })
        .collect();
    let elements: Vec<[u32; 4]> = mesh.elements.iter().map(|e| [e[0], e[1], e[2], e[3]]).collect();
    TetMesh::straight(points, &elements).expect("a mesh")
}

fn largest_difference(found: &[SymmetricTensor], exact: SymmetricTensor) -> f64 {
    let difference = |s: &SymmetricTensor| {
        let d = *s + exact * -1.0;
        d.contract(d).sqrt()
    };
    found.iter().map(difference).fold(0.0, f64::max)
}

#[test]
fn uniform_stress_is_found_exactly() {
    let edges = DVec3::new(0.05, 0.04, 0.03);
    let body = body(irregular_block(edges, [4, 3, 3]));
    let stress = SymmetricTensor::of(DMat3::from_cols(
        DVec3::new(3e6, 1e6, -2e6),
        DVec3::new(1e6, -4e6, 0.5e6),
        DVec3::new(-2e6, 0.5e6, 1e6),
    ));
    let found = body.solve_forces(body.traction_forces(|_, n| stress.on(n))).expect("a deformation");
    let scale = stress.contract(stress).sqrt();
    // Residuals seen: 9e-14.
    assert!(largest_difference(&found.corner_stress, stress) < 1e-8 * scale);
    assert!(largest_difference(&found.element_stress, stress) < 1e-8 * scale);
    // Energy density ½ σ : ε.
    let ElasticConstants { lame_lambda, shear_modulus, .. } = glass();
    let spherical = lame_lambda / (3.0 * lame_lambda + 2.0 * shear_modulus);
    let density = (stress.contract(stress) - spherical * stress.trace().powi(2)) / (4.0 * shear_modulus);
    let worst = |w: &[f64]| w.iter().map(|w| (w / density - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst(&found.element_energy_density) < 1e-8 && worst(&found.corner_energy_density) < 1e-8);
    assert!((found.strain_energy / (density * edges.element_product()) - 1.0).abs() < 1e-8);
}

/// A bar along x and its length.
const LENGTH: f64 = 0.12;
const HEIGHT: f64 = 0.01;
const DEPTH: f64 = 0.01;

fn bar(cells: [usize; 3]) -> StressBody {
    body(block(DVec3::new(LENGTH, HEIGHT, DEPTH), cells).expect("a bar"))
}

#[test]
fn a_free_bar_is_pulled() {
    let body = bar([24, 3, 3]);
    let force = 500.0;
    let exact = force / (HEIGHT * DEPTH);
    // Non-uniform tension at both ends: by Saint-Venant's principle it is uniform in the middle.
    let profile = |x: DVec3| 1.5 * (1.0 - (2.0 * x.y / HEIGHT).powi(2));
    let traction = |x: DVec3, n: DVec3| if n.x.abs() > 0.9 { n * exact * profile(x) } else { DVec3::ZERO };
    let found = body.solve_forces(body.traction_forces(traction)).expect("a deformation");
    let pulled = SymmetricTensor { diagonal: DVec3::X * exact, off_diagonal: DVec3::ZERO };
    let middle: Vec<SymmetricTensor> = corners(&body, &found, |x| x.x.abs() < 0.25 * LENGTH);
    // Seen: 1.2e-6.
    let error = largest_difference(&middle, pulled) / exact;
    assert!(error < 5e-3, "{error:.1e}");
    // The bar is mirror-symmetric, and so is its stress: each corner has an image at −x.
    let twin = |x: DVec3| {
        let mirrored = x * DVec3::new(-1.0, 1.0, 1.0);
        let corners = &body.mesh().nodes[..body.mesh().corners];
        corners.iter().position(|y| y.distance(mirrored) < 1e-9).expect("a twin")
    };
    let uneven = |n: usize| {
        let (own, other) = (found.corner_stress[n], found.corner_stress[twin(body.mesh().nodes[n])]);
        (own.diagonal - other.diagonal).abs().max_element() / exact
    };
    let uneven = (0..body.mesh().corners).map(uneven).fold(0.0, f64::max);
    // Seen: 5.7e-12.
    assert!(uneven < 1e-9, "{uneven:.1e}");
}

fn corners(body: &StressBody, found: &Deformation, take: impl Fn(DVec3) -> bool) -> Vec<SymmetricTensor> {
    body.mesh().nodes.iter().zip(&found.corner_stress).filter(|(x, _)| take(**x)).map(|(_, s)| *s).collect()
}

#[test]
fn a_bar_bends_between_four_patches() {
    // Elements of 3⅓ mm; patches of four of them: forces down at the outer ends, up at the inner supports.
    let body = bar([36, 3, 3]);
    let cell = LENGTH / 36.0;
    let total = 200.0;
    let patch = 4.0 * cell;
    let outer = 0.5 * LENGTH - 0.5 * patch;
    let inner = 6.0 * cell;
    let pressure = 0.5 * total / (patch * DEPTH);
    let traction = |x: DVec3, n: DVec3| {
        let within = |at: f64| (x.x.abs() - at).abs() < 0.5 * patch;
        if n.y > 0.9 && within(outer) {
            DVec3::Y * -pressure
        } else if n.y < -0.9 && within(inner) {
            DVec3::Y * pressure
        } else {
            DVec3::ZERO
        }
    };
    let found = body.solve_forces(body.traction_forces(traction)).expect("a deformation");
    let moment = 0.5 * total * (outer - inner);
    let exact = moment * 0.5 * HEIGHT / (DEPTH * HEIGHT.powi(3) / 12.0);
    let span = |x: DVec3| x.x.abs() < inner - 0.5 * patch - 0.5 * HEIGHT;
    let (mut worst, mut checked) = (0.0_f64, 0);
    for (x, stress) in body.mesh().nodes.iter().zip(&found.corner_stress) {
        if span(*x) && x.y.abs() > 0.49 * HEIGHT {
            worst = worst.max((stress.diagonal.x / exact - x.y.signum()).abs());
            checked += 1;
        }
    }
    let tension = found.maximum_tension();
    let place = body.mesh().nodes[tension.corner];
    // Seen: 1.7e-3 over 40 corners, and 3.2e-3 beside a patch.
    assert!(checked > 10 && worst < 0.03, "{worst:.3}");
    assert!((tension.stress / exact - 1.0).abs() < 0.03 && place.y > 0.49 * HEIGHT && place.x.abs() < inner);
}
