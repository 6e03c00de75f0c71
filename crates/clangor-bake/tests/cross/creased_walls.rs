//! Walls that meet at inner edges, and walls with a gap between them, in cells larger than both.

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

use crate::plates::slab;
use clangor_bake::fem::ElasticConstants;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::geometry_class::solver_choice::ModalChoice;
use clangor_bake::modal_analysis::{ModalAnalysis, ModalAnalysisOptions, modal_analysis, modal_analysis_by};
use clangor_core::geometry::meridian::{Meridian, Piece};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::Material;
use clangor_core::material::presets::{GLASS, STEEL};
use glam::{DQuat, DVec2, DVec3};

/// E = 62 GPa, ν = 0.2, ρ = 2600 kg/m³.
fn glass() -> Material {
    Material { density: 2600.0, youngs_modulus: 62e9, poisson_ratio: 0.2, ..GLASS.material() }
}

fn by_default(mesh: &TriMesh, limit: f64) -> ModalAnalysis {
    let geometry = BakeGeometry::of_mesh(mesh);
    assert!(matches!(geometry.modal_choice(), Ok(ModalChoice::Cells(_))));
    let constants = ElasticConstants::of(&glass()).expect("an elastic material");
    let options = ModalAnalysisOptions::to(limit);
    modal_analysis(&geometry, &constants, &options, &mut |_| ControlFlow::Continue(())).expect("modes")
}

/// A box of outer edges 120 × 80 × 100 mm without its top, of twelve sharp edges and four inner ones.
fn open_box(wall: f64) -> TriMesh {
    let outer = DVec3::new(0.06, 0.04, 0.05);
    let inner = outer - DVec3::splat(wall);
    let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let ring = |half: DVec3, z: f64| signs.map(|[x, y]| DVec3::new(x * half.x, y * half.y, z));
    let vertices =
        [ring(outer, -outer.z), ring(outer, outer.z), ring(inner, wall - outer.z), ring(inner, outer.z)]
            .concat();
    let mut triangles = Vec::new();
    let mut quad = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    quad([0, 3, 2, 1]);
    quad([8, 9, 10, 11]);
    for k in 0..4 {
        let n = (k + 1) % 4;
        quad([k, n, n + 4, k + 4]);
        quad([8 + n, 8 + k, 12 + k, 12 + n]);
        quad([k + 4, n + 4, n + 12, k + 12]);
    }
    TriMesh { vertices, triangles }
}

/// Best known: 679 and 1120 Hz by tetrahedra of order 6 on 12 824 nodes, and still falling.
#[test]
fn an_open_box_rings_as_in_tetrahedra_of_sixth_order() {
    let found = by_default(&open_box(0.004), 1500.0);
    let frequencies: Vec<f64> = found.modes.iter().map(|mode| mode.frequency).collect();
    println!("{frequencies:.1?}, {} nodes, {:?}", found.nodes, found.warnings);
    assert_eq!(frequencies.len(), 2);
    for (found, best) in frequencies.iter().zip([679.0, 1120.0]) {
        // Seen: 0.03 and 0.04 % above; 11 and 9 % without the division.
        assert!((found / best - 1.0).abs() < 0.015, "{found:.1} Hz for {best} Hz");
    }
}

