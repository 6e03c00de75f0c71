//! Beams that are clamped, sprung and free, against the textbook (Euler and Bernoulli; slender enough for
//! 0.5 %), and what cannot hold a body.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::fem::supports::{Support, SupportError, SupportKind, SupportRegion};
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal_analysis::{
    ModalAnalysis, ModalAnalysisError, ModalAnalysisOptions, supported_modal_analysis,
};
use clangor_core::geometry::meridian::{Meridian, Piece};
use clangor_core::glam::{DVec2, DVec3};
use clangor_core::material::presets::STEEL;

/// Length, height, width \[m\].
const EDGES: DVec3 = DVec3::new(0.4, 0.005, 0.0065);

fn beam() -> BakeGeometry {
    BakeGeometry::RoundedBox { edges: EDGES, round: 0.0 }
}

fn modes(supports: &[Support], limit: f64) -> Result<ModalAnalysis, ModalAnalysisError> {
    let constants = ElasticConstants::of(&STEEL.material()).unwrap();
    let options = ModalAnalysisOptions { accuracy: 0.003, ..ModalAnalysisOptions::to(limit) };
    supported_modal_analysis(&beam(), &constants, supports, &options, &mut |_| ControlFlow::Continue(()))
}

/// The part of the beam between two places along it.
fn slice(from: f64, to: f64) -> SupportRegion {
    SupportRegion::Box { low: DVec3::new(from, -1.0, -1.0), high: DVec3::new(to, 1.0, 1.0) }
}

fn clamp(from: f64, to: f64) -> Support {
    Support { region: slice(from, to), kind: SupportKind::Clamped }
}

fn springs(region: SupportRegion, stiffness: DVec3) -> Support {
    Support { region, kind: SupportKind::Sprung { stiffness, damping: DVec3::ZERO } }
}

fn mass() -> f64 {
    STEEL.density * EDGES.element_product()
}

/// (βL)²/(2πL²) √(EI/ρA) of bending in both directions, ascending.
fn bending(roots: &[f64], length: f64) -> Vec<f64> {
    let speed = (STEEL.youngs_modulus / STEEL.density / 12.0).sqrt();
    let of = |depth: f64| roots.iter().map(move |b| b * b / (TAU * length * length) * speed * depth);
    let mut all: Vec<f64> = of(EDGES.y).chain(of(EDGES.z)).collect();
    all.sort_by(f64::total_cmp);
    all
}

#[track_caller]
fn agree(found: &ModalAnalysis, exact: &[f64]) {
    for (mode, exact) in found.modes.iter().zip(exact) {
        let error = mode.frequency / exact - 1.0;
        println!("{:.2} Hz of {exact:.2}: {:+.2} %", mode.frequency, 100.0 * error);
        assert!(error.abs() < 0.005, "{} of {exact}", mode.frequency);
    }
    assert!(found.modes.len() >= exact.len());
}

const CLAMPED_FREE: [f64; 2] = [1.875_104_07, 4.694_091_13];
const CLAMPED_CLAMPED: [f64; 2] = [4.730_040_74, 7.853_204_62];

#[test]
fn a_clamped_beam_has_the_frequencies_of_a_cantilever() {
    // The clamp holds the first 40 mm.
    let exact = bending(&CLAMPED_FREE, 0.36);
    agree(&modes(&[clamp(-1.0, -0.16)], 1.05 * exact[3]).unwrap(), &exact);
}

#[test]
fn a_beam_clamped_at_both_ends() {
    let exact = bending(&CLAMPED_CLAMPED, 0.35);
    agree(&modes(&[clamp(-1.0, -0.17), clamp(0.18, 1.0)], 1.05 * exact[3]).unwrap(), &exact);
}

#[test]
fn a_free_beam_keeps_its_modes() {
    let exact = bending(&CLAMPED_CLAMPED, EDGES.x);
    agree(&modes(&[], 1.05 * exact[3]).unwrap(), &exact);
}

#[test]
fn on_an_even_bed_of_springs_all_squares_rise_alike() {
    // ω² = ω_free² + k/m, for what was rigid as well: three translations and three rotations.
    let own = 300.0;
    let stiffness = (TAU * own).powi(2) * mass();
    let bed = springs(slice(-1.0, 1.0), DVec3::splat(stiffness));
    let free = bending(&CLAMPED_CLAMPED, EDGES.x);
    let mut exact = vec![own; 6];
    exact.extend(free.iter().map(|f| f.hypot(own)));
    agree(&modes(&[bed], 1.05 * exact[9]).unwrap(), &exact);
}

#[test]
fn a_beam_on_soft_feet_bounces_and_rocks() {
    // Two feet at the ends, 3 mm long, so soft that the beam hardly bends: bounce √(k/m), rocking √(3k/m)
    // nearly.
    let own: f64 = 4.0;
    let stiffness = 0.5 * (TAU * own).powi(2) * mass() * DVec3::new(40.0, 1.0, 15.0);
    let feet = [springs(slice(-1.0, -0.197), stiffness), springs(slice(0.197, 1.0), stiffness)];
    let found = modes(&feet, 12.0).unwrap();
    let arm: f64 = 0.1985;
    let inertia = (EDGES.x * EDGES.x + EDGES.y * EDGES.y) / 12.0;
    agree(&found, &[own, own * arm / inertia.sqrt()]);
}

