//! Effective masses of contact rows: what they leave as it is, and which body they stand for.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::contact::{
    ContactError, ContactReport, ContactSettings, ForceShape, ImpactPulse, ModesAtContact, PoseHistory,
    StruckBodies, impact_pulses_on,
};
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::material::presets;
use clangor_core::timeline::{ContactKind, ContactRow};

const SPEED: f64 = 1.0;

/// A steel cube of 20 mm, `factor` times as heavy, and a wall at its lower side.
fn bodies(factor: f64) -> [Body; 2] {
    let mut cube = Body::sphere("cube", presets::STEEL.material(), 0.01);
    let mass = factor * 7850.0 * 8e-6;
    (cube.mass, cube.inertia) = (mass, DMat3::from_diagonal(DVec3::splat(mass * 4e-4 / 6.0)));
    let surface = Arc::new(Surface::HalfSpace);
    let wall = Body { surface, motion: Motion::Fixed, mass: f64::INFINITY, ..cube.clone() };
    [cube, wall]
}

/// 1/(1/M + r²/I) of that cube at a place of its lower side \[m\], with I = M a²/6.
fn own_mass(factor: f64, place: DVec3) -> f64 {
    let mass = factor * 7850.0 * 8e-6;
    mass / (1.0 + 6.0 * (place.x * place.x + place.z * place.z) / 4e-4)
}

fn row(place: DVec3, effective_mass: Option<f64>) -> ContactRow {
    ContactRow {
        time: 0.1,
        body_a: BodyId(0),
        body_b: BodyId(1),
        kind: ContactKind::Impact,
        point: place,
        normal: DVec3::Y,
        impulse_n: 0.03,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: -SPEED * DVec3::Y,
        depth: 0.0,
        impact_id: 1,
        effective_mass,
    }
}

/// One point off the centre, and four points near the corners.
fn places() -> [Vec<DVec3>; 2] {
    let corners = [(1.0, 1.0), (1.0, -0.9), (-0.8, 1.0), (-1.0, -1.0)];
    let corners = corners.map(|(x, z)| DVec3::new(0.009 * x, -0.01, 0.009 * z));
    [vec![DVec3::new(0.004, -0.01, 0.002)], corners.to_vec()]
}

/// Twenty modes of the cube, the same at all points.
fn modes(id: BodyId, points: &[(DVec3, DVec3)]) -> Option<ModesAtContact> {
    (id == BodyId(0)).then(|| ModesAtContact {
        frequencies: (0..20).map(|i| 900.0 * f64::from(i + 1)).collect(),
        damping_ratios: vec![1e-3; 20],
        motions: points.iter().map(|_| vec![4.0 * DVec3::Y; 20]).collect(),
    })
}

fn silent(_: BodyId, _: &[(DVec3, DVec3)]) -> Option<ModesAtContact> {
    None
}

/// The pulses on the cube of a mass factor, and their report.
fn pulses(factor: f64, rows: &[ContactRow], vibrates: bool) -> (Vec<ImpactPulse>, ContactReport) {
    let bodies = bodies(factor);
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let struck = StruckBodies {
        bodies: &bodies,
        poses: &poses,
        modes: if vibrates { &modes } else { &silent },
        forces: &[],
    };
    impact_pulses_on(struck, rows, &ContactSettings::default()).unwrap()
}

/// Largest difference of durations and shapes, over their size.
fn apart(first: &[ImpactPulse], second: &[ImpactPulse]) -> f64 {
    assert_eq!(first.len(), second.len());
    let pair = |(a, b): (&ImpactPulse, &ImpactPulse)| {
        let shapes = match (&a.shape, &b.shape) {
            (ForceShape::History(a), ForceShape::History(b)) => {
                assert_eq!(a.values().len(), b.values().len());
                let peak = b.values().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                let pairs = a.values().iter().zip(b.values());
                pairs.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / peak
            }
            (a, b) => f64::from(u8::from(a != b)),
        };
        let numbers = [(a.duration, b.duration), (a.effective_mass, b.effective_mass)];
        numbers.into_iter().fold(shapes, |m, (a, b)| m.max((a / b - 1.0).abs()))
    };
    first.iter().zip(second).map(pair).fold(0.0, f64::max)
}

