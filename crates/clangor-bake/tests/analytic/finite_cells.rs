//! Thin walls in cells larger than the wall: closed forms, sections, and plates turned against the grid.

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::geometry_class::solver_choice::ModalChoice;
use clangor_bake::modal_analysis::{
    ModalAnalysis, ModalAnalysisError, ModalAnalysisOptions, modal_analysis, modal_analysis_by,
};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::presets::{CERAMIC, GLASS, Preset, STEEL};
use clangor_core::shape::Shape;
use glam::{DQuat, DVec3};

/// A named shape about its centre of mass.
fn shape(text: &str) -> TriMesh {
    let mesh = Shape::parse(text).expect("a shape").mesh();
    let centre = MassProperties::of(&mesh).expect("a solid").centre_of_mass;
    mesh.relative_to(centre)
}

fn in_cells(
    mesh: &TriMesh,
    preset: &Preset,
    limit: f64,
    accuracy: f64,
) -> Result<ModalAnalysis, ModalAnalysisError> {
    let constants = ElasticConstants::of(&preset.material()).expect("an elastic material");
    let options = ModalAnalysisOptions { accuracy, ..ModalAnalysisOptions::to(limit) };
    let choice = ModalChoice::Cells(Cow::Borrowed(mesh));
    modal_analysis_by(choice, &constants, &options, &mut |_| ControlFlow::Continue(()))
}

fn by_default(geometry: &BakeGeometry, preset: &Preset, limit: f64, accuracy: f64) -> ModalAnalysis {
    let constants = ElasticConstants::of(&preset.material()).expect("an elastic material");
    let options = ModalAnalysisOptions { accuracy, ..ModalAnalysisOptions::to(limit) };
    modal_analysis(geometry, &constants, &options, &mut |_| ControlFlow::Continue(())).expect("modes")
}

/// A pipe of inner and outer radius and length \[m\] along z, of flat sides.
fn pipe([inner, outer]: [f64; 2], length: f64, sides: u32) -> TriMesh {
    let ring = |radius: f64, z: f64| {
        (0..sides).map(move |k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
            DVec3::new(radius * cos, radius * sin, z)
        })
    };
    let (low, high) = (-0.5 * length, 0.5 * length);
    let profile = [(outer, low), (outer, high), (inner, high), (inner, low)];
    let vertices = profile.iter().flat_map(|(radius, z)| ring(*radius, *z)).collect();
    let mut triangles = Vec::new();
    for p in 0..4 {
        for k in 0..sides {
            let next = (k + 1) % sides;
            let at = |p: u32, k: u32| (p % 4) * sides + k;
            triangles.push([at(p, k), at(p, next), at(p + 1, k)]);
            triangles.push([at(p, next), at(p + 1, next), at(p + 1, k)]);
        }
    }
    TriMesh { vertices, triangles }
}

fn turned(mesh: &TriMesh) -> TriMesh {
    let turn = DQuat::from_scaled_axis(DVec3::new(0.6, 0.9, 0.4));
    TriMesh { vertices: mesh.vertices.iter().map(|v| turn * *v).collect(), ..mesh.clone() }
}

/// ω² = n² (n² − 1)² / (n² + 1) E t² / (12 ρ R⁴) in the plane of the ring. Source: Timoshenko, Vibration
/// problems in engineering.
#[test]
fn a_thin_ring_in_cells_of_twenty_walls_rings_as_a_bent_bar() {
    let steel = STEEL.material();
    let ring = pipe([0.0295, 0.03], 0.004, 256);
    let found = in_cells(&ring, &STEEL, 2000.0, 0.003).expect("modes");
    let exact = |n: f64| {
        let shape = n * (n * n - 1.0) / (n * n + 1.0).sqrt();
        let bending = 0.0005 * (steel.youngs_modulus / (12.0 * steel.density)).sqrt() / 0.02975_f64.powi(2);
        shape * bending / TAU
    };
    // Out of the plane a ring of this section rings elsewhere; both modes of each order are among the found.
    for n in [2.0, 3.0] {
        let near = found.modes.iter().filter(|mode| (mode.frequency / exact(n) - 1.0).abs() < 3e-3).count();
        let frequencies: Vec<f64> = found.modes.iter().map(|mode| mode.frequency).collect();
        // Seen: 1.1e-3.
        assert!(near == 2, "{} Hz: {frequencies:.2?}", exact(n));
    }
    assert!(found.nodes < 4000, "{}", found.nodes);
}

/// Frequencies in cells against those on the section.
fn against_section(name: &str, preset: &Preset, limit: f64, accuracy: f64) -> (ModalAnalysis, f64) {
    let geometry = BakeGeometry::of_mesh(&shape(name));
    assert!(geometry.axisymmetry().is_some(), "{name}");
    let section = by_default(&geometry, preset, limit, 1e-3);
    let cells = in_cells(&shape(name), preset, limit, accuracy).expect("modes");
    assert_eq!(cells.modes.len(), section.modes.len(), "{name}");
    let error = |(a, b): (&_, &_)| -> f64 {
        let of = |mode: &clangor_core::sound_model::modal::model::ModalMode| mode.frequency;
        (of(a) / of(b) - 1.0_f64).abs()
    };
    let worst = cells.modes.iter().zip(&section.modes).map(error).fold(0.0, f64::max);
    println!("{name}: {} modes, {} nodes, worst {worst:.1e}", cells.modes.len(), cells.nodes);
    (cells, worst)
}

