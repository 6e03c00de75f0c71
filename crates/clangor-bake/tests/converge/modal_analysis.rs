//! The estimated discretisation error agrees with the difference to a much finer mesh.

use std::ops::ControlFlow;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal_analysis::{ModalAnalysisError, ModalAnalysisOptions, modal_analysis};
use clangor_core::material::presets::{GLASS, Preset, STEEL};
use clangor_core::shape::Shape;
use glam::DVec3;

/// The references of `converge/modes.rs`, the first ten \[Hz\].
const BAR: [f64; 10] =
    [574.401, 1573.196, 1671.474, 2948.849, 3055.526, 4354.580, 4989.727, 5920.033, 7343.771, 7958.034];
const PLATE: [f64; 10] =
    [516.129, 751.957, 864.413, 1303.872, 1303.872, 2216.041, 2216.041, 2354.829, 2578.310, 2770.506];

/// The relative error of each mode, and its estimate.
fn errors(edges: DVec3, preset: &Preset, limit: f64, reference: &[f64]) -> Vec<[f64; 2]> {
    let geometry = BakeGeometry::RoundedBox { edges, round: 0.0 };
    let constants = ElasticConstants::of(&preset.material()).expect("an elastic material");
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let mut to = |accuracy: f64| {
        let options = ModalAnalysisOptions { accuracy, ..ModalAnalysisOptions::to(limit) };
        let found = modal_analysis(&geometry, &constants, &options, &mut go_on).expect("modes");
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        found.modes
    };
    let (coarse, fine) = (to(0.01), to(3e-3));
    assert_eq!(coarse.len(), fine.len());
    for (mode, reference) in fine.iter().zip(reference) {
        // The references are of tetrahedra, and up to 1.1e-3 higher.
        assert!((mode.frequency / reference - 1.0).abs() < 2e-3, "{} Hz, {reference} Hz", mode.frequency);
    }
    coarse.iter().zip(&fine).map(|(c, f)| [c.frequency / f.frequency - 1.0, c.mesh_error]).collect()
}

#[test]
fn estimates_of_a_bar_and_a_plate_are_not_below_the_truth() {
    let bodies = [
        (DVec3::new(0.3, 0.03, 0.01), STEEL, 9000.0, BAR),
        (DVec3::new(0.25, 0.01, 0.25), GLASS, 3500.0, PLATE),
    ];
    for (edges, preset, limit, reference) in bodies {
        let errors = errors(edges, &preset, limit, &reference);
        println!("{errors:.6?}");
        // Errors seen: 4e-5 of the bar, 1e-3 of the plate.
        assert!(errors.iter().all(|[error, _]| *error < 3e-3), "{errors:.6?}");
        assert!(errors.iter().all(|[error, estimate]| *error < 2.0 * estimate + 1e-4), "{errors:.6?}");
    }
}

/// Thin panes need few hexahedra; tetrahedra many times as long as the pane is thick are too stiff in
/// bending.
#[test]
fn thin_panes_need_few_nodes() {
    let edges = DVec3::new(0.4, 0.004, 0.4);
    let geometry = BakeGeometry::RoundedBox { edges, round: 0.0 };
    let constants = ElasticConstants::of(&GLASS.material()).expect("an elastic material");
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let found =
        modal_analysis(&geometry, &constants, &ModalAnalysisOptions::to(2e3), &mut go_on).expect("modes");
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    assert!(found.nodes < 6000, "{}", found.nodes);
    assert_eq!(found.modes.len(), 36);
    // 20 x 2 x 20 cells, 8405 nodes.
    let reference = [81.78, 118.08, 135.81, 207.45, 207.45, 351.33, 351.33, 377.89, 412.98, 442.84];
    for (mode, reference) in found.modes.iter().zip(reference) {
        assert!((mode.frequency / reference - 1.0).abs() < 2e-3, "{} Hz, {reference} Hz", mode.frequency);
    }
}

/// A steel sheet of half a millimetre was refused, because the residual of its first mode is that of
/// rounding. Bending is proportional to the thickness.
#[test]
fn a_sheet_rings_as_one_of_twice_its_thickness_an_octave_lower() {
    let constants = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let mut modes = |thickness: f64, limit: f64| {
        let geometry = BakeGeometry::RoundedBox { edges: DVec3::new(0.3, thickness, 0.2), round: 0.0 };
        let options = ModalAnalysisOptions::to(limit);
        modal_analysis(&geometry, &constants, &options, &mut go_on).expect("modes")
    };
    let (thin, thick) = (modes(0.0005, 250.0), modes(0.001, 500.0));
    println!("{} modes, residuals {:.1e}, {:.1e}", thin.modes.len(), thin.residual, thick.residual);
    assert_eq!(thin.modes.len(), thick.modes.len());
    for (thin, thick) in thin.modes.iter().zip(&thick.modes) {
        let error = 2.0 * thin.frequency / thick.frequency - 1.0;
        assert!(error.abs() < 2e-3, "{} Hz {error:.1e}", thin.frequency);
    }
}

/// A foil needs millions of elements: the error is reported before they are made.
#[test]
fn a_foil_is_refused_with_the_size_of_its_mesh() {
    let constants = ElasticConstants::of(&GLASS.material()).expect("an elastic material");
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let mut refused = |geometry: &BakeGeometry| {
        let error = modal_analysis(geometry, &constants, &ModalAnalysisOptions::to(20e3), &mut go_on)
            .expect_err("too fine");
        let ModalAnalysisError::TooFine { wall, edge, elements, nodes, most } = error else {
            panic!("{error}")
        };
        assert!((wall / 1e-6 - 1.0).abs() < 1e-3 && edge < 1e-3 && elements > 1e5, "{error}");
        assert!(nodes > most as f64 && most == ModalAnalysisOptions::MOST_NODES);
    };
    let edges = DVec3::new(0.26, 1e-6, 0.26);
    refused(&BakeGeometry::RoundedBox { edges, round: 0.0 });
    let prism = Shape::parse("prism:5x0.1x1e-6").expect("a shape").mesh();
    refused(&BakeGeometry::Mesh(prism));
    refused(&BakeGeometry::Ellipsoid { semi_axes: DVec3::new(0.1, 0.5e-6, 0.2) });
}