#[test]
fn a_spring_at_the_tip_of_a_cantilever() {
    // k L³/EI = a: a (sin cosh − cos sinh) = −β³ (1 + cos cosh), its first root by halving.
    let (length, a) = (0.36_f64, 5.0);
    let stiff = STEEL.youngs_modulus * EDGES.z * EDGES.y.powi(3) / 12.0 / length.powi(3);
    let value =
        |b: f64| b.powi(3) * (1.0 + b.cos() * b.cosh()) + a * (b.sin() * b.cosh() - b.cos() * b.sinh());
    let (mut low, mut high) = (1.9, 3.6);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (value(middle) > 0.0) == (value(low) > 0.0) { low = middle } else { high = middle }
    }
    let tip = springs(slice(0.199, 1.0), DVec3::new(0.0, a * stiff, 0.0));
    // Across, the beam is a cantilever still.
    let mut exact = [bending(&[low], length)[0], bending(&CLAMPED_FREE, length)[1]];
    exact.sort_by(f64::total_cmp);
    agree(&modes(&[clamp(-1.0, -0.16), tip], 1.3 * exact[1]).unwrap(), &exact);
}

#[test]
fn what_cannot_hold_a_body_is_refused() {
    let refused = |supports: &[Support]| match modes(supports, 500.0) {
        Err(ModalAnalysisError::Supports(error)) => error,
        other => panic!("{other:?}"),
    };
    let off = SupportRegion::Ball { centre: DVec3::new(0.0, 0.1, 0.0), radius: 0.01 };
    let error = refused(&[Support { region: off, kind: SupportKind::Clamped }]);
    assert!(matches!(error, SupportError::Off { support: 0, .. }), "{error}");
    let error = refused(&[springs(slice(-1.0, 0.0), DVec3::new(1.0, -2.0, 1.0))]);
    assert!(matches!(error, SupportError::Value { support: 0, what: "stiffness", .. }), "{error}");
    let error = refused(&[springs(slice(-1.0, 0.0), DVec3::ZERO)]);
    assert_eq!(error, SupportError::Loose { support: 0 });
    let error = refused(&[clamp(-1.0, -0.1), clamp(-0.15, 0.0)]);
    assert_eq!(error, SupportError::Overlap { first: 0, second: 1 });
    let point = SupportRegion::Ball { centre: DVec3::new(0.05, 0.0, 0.0), radius: 1e-5 };
    let error = refused(&[Support { region: point, kind: SupportKind::Clamped }]);
    assert_eq!(error, SupportError::Free { motions: 3 });
    let error = refused(&[clamp(0.1, 0.1)]);
    assert!(matches!(error, SupportError::Value { what: "extent", .. }), "{error}");
}

/// A tube along y, 0.5 mm thick: of revolution until something holds it, then solved in cells.
const TUBE: [f64; 3] = [0.4, 0.0045, 0.005];

fn tube_modes(supports: &[Support], limit: f64) -> ModalAnalysis {
    let [length, inner, outer] = TUBE;
    let corners = [[inner, -0.5], [outer, -0.5], [outer, 0.5], [inner, 0.5]];
    let corner = |k: usize| DVec2::new(corners[k % 4][0], length * corners[k % 4][1]);
    let pieces = (0..4).map(|k| Piece::Line { from: corner(k), to: corner(k + 1) }).collect();
    let body = BakeGeometry::axisymmetric(Meridian::try_new(pieces).unwrap());
    let constants = ElasticConstants::of(&STEEL.material()).unwrap();
    let options = ModalAnalysisOptions { accuracy: 0.005, ..ModalAnalysisOptions::to(limit) };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let found = supported_modal_analysis(&body, &constants, supports, &options, go_on).unwrap();
    println!("{} on {} nodes", found.method, found.nodes);
    assert!(found.method.starts_with("cells"), "{}", found.method);
    found
}

fn ring(from: f64, to: f64) -> SupportRegion {
    SupportRegion::Box { low: DVec3::new(-1.0, from, -1.0), high: DVec3::new(1.0, to, 1.0) }
}

#[test]
#[ignore = "minutes: cargo test --release -p clangor-bake --test analytic supports:: -- --ignored"]
fn a_clamped_tube_in_cells_is_a_cantilever() {
    // Shear lowers the first pair by 0.1 %.
    let [_, inner, outer] = TUBE;
    let speed = (STEEL.youngs_modulus / STEEL.density * (inner * inner + outer * outer)).sqrt() / 2.0;
    let first = CLAMPED_FREE[0].powi(2) / (TAU * 0.36 * 0.36) * speed;
    let clamp = Support { region: ring(-1.0, -0.16), kind: SupportKind::Clamped };
    agree(&tube_modes(&[clamp], 1.1 * first), &[first; 2]);
}

#[test]
#[ignore = "minutes: cargo test --release -p clangor-bake --test analytic supports:: -- --ignored"]
fn a_tube_in_cells_on_an_even_bed_bounces_in_six_ways() {
    let own: f64 = 50.0;
    let [length, inner, outer] = TUBE;
    let mass = STEEL.density * length * PI * (outer * outer - inner * inner);
    let stiffness = DVec3::splat((TAU * own).powi(2) * mass);
    let ratio = 0.02;
    let damping = DVec3::splat(2.0 * ratio * mass * TAU * own);
    let bed = Support { region: ring(-1.0, 1.0), kind: SupportKind::Sprung { stiffness, damping } };
    let found = tube_modes(&[bed], 1.2 * own);
    agree(&found, &[own; 6]);
    for mode in &found.modes {
        assert!((mode.support_damping_ratio() / ratio - 1.0).abs() < 0.01, "{}", mode.support_damping);
    }
}
