//! Impacts of a timeline as forces: what a solve of the contact keeps of the recorded motion, and what it
//! hands on from impact to impact.

use std::f64::consts::TAU;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::contact::contact_side::ContactSide;
use clangor_core::contact::{
    ContactPoint, ContactSettings, ForceSettings, ForceShape, Impact, ImpactPulse, ImpactSolver,
    ModesAtContact, PoseHistory, StruckBodies, contact_forces, impact_pulses, impact_pulses_on, no_modes,
};
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::material::presets;
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow};

const PLATE: BodyId = BodyId(0);
const BALL: BodyId = BodyId(1);
const SPEED: f64 = 1.0;

/// A thin body of 0.2 kg, and a steel ball of 6 mm radius above its edge.
fn bodies() -> [Body; 2] {
    let mut plate = Body::sphere("plate", presets::CERAMIC.material(), 0.1);
    (plate.mass, plate.inertia) = (0.2, DMat3::from_diagonal(DVec3::new(5e-4, 1e-3, 5e-4)));
    let ball = Body::sphere("ball", presets::STEEL.material(), 0.006);
    [plate, ball.at(Pose::at(DVec3::new(0.1, 0.006, 0.0)))]
}

/// Modes of the plate at its edge [kg^−½]: 40 from 300 Hz to 12 kHz, of 7 kg^−½ along y.
fn modes(id: BodyId, points: &[(DVec3, DVec3)]) -> Option<ModesAtContact> {
    let count = 40;
    let frequency = |i: usize| 300.0 * (i + 1) as f64;
    (id == PLATE).then(|| ModesAtContact {
        frequencies: (0..count).map(frequency).collect(),
        damping_ratios: vec![1e-3; count],
        motions: points.iter().map(|_| vec![7.0 * DVec3::Y; count]).collect(),
    })
}

/// The ball falls onto the edge of the plate, with the impulse of a restitution.
fn impact(restitution: f64) -> Impact {
    let [plate, ball] = bodies();
    let point = DVec3::new(0.1, 0.0, 0.0);
    let sides = [(PLATE, &plate), (BALL, &ball)].map(|(id, body)| {
        ContactSide::of_body(id, body, body.pose).touched_at(
            &body.surface,
            DVec3::Y,
            [(point, 1.0)].into_iter(),
        )
    });
    Impact { restitution: 0.98, ..Impact::with_restitution(sides, point, DVec3::NEG_Y, SPEED, restitution) }
}

/// ½ Σ |w|² of the modes of the plate after pulses from rest \[J\].
fn modal_energy(pulses: &[ImpactPulse]) -> f64 {
    let known = modes(PLATE, &[(DVec3::ZERO, DVec3::ZERO)]).unwrap();
    let state = |(i, f): (usize, &f64)| {
        let amplitude = |pulse: &ImpactPulse| {
            let points: Vec<_> = pulse.modal_impulses_on(PLATE).flatten().collect();
            let along: f64 = points.iter().map(|(_, j)| known.motions[0][i].dot(*j)).sum();
            along * pulse.shape.centred_spectrum(TAU * f, pulse.duration)
        };
        0.5 * pulses.iter().map(amplitude).sum::<num_complex::Complex64>().norm_sqr()
    };
    known.frequencies.iter().enumerate().map(state).sum()
}

#[test]
fn a_solved_force_has_the_recorded_impulse_and_no_more_energy_than_the_approach() {
    for restitution in [0.1, 0.5, 0.8] {
        let mut solver = ImpactSolver::default();
        let impact = impact(restitution);
        let pulses = contact_forces(&impact, &modes, &ForceSettings::default(), &mut solver).unwrap();
        let report = solver.report();
        assert_eq!((report.solved, report.closed, report.fallen_back), (1, 0, 0));
        let impulse: DVec3 = pulses.iter().flat_map(|pulse| &pulse.points).map(|(_, j)| *j).sum();
        assert!((impulse - impact.points[0].impulse).length() < 1e-12 * impulse.length());
        assert!(pulses.iter().all(|pulse| matches!(pulse.shape, ForceShape::History(_))));
        // A force of the rigid bodies would give the modes several times what the approach has.
        assert!(pulses[0].modal_energy_ratio > 2.0, "{}", pulses[0].modal_energy_ratio);
        let scale = report.largest_scale.min(2.0);
        let share = modal_energy(&pulses) / pulses[0].approach_energy() / scale.powi(2);
        assert!(share > 0.1 && share < 1.0, "{restitution}: {share} at {scale}");
    }
}