/// A tuning fork: two bars, 80 × 10 × 3 mm, on a common foot, 1 mm apart. Bars in phase and in opposite phase
/// ring in the plane and across it, four modes where one cell that both share would have two.
#[test]
fn two_bars_across_a_slit_of_a_millimetre_move_apart() {
    let outline = [
        [-0.05, -0.0105],
        [0.05, -0.0105],
        [0.05, -0.0005],
        [-0.03, -0.0005],
        [-0.03, 0.0005],
        [0.05, 0.0005],
        [0.05, 0.0105],
        [-0.05, 0.0105],
    ];
    let level = |z: f64| outline.map(|[x, y]| DVec3::new(x, y, z));
    let mut triangles = Vec::new();
    // The faces by hand: two bars and the foot.
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 7], [4, 5, 6], [4, 6, 7]] {
        triangles.extend([[a, c, b], [a + 8, b + 8, c + 8]]);
    }
    for k in 0..8 {
        let n = (k + 1) % 8;
        triangles.extend([[k, n, n + 8], [k, n + 8, k + 8]]);
    }
    let fork = TriMesh { vertices: [level(-0.0015), level(0.0015)].concat(), triangles };
    let constants = ElasticConstants::of(&glass()).expect("an elastic material");
    let options = ModalAnalysisOptions::to(4000.0);
    let by = |choice| {
        let go = &mut |_: &_| ControlFlow::Continue(());
        clangor_bake::modal_analysis::modal_analysis_by(choice, &constants, &options, go).expect("modes")
    };
    let cells = by(ModalChoice::Cells(std::borrow::Cow::Borrowed(&fork)));
    let plate = match BakeGeometry::of_mesh(&fork).modal_choice().expect("a solid") {
        ModalChoice::Prisms(plate) => by(ModalChoice::Prisms(plate)),
        other => panic!("{other:?}"),
    };
    assert_eq!(cells.modes.len(), plate.modes.len());
    for (a, b) in cells.modes.iter().zip(&plate.modes) {
        println!("{:.1} Hz, as a plate {:.1} Hz", a.frequency, b.frequency);
        assert!((a.frequency / b.frequency - 1.0).abs() < 0.015, "{:.1} {:.1}", a.frequency, b.frequency);
    }
}

/// A plate with arms of 100 × 20 × 2 mm at a right angle: its inner corner is short, and singular.
#[test]
fn an_inner_corner_of_a_plate_in_cells_is_as_far_off_as_stated() {
    // From the inner corner, which sees all others.
    let outline = [[0.02, 0.02], [0.02, 0.1], [0.0, 0.1], [0.0, 0.0], [0.1, 0.0], [0.1, 0.02]];
    let mesh = slab(&outline.map(DVec2::from_array), 2e-3);
    let steel = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
    let by = |choice, accuracy: f64| {
        let options = ModalAnalysisOptions { accuracy, ..ModalAnalysisOptions::to(3000.0) };
        modal_analysis_by(choice, &steel, &options, &mut |_| ControlFlow::Continue(())).expect("modes")
    };
    let geometry = BakeGeometry::of_mesh(&mesh);
    let plate = geometry.modal_choice().expect("a solid");
    assert!(matches!(plate, ModalChoice::Prisms(_)));
    let (cells, plate) = (by(ModalChoice::Cells(Cow::Borrowed(&mesh)), 0.01), by(plate, 2e-3));
    assert_eq!(cells.modes.len(), plate.modes.len());
    for (a, b) in cells.modes.iter().zip(&plate.modes) {
        let (off, said) = (a.frequency / b.frequency - 1.0, a.mesh_error);
        println!("{:.1} Hz: {off:.1e}, stated {said:.1e}", b.frequency);
        // Seen: up to 6.9e-3, stated 7.3e-3; 5.5 %, stated as 0.33 %, where all gain as much by order 4.
        assert!(off < 1.5 * said && off < 0.01, "{:.1} Hz: {off:.1e}, stated {said:.1e}", b.frequency);
    }
}

/// A profile of 100 × 30 × 30 × 3 mm, turned: a mirror plane goes through its inner edge, and its faces lie
/// at 45° to that.
#[test]
fn an_angle_iron_in_cells_is_as_far_off_as_stated() {
    // From the inner edge, which sees all others.
    let outline = [[0.003, 0.003], [0.003, 0.03], [0.0, 0.03], [0.0, 0.0], [0.03, 0.0], [0.03, 0.003]];
    let mut mesh = slab(&outline.map(DVec2::from_array), 0.1);
    let turn = DQuat::from_scaled_axis(DVec3::new(0.5, 0.3, -0.7));
    mesh.vertices.iter_mut().for_each(|vertex| *vertex = turn * *vertex);
    let steel = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
    let (choice, options) = (ModalChoice::Cells(Cow::Borrowed(&mesh)), ModalAnalysisOptions::to(4000.0));
    let found =
        modal_analysis_by(choice, &steel, &options, &mut |_| ControlFlow::Continue(())).expect("modes");
    // Quadratic hexahedra, graded towards edges and ends, 85 305 unknowns; still falling by 0.1 %.
    let references = [2049.2, 3741.7, 3835.2];
    assert_eq!(found.modes.len(), references.len());
    for (mode, reference) in found.modes.iter().zip(references) {
        let (off, said) = (mode.frequency / reference - 1.0, mode.mesh_error);
        println!("{reference:.1} Hz: {off:.1e}, stated {said:.1e}");
        // Seen: up to 5.3e-3, stated 6.6e-3; 4.3 %, stated as 0.67 %, in the axes of the mirror planes.
        assert!(off < 1.5 * said && off < 0.01, "{reference:.1} Hz: {off:.1e}, stated {said:.1e}");
    }
}

