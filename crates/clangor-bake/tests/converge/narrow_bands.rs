//! Bands with few modes, whose waves are longer than the parts of the body: cells as large as these waves
//! allow do not resolve its form.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal_analysis::{ModalAnalysis, ModalAnalysisOptions, modal_analysis};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::presets::STEEL;
use glam::DVec3;

fn solved(mesh: &TriMesh, limit: f64, accuracy: f64) -> ModalAnalysis {
    let centred = mesh.relative_to(MassProperties::of(mesh).expect("a solid").centre_of_mass);
    let constants = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
    let options = ModalAnalysisOptions { accuracy, ..ModalAnalysisOptions::to(limit) };
    let geometry = BakeGeometry::of_mesh(&centred);
    modal_analysis(&geometry, &constants, &options, &mut |_| ControlFlow::Continue(())).expect("modes")
}

/// Error below which none is told apart.
const SMALL: f64 = 1e-3;

/// Asserts that each mode is as close to that of a finer solution as both say.
fn assert_within_stated(found: &ModalAnalysis, reference: &ModalAnalysis) {
    assert!(!found.modes.is_empty() && found.modes.len() <= reference.modes.len());
    for (own, finer) in found.modes.iter().zip(&reference.modes) {
        let off = (own.frequency / finer.frequency - 1.0).abs();
        println!("{:.1} Hz: {off:.1e} off, {:.1e} said", finer.frequency, own.mesh_error);
        assert!(
            off <= (own.mesh_error + finer.mesh_error).max(SMALL),
            "{off:.1e} above {:.1e}",
            own.mesh_error
        );
    }
}

/// A tube of triangles around a helix: `sides` corners in each of its sections.
fn spring(turns: usize, sides: usize) -> TriMesh {
    let (radius, wire, pitch, per_turn) = (0.01, 0.001, 0.005, 40);
    let sections = turns * per_turn + 1;
    let mut mesh = TriMesh { vertices: Vec::new(), triangles: Vec::new() };
    for k in 0..sections {
        let angle = TAU * k as f64 / per_turn as f64;
        let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let along = DVec3::new(-radius * angle.sin(), radius * angle.cos(), pitch / TAU).normalize();
        let middle = radius * out + DVec3::Z * (pitch * angle / TAU);
        mesh.vertices.extend((0..sides).map(|side| {
            let around = TAU * side as f64 / sides as f64;
            middle + wire * (around.cos() * out + around.sin() * along.cross(out))
        }));
    }
    let at = |section: usize, side: usize| (section * sides + side % sides) as u32;
    for k in 0..sections - 1 {
        for side in 0..sides {
            let [a, b, c, d] = [at(k, side), at(k + 1, side), at(k + 1, side + 1), at(k, side + 1)];
            mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    for side in 1..sides - 1 {
        let last = sections - 1;
        mesh.triangles.push([at(0, 0), at(0, side + 1), at(0, side)]);
        mesh.triangles.push([at(last, 0), at(last, side), at(last, side + 1)]);
    }
    mesh
}

// Seen: 7.4e-4 off, 3.2e-5 said. With two cells along it and no second grid: 1.3e-1 off, 3.9e-3 said.
#[test]
fn a_coil_spring_to_its_first_modes() {
    let spring = spring(6, 12);
    assert_within_stated(&solved(&spring, 800.0, 0.01), &solved(&spring, 800.0, 1e-5));
}

// Seen: 1.8e-3 off, 3.5e-3 said. Without a second grid: 2.0e-2 off, 8.5e-3 said.
#[test]
fn an_angle_iron_to_its_first_modes() {
    let outline = [[0.0, 0.0], [0.03, 0.0], [0.03, 0.003], [0.003, 0.003], [0.003, 0.03], [0.0, 0.03]];
    let level = |z: f64| outline.map(|[x, y]| DVec3::new(x, y, z));
    let mut angle = TriMesh { vertices: [level(0.0), level(0.3)].concat(), triangles: Vec::new() };
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        angle.triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
    }
    for k in 0..6 {
        let n = (k + 1) % 6;
        angle.triangles.extend([[k, n, n + 6], [k, n + 6, k + 6]]);
    }
    assert_within_stated(&solved(&angle, 1500.0, 0.01), &solved(&angle, 1500.0, 0.003));
}