/// An impulse ten times as large as that of the contact: bodies get twice the solved force, and the rest with
/// no greater one, of which modes have nothing.
#[test]
fn what_a_contact_does_not_give_acts_slowly() {
    let forces = |factor: f64| {
        let mut solver = ImpactSolver::default();
        let mut impact = impact(0.1);
        impact.points.iter_mut().for_each(|point| point.impulse *= factor);
        let pulses = contact_forces(&impact, &modes, &ForceSettings::default(), &mut solver).unwrap();
        (impact.points[0].impulse, pulses, solver.report().largest_scale)
    };
    let (_, solved, scale) = forces(1.0);
    let (impulse, pulses, _) = forces(10.0);
    let sum: DVec3 = pulses.iter().flat_map(|pulse| &pulse.points).map(|(_, j)| *j).sum();
    assert!((sum - impulse).length() < 1e-12 * impulse.length());
    let greatest = |pulse: &ImpactPulse| {
        let ForceShape::History(history) = &pulse.shape else { panic!("a history") };
        history.values().iter().copied().fold(0.0, f64::max) * pulse.points[0].1.length()
    };
    let [fast, slow] = &pulses[..] else { panic!("{} pulses", pulses.len()) };
    let twice = 2.0 * greatest(&solved[0]) / scale;
    println!("{} N of {twice} N, then {} N for {} s", greatest(fast), greatest(slow), slow.duration);
    assert!((greatest(fast) / twice - 1.0).abs() < 1e-9 && greatest(slow) < 1.01 * twice);
    assert!(slow.duration >= fast.duration && slow.bodies[0].unwrap().modal_gain == 0.0);
    let share = modal_energy(&pulses) / modal_energy(&solved) / (2.0 / scale).powi(2);
    assert!((share - 1.0).abs() < 1e-9, "{share}");
}

#[test]
fn a_body_that_rings_meets_the_next_impact_with_its_vibration() {
    let settings = ForceSettings::default();
    let mut solver = ImpactSolver::default();
    let first = contact_forces(&impact(0.5), &modes, &settings, &mut solver).unwrap();
    let second = contact_forces(&impact(0.5).at_time(3e-3), &modes, &settings, &mut solver).unwrap();
    let shape = |pulses: &[ImpactPulse]| {
        let ForceShape::History(history) = &pulses[0].shape else { panic!("a history") };
        Arc::clone(history)
    };
    let (at_rest, ringing) = (shape(&first), shape(&second));
    let apart = |other: &[f64]| {
        let peak = at_rest.values().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let pairs = at_rest.values().iter().zip(other);
        pairs.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / peak
    };
    assert!(apart(ringing.values()) > 0.02, "{}", apart(ringing.values()));
    // After twenty seconds nothing of it is left.
    let late = contact_forces(&impact(0.5).at_time(20.0), &modes, &settings, &mut solver).unwrap();
    assert!(apart(shape(&late).values()) < 1e-6, "{}", apart(shape(&late).values()));
}

#[test]
fn a_vibration_does_not_grow_before_its_impact_ends() {
    let damped = |id: BodyId, points: &[(DVec3, DVec3)]| {
        let known = modes(id, points)?;
        Some(ModesAtContact { damping_ratios: vec![0.8; known.frequencies.len()], ..known })
    };
    let mut solver = ImpactSolver::default();
    let settings = ForceSettings::default();
    // The second impact begins while the first still lasts in the clock of the first, by the whole of 0.1 s.
    for time in [0.1, 0.0] {
        let pulses = contact_forces(&impact(0.5).at_time(time), &damped, &settings, &mut solver).unwrap();
        let energy = modal_energy(&pulses);
        assert!(energy.is_finite() && energy < 1.0, "{time} s: {energy} J");
    }
    assert_eq!((solver.report().solved, solver.report().fallen_back), (2, 0));
}

/// A steel cube of 20 mm, and a row that pushes it at a place along a normal.
fn cube() -> Body {
    let mut cube = Body::sphere("cube", presets::STEEL.material(), 0.01);
    let mass = 7850.0 * 8e-6;
    (cube.mass, cube.inertia) = (mass, DMat3::from_diagonal(DVec3::splat(mass * 4e-4 / 6.0)));
    cube
}

fn row(point: DVec3, normal: DVec3, impulse_n: f64) -> ContactRow {
    ContactRow {
        time: 0.1,
        body_a: BodyId(0),
        body_b: BodyId(1),
        kind: ContactKind::Impact,
        point,
        normal,
        impulse_n,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: -SPEED * normal,
        depth: 0.0,
        impact_id: 1,
        effective_mass: None,
    }
}

fn wall() -> Body {
    let surface = Arc::new(Surface::HalfSpace);
    Body { surface, motion: Motion::Fixed, mass: f64::INFINITY, ..cube() }
}

#[test]
fn opposed_impulses_of_one_impact_turn_the_body() {
    let bodies = [cube(), wall()];
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let rows = [
        row(DVec3::new(0.009, -0.01, 0.0), DVec3::Y, 0.02),
        row(DVec3::new(-0.009, 0.01, 0.0), DVec3::NEG_Y, 0.02),
    ];
    let (pulses, report) = impact_pulses(&bodies, &rows, &poses, &ContactSettings::default()).unwrap();
    assert_eq!((report.pulses, report.without_impulse), (1, 0));
    let shares = || pulses.iter().filter_map(|pulse| pulse.bodies[0]);
    let impulse: DVec3 = shares().map(|share| share.impulse).sum();
    let turned: DVec3 = shares().map(|share| share.angular_velocity_change).sum();
    // 2 × 0.02 N s × 9 mm over the moment of inertia.
    let expected = 0.02 * 0.018 / bodies[0].inertia.z_axis.z;
    assert!(
        impulse.length() < 1e-15 && (turned - DVec3::Z * expected).length() < 1e-9 * expected,
        "{turned}"
    );
    // The sound is that of the two forces: each acts with the shape that the solve gives it.
    for pulse in &pulses {
        assert!((pulse.shape.centred_spectrum(0.0, pulse.duration).re - 1.0).abs() < 1e-6);
    }
}