/// Outer and inner outline of a tin, 80 × 60 × 0.8 mm, from the bottom to the top and back: radius and height
/// \[m\]. Its lid has a hole of 6 mm, so that its section is one curve.
const TIN: [[f64; 2]; 8] = [
    [0.0, -0.03],
    [0.04, -0.03],
    [0.04, 0.03],
    [0.003, 0.03],
    [0.003, 0.0292],
    [0.0392, 0.0292],
    [0.0392, -0.0292],
    [0.0, -0.0292],
];

/// A closed outline from axis to axis about the y axis, as triangles with 192 sides, turned against the grid.
fn revolved(outline: &[[f64; 2]]) -> TriMesh {
    const SIDES: u32 = 192;
    let mut vertices = Vec::new();
    let mut rows: Vec<[u32; SIDES as usize]> = Vec::new();
    for [radius, y] in outline {
        let first = vertices.len() as u32;
        let on_axis = *radius == 0.0;
        rows.push(std::array::from_fn(|k| if on_axis { first } else { first + k as u32 }));
        let angles = (0..if on_axis { 1 } else { SIDES }).map(|k| TAU * f64::from(k) / f64::from(SIDES));
        vertices.extend(angles.map(|a| DVec3::new(radius * a.cos(), *y, radius * a.sin())));
    }
    let mut triangles = Vec::new();
    for pair in rows.windows(2) {
        for k in 0..SIDES as usize {
            let next = (k + 1) % SIDES as usize;
            let [a, b, c, d] = [pair[0][k], pair[1][k], pair[1][next], pair[0][next]];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let turn = DQuat::from_scaled_axis(DVec3::new(0.6, 0.9, 0.4));
    TriMesh { vertices: vertices.into_iter().map(|v| turn * v).collect(), triangles }
}

/// Where walls meet at edges that are curved, as all do in a tin.
#[test]
#[ignore = "a minute: cargo test --release -p clangor-bake --test cross creased_walls:: -- --ignored"]
fn a_tin_in_cells_rings_as_its_section() {
    let corners = TIN.map(DVec2::from);
    let pieces = corners.windows(2).map(|pair| Piece::Line { from: pair[0], to: pair[1] }).collect();
    let section = BakeGeometry::axisymmetric(Meridian::try_new(pieces).expect("a section"));
    let steel = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let options = ModalAnalysisOptions::to(15e3);
    let exact = ModalAnalysisOptions { accuracy: 1e-3, ..options };
    let exact = modal_analysis(&section, &steel, &exact, go_on).expect("modes");
    let choice = ModalChoice::Cells(Cow::Owned(revolved(&TIN)));
    let found = modal_analysis_by(choice, &steel, &options, go_on).expect("modes");
    assert_eq!(found.modes.len(), exact.modes.len());
    let errors = found.modes.iter().zip(&exact.modes).map(|(a, b)| a.frequency / b.frequency - 1.0);
    let worst = errors.fold(0.0, f64::max);
    let said = found.modes.iter().map(|mode| mode.mesh_error).fold(0.0, f64::max);
    println!("{} modes on {} nodes: {worst:.1e} of {said:.1e}", found.modes.len(), found.nodes);
    // Seen: 0.70 %, said to be 0.70 %; 2.3 % without smaller cells. What is said is an estimate.
    assert!(worst < 0.01 && worst < 1.25 * said, "{worst:.1e} {said:.1e}");
}
