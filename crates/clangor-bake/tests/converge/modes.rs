//! Modes of simple bodies on coarse meshes against fine ones: a free steel bar, a square plate, a ring.
//!
//! There are no closed forms for three-dimensional free bodies with corners. Beam theory is within 1 % for
//! the bar's first mode, and Leissa's plate frequencies are up to 1 % high; the fine meshes here agree with
//! both.

use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_bake::mesh::tetrahedra::cylinder::torus;
use clangor_bake::modal_analysis::eigensolver::solve;
use clangor_core::material::Material;
use clangor_core::material::presets::{GLASS, STEEL};
use glam::DVec3;

/// First ten frequencies \[Hz\].
fn first_ten(mesh: &TetMesh, material: &Material, limit: f64) -> Vec<f64> {
    let constants = ElasticConstants::of(material).expect("an elastic material");
    let modes = solve(&ElasticSystem::new(mesh, &constants), limit).expect("modes");
    assert!(modes.residual < 1e-6, "{}", modes.residual);
    modes.modes.iter().take(10).map(|m| m.frequency).collect()
}

fn worst(frequencies: &[f64], reference: &[f64]) -> f64 {
    assert_eq!(frequencies.len(), reference.len());
    frequencies.iter().zip(reference).map(|(f, r)| (f / r - 1.0).abs()).fold(0.0, f64::max)
}

fn bar(cells: [usize; 3]) -> Vec<f64> {
    let mesh = block(DVec3::new(0.3, 0.03, 0.01), cells).expect("a bar");
    assert!(mesh.nodes.len() <= 4000 || cells[0] > 40, "{}", mesh.nodes.len());
    first_ten(&mesh, &STEEL.material(), BAR_LIMIT)
}

fn plate(cells: [usize; 3]) -> Vec<f64> {
    let mesh = block(DVec3::new(0.25, 0.25, 0.01), cells).expect("a plate");
    assert!(mesh.nodes.len() <= 4000 || cells[0] > 17, "{}", mesh.nodes.len());
    first_ten(&mesh, &GLASS.material(), PLATE_LIMIT)
}

fn ring(across: usize, around: usize) -> Vec<f64> {
    let mesh = torus(0.05, 0.01, across, around).expect("a torus");
    assert!(mesh.nodes.len() <= 4000 || across > 4, "{}", mesh.nodes.len());
    first_ten(&mesh, &STEEL.material(), RING_LIMIT)
}

const BAR_LIMIT: f64 = 9000.0;
const PLATE_LIMIT: f64 = 3500.0;
const RING_LIMIT: f64 = 22000.0;

/// On 120 × 12 × 4 cells.
const BAR: [f64; 10] =
    [574.401, 1573.196, 1671.474, 2948.849, 3055.526, 4354.580, 4989.727, 5920.033, 7343.771, 7958.034];
/// On 30 × 30 × 2 cells.
const PLATE: [f64; 10] =
    [516.129, 751.957, 864.413, 1303.872, 1303.872, 2216.041, 2216.041, 2354.829, 2578.310, 2770.506];
/// On 6 × 6 × 60 cells.
const RING: [f64; 10] = [
    3833.341, 3833.342, 4115.822, 4115.824, 10155.455, 10155.460, 10839.286, 10839.292, 11422.866, 15338.899,
];

#[test]
fn coarse_meshes_are_within_one_percent() {
    let error = worst(&bar([40, 4, 2]), &BAR);
    // Seen: 7.7e-3.
    assert!(error < 0.01, "bar: {error:.2e}");
    let error = worst(&plate([17, 17, 1]), &PLATE);
    // Seen: 9.1e-3.
    assert!(error < 0.01, "plate: {error:.2e}");
    let error = worst(&ring(4, 24), &RING);
    // Seen: 4.4e-3.
    assert!(error < 0.01, "ring: {error:.2e}");
    // Euler and Bernoulli: f₁ = 4.73004² √(E h² / 12 ρ) / (2π L²), 0.2 % above the beam with shear and rotary
    // inertia.
    let thin =
        4.730_04_f64.powi(2) * (2.0e11 * 1e-4 / 12.0 / 7850.0_f64).sqrt() / (std::f64::consts::TAU * 0.09);
    assert!((BAR[0] / thin - 1.0).abs() < 0.01, "{thin}");
}

/// The references above. About a minute: `cargo test --release -p clangor-bake --test converge modes:: --
/// --ignored`.
#[test]
#[ignore = "a minute of CPU time"]
fn fine_meshes_give_the_references() {
    for (name, fine, reference) in
        [("bar", bar([120, 12, 4]), BAR), ("plate", plate([30, 30, 2]), PLATE), ("ring", ring(6, 60), RING)]
    {
        println!("{name}: {fine:.3?}");
        assert!(worst(&fine, &reference) < 1e-5, "{name}: {fine:.4?}");
    }
}