#[test]
fn a_landing_on_many_points_keeps_the_recorded_sum() {
    let bodies = [cube(), wall()];
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let rows = corners.map(|(x, z)| row(DVec3::new(0.009 * x, -0.01, 0.009 * z), DVec3::Y, 0.025));
    let (pulses, report) = impact_pulses(&bodies, &rows, &poses, &ContactSettings::default()).unwrap();
    assert_eq!((report.pulses, report.solves.solved), (1, 1));
    // All four press alike, so they share one shape.
    assert_eq!(pulses.len(), 1);
    let share = pulses[0].bodies[0].unwrap();
    assert!((share.impulse - DVec3::Y * 0.1).length() < 1e-12, "{}", share.impulse);
    assert!(share.angular_impulse.length() < 1e-12, "{}", share.angular_impulse);
}

#[test]
fn too_many_contacts_fall_back_and_say_so() {
    let bodies = [cube(), wall()];
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let place =
        |i: usize| DVec3::new(0.2e-3 * (i % 100) as f64 - 0.01, -0.01, 0.2e-3 * (i / 100) as f64 - 0.01);
    let rows: Vec<ContactRow> = (0..10_000).map(|i| row(place(i), DVec3::Y, 1e-5)).collect();
    let (pulses, report) = impact_pulses(&bodies, &rows, &poses, &ContactSettings::default()).unwrap();
    assert_eq!((report.solves.fallen_back, report.solves.solved, pulses.len()), (1, 0, 1));
    let share = pulses[0].bodies[0].unwrap();
    assert!((share.impulse - DVec3::Y * 0.1).length() < 1e-9, "{}", share.impulse);
}

#[test]
fn modes_without_mass_and_overlapping_bodies_give_forces_all_the_same() {
    // Modes that are not finite, or of zero or negative frequency.
    for (frequency, motion) in [(0.0, 1.0), (-5.0, 1.0), (f64::NAN, 1.0), (500.0, f64::INFINITY)] {
        let broken = |id: BodyId, points: &[(DVec3, DVec3)]| {
            (id == PLATE).then(|| ModesAtContact {
                frequencies: vec![frequency],
                damping_ratios: vec![0.0],
                motions: points.iter().map(|_| vec![motion * DVec3::Y]).collect(),
            })
        };
        let mut solver = ImpactSolver::default();
        let pulses = contact_forces(&impact(0.5), &broken, &ForceSettings::default(), &mut solver).unwrap();
        assert!(pulses.iter().all(|pulse| pulse.duration.is_finite()), "{frequency} {motion}");
    }
    // Two equal bodies at the same place.
    let mut twice = impact(0.5);
    twice.sides[1] = ContactSide { body: BALL, ..twice.sides[0] };
    let point = twice.points[0];
    twice.points = vec![point, ContactPoint { gap: -1e-3, ..point }];
    let pulses =
        contact_forces(&twice, &no_modes, &ForceSettings::default(), &mut ImpactSolver::default()).unwrap();
    assert!(pulses.iter().flat_map(|pulse| &pulse.points).all(|(_, j)| j.is_finite()));
}

#[test]
fn the_step_of_real_time_is_close_to_that_of_a_file() {
    let levels = [8.0, 16.0].map(|steps| {
        let settings = ForceSettings { steps, ..ForceSettings::default() };
        let pulses = contact_forces(&impact(0.3), &modes, &settings, &mut ImpactSolver::default()).unwrap();
        10.0 * modal_energy(&pulses).log10()
    });
    // Residual seen: see the message.
    assert!((levels[0] - levels[1]).abs() < 0.8, "{levels:?}");
}

#[test]
fn impacts_of_a_timeline_pass_through_one_solver() {
    let bodies = bodies();
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let point = DVec3::new(0.1, 0.0, 0.0);
    let hit = |time: f64, impact_id: u64| ContactRow { time, impact_id, ..row(point, DVec3::NEG_Y, 0.01) };
    let rows = [hit(0.1, 1), hit(0.101, 2), hit(0.103, 3)];
    let struck = StruckBodies { modes: &modes, ..StruckBodies::rigid(&bodies, &poses) };
    let (pulses, report) = impact_pulses_on(struck, &rows, &ContactSettings::default()).unwrap();
    assert_eq!((report.pulses, report.solves.solved), (3, 3));
    let shapes: Vec<_> = pulses.iter().map(|pulse| pulse.shape.clone()).collect();
    assert!(shapes[0] != shapes[1] && shapes[1] != shapes[2]);
}