#[test]
fn a_disc_of_a_millimetre_agrees_with_its_section() {
    let (cells, worst) = against_section("coin:0.05x0.001@0.001", &GLASS, 10e3, 0.005);
    // Seen: 1.3e-3.
    assert!(cells.modes.len() == 33 && worst < 5e-3, "{} {worst:.1e}", cells.modes.len());
}

#[test]
fn a_bowl_agrees_with_its_section() {
    let (_, worst) = against_section("bowl@0.002", &CERAMIC, 12e3, 0.005);
    // Seen: 3.1e-3, of the sharp inner edge of its foot.
    assert!(worst < 1e-2, "{worst:.1e}");
}

/// A plate without mirror planes but that through its middle: one of its four corners is 4 mm farther in.
fn uneven(plate: &TriMesh) -> TriMesh {
    let moved = |v: &DVec3| if v.x > 0.0 && v.y > 0.0 { *v - 0.004 * DVec3::X } else { *v };
    TriMesh { vertices: plate.vertices.iter().map(moved).collect(), ..plate.clone() }
}

/// Where a plate lies in the grid must not matter, nor may a mode appear that is not one. A turned plate with
/// mirror planes has them in the grid again; one without lies across it.
fn turned_plates_ring_alike(plates: &[(f64, f64)]) {
    for &(part, limit) in plates {
        let plate = shape(&format!("box:0.1x0.06x{}", 0.02 / part));
        let even = in_cells(&plate, &STEEL, limit, 1e-3).expect("modes");
        let straight = in_cells(&uneven(&plate), &STEEL, limit, 1e-3).expect("modes");
        let leaning = in_cells(&turned(&uneven(&plate)), &STEEL, limit, 1e-3).expect("modes");
        let bricks = BakeGeometry::RoundedBox { edges: DVec3::new(0.1, 0.06, 0.02 / part), round: 0.0 };
        let bricks = by_default(&bricks, &STEEL, limit, 1e-3);
        assert_eq!(straight.modes.len(), leaning.modes.len());
        assert_eq!(even.modes.len(), bricks.modes.len());
        for (a, c) in even.modes.iter().zip(&bricks.modes) {
            let order = a.frequency / c.frequency - 1.0;
            println!("1/{part} {:.1} Hz, bricks {order:.1e}", a.frequency);
            // Seen: 1.6e-3.
            assert!(order.abs() < 4e-3, "{} {order:.1e}", a.frequency);
        }
        for (a, b) in straight.modes.iter().zip(&leaning.modes) {
            let turning = b.frequency / a.frequency - 1.0;
            println!("1/{part} {:.1} Hz: {turning:.1e}", a.frequency);
            // Seen: 9.1e-4.
            assert!(turning.abs() < 1e-3, "{} {turning:.1e}", a.frequency);
        }
    }
}

#[test]
fn turned_plates_ring_as_unturned_ones() {
    turned_plates_ring_alike(&[(5.0, 6e3), (30.0, 1e3)]);
}

#[test]
#[ignore = "four minutes"]
fn turned_plates_of_any_thickness_ring_as_unturned_ones() {
    turned_plates_ring_alike(&[(5.0, 9e3), (10.0, 4.5e3), (20.0, 2.3e3), (30.0, 1.5e3)]);
}

#[test]
fn crossing_and_loose_surfaces_are_told_with_their_place() {
    // A corner of a plate is pulled through its opposite face.
    let mut plate = shape("box:0.1x0.1x0.004");
    let corner = plate.vertices.iter().position(|v| v.min_element() > 0.0).expect("a corner");
    plate.vertices[corner].z = -0.05;
    let error = in_cells(&plate, &STEEL, 5e3, 0.01).expect_err("crossing");
    let ModalAnalysisError::Cell(cell) = &error else { panic!("{error}") };
    assert!(cell.filled < 0.0 && cell.place.x > 0.0, "{error}");
    // Two plates beside each other.
    let mut two = shape("box:0.1x0.1x0.004");
    let count = two.vertices.len();
    let other: Vec<DVec3> = two.vertices.iter().map(|v| *v + DVec3::Z).collect();
    let second: Vec<[u32; 3]> = two.triangles.iter().map(|t| t.map(|v| v + count as u32)).collect();
    two.vertices.extend(other);
    two.triangles.extend(second);
    let error = in_cells(&two, &STEEL, 5e3, 0.01).expect_err("two bodies");
    assert!(matches!(error, ModalAnalysisError::LooseParts(2)), "{error}");
    // A foil.
    let foil = pipe([0.1 - 1e-6, 0.1], 0.2, 64);
    let error = in_cells(&foil, &STEEL, 20e3, 0.01).expect_err("too fine");
    assert!(matches!(error, ModalAnalysisError::TooFine { nodes, .. } if nodes > 1e6), "{error}");
}