#[test]
fn the_effective_mass_of_the_bodies_alone_changes_nothing() {
    for places in places() {
        for vibrates in [false, true] {
            let given: Vec<_> = places.iter().map(|place| row(*place, Some(own_mass(1.0, *place)))).collect();
            let alone: Vec<_> = places.iter().map(|place| row(*place, None)).collect();
            let [(given, _), (alone, _)] = [given, alone].map(|rows| pulses(1.0, &rows, vibrates));
            // Residual seen: 0.
            assert!(apart(&given, &alone) < 1e-11, "{} points: {:e}", places.len(), apart(&given, &alone));
        }
    }
}

#[test]
fn a_larger_effective_mass_gives_the_force_of_a_heavier_body() {
    for places in places() {
        for vibrates in [false, true] {
            let given: Vec<_> = places.iter().map(|place| row(*place, Some(own_mass(3.0, *place)))).collect();
            let alone: Vec<_> = places.iter().map(|place| row(*place, None)).collect();
            let (given, report) = pulses(1.0, &given, vibrates);
            let (heavier, _) = pulses(3.0, &alone, vibrates);
            let (lighter, _) = pulses(1.0, &alone, vibrates);
            assert_eq!(report.solves.solved, u64::from(vibrates || places.len() > 1));
            // Residual seen: 5e-16 without modes, 8e-14 with them.
            assert!(apart(&given, &heavier) < 1e-11, "{:e}", apart(&given, &heavier));
            assert!(vibrates || given[0].duration > 1.2 * lighter[0].duration);
            // The impulse and the motion of the cube are the recorded ones.
            let of = |pulses: &[ImpactPulse]| -> (DVec3, DVec3) {
                let shares = || pulses.iter().filter_map(|pulse| pulse.bodies[0]);
                (shares().map(|s| s.impulse).sum(), shares().map(|s| s.velocity_change).sum())
            };
            // Residual seen: 6e-17 N s and 4e-16 m/s.
            let (own, other) = (of(&given), of(&lighter));
            assert!((own.0 - other.0).length() < 1e-14 && (own.1 - other.1).length() < 1e-13);
        }
    }
}

#[test]
fn rows_with_and_without_a_mass_are_weighted_by_their_impulses() {
    let place = places()[0][0];
    let mass = own_mass(1.0, place);
    let rows = [
        ContactRow { impulse_n: 0.03, ..row(place, Some(2.0 * mass)) },
        ContactRow { impulse_n: 0.01, ..row(place, None) },
        ContactRow { impulse_n: -1e-3, ..row(place, Some(1e-3 * mass)) },
    ];
    let (pulses, _) = pulses(1.0, &rows, false);
    // Of 1/m: three quarters of a half, and a quarter of 1. Residual seen: 0.
    assert!((pulses[0].effective_mass / (mass / 0.625) - 1.0).abs() < 1e-13, "{}", pulses[0].effective_mass);
}

#[test]
fn the_energy_of_the_approach_is_that_of_the_given_mass() {
    let place = places()[0][0];
    let (pulses, _) = pulses(1.0, &[row(place, Some(0.5))], false);
    // Residual seen: 0.
    assert!((pulses[0].approach_energy() - 0.25 * SPEED * SPEED).abs() < 1e-14);
}

#[test]
fn impossible_masses_are_errors() {
    let bodies = bodies(1.0);
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    for bad in [0.0, -1.0, f64::INFINITY, f64::NAN, 1e-31, 1e19] {
        let rows = [row(places()[0][0], Some(bad))];
        let struck = StruckBodies { bodies: &bodies, poses: &poses, modes: &silent, forces: &[] };
        let error = impact_pulses_on(struck, &rows, &ContactSettings::default()).unwrap_err();
        let is_located = matches!(error, ContactError::EffectiveMass { body: 0, time: 0.1, .. });
        assert!(is_located, "{bad}: {error}");
    }
}
