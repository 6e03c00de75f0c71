//! Invariants of any impact: momentum, symmetry, the bounds of Hertz's formula, the order of chains.

use std::sync::Arc;

use crate::bodies::{ball, cube, material, pan_steel_ball};
use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::contact::chain_onset::delay_chains;
use clangor_core::contact::{
    ContactError, ContactReport, ContactSettings, ImpactPulse, PoseHistory, impact_pulses,
};
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};

fn row(
    a: u32,
    b: u32,
    point: DVec3,
    normal: DVec3,
    speed: f64,
    impulse_n: f64,
    impact_id: u64,
) -> ContactRow {
    ContactRow {
        time: 1.0,
        body_a: BodyId(a),
        body_b: BodyId(b),
        kind: ContactKind::Impact,
        point,
        normal,
        impulse_n,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: normal * -speed,
        depth: 0.0,
        impact_id,
        effective_mass: None,
    }
}

fn pulses(bodies: &[Body], rows: &[ContactRow]) -> (Vec<ImpactPulse>, ContactReport) {
    let poses = PoseHistory::try_new(bodies, &[]).unwrap();
    impact_pulses(bodies, rows, &poses, &ContactSettings::default()).unwrap()
}

/// A ball and a fixed half-space of the same material.
fn ball_and_floor() -> [Body; 2] {
    let ball = pan_steel_ball(0.01, DVec3::Y * 0.01);
    let surface = Arc::new(Surface::HalfSpace);
    let floor = Body { surface, motion: Motion::Fixed, mass: f64::INFINITY, ..ball.clone() };
    [ball, floor]
}

#[test]
fn merged_impact_keeps_momentum_and_angular_momentum_of_all_its_points() {
    let bodies = [pan_steel_ball(0.01, DVec3::ZERO), pan_steel_ball(0.02, DVec3::new(0.0, -0.03, 0.0))];
    let mut rows = [
        row(0, 1, DVec3::new(0.001, -0.01, 0.0), DVec3::Y, 1.0, 0.02, 7),
        row(0, 1, DVec3::new(-0.001, -0.01, 0.002), DVec3::Y, 2.0, 0.01, 7),
        row(0, 1, DVec3::new(0.0, -0.01, 0.0), DVec3::Y, 9.0, 0.005, 7),
    ];
    rows[1].impulse_t = DVec3::new(0.003, 0.0, -0.001);
    rows[1].couple = DVec3::new(0.0, 1e-5, 0.0);
    rows[2].time += 1e-4;
    let (pulses, report) = pulses(&bodies, &rows);
    // Each point has a force history of its own.
    let total = |side: usize| {
        let shares: Vec<_> = pulses.iter().map(|pulse| pulse.bodies[side].unwrap()).collect();
        clangor_core::contact::BodyPulse {
            impulse: shares.iter().map(|share| share.impulse).sum(),
            velocity_change: shares.iter().map(|share| share.velocity_change).sum(),
            angular_impulse: shares.iter().map(|share| share.angular_impulse).sum(),
            ..shares[0]
        }
    };
    let (a, b, pulse) = (total(0), total(1), &pulses[0]);
    // Residual seen: 0 and 4e-20.
    assert!((a.impulse + b.impulse).length() < 1e-17);
    let about_origin = |share: &clangor_core::contact::BodyPulse| {
        share.angular_impulse + share.pose.position.cross(share.impulse)
    };
    assert!((about_origin(&a) + about_origin(&b)).length() < 1e-18);
    // Residual seen: 5e-19.
    assert!((a.velocity_change * bodies[0].mass - a.impulse).length() < 1e-16);
    assert_eq!(pulse.speed, 2.0, "the faster of the first instant's points, not the later one");
    assert_eq!((report.pulses, report.bodies[0].pulses, report.bodies[1].pulses), (1, 1, 1));
}

#[test]
fn exchanging_the_bodies_changes_only_signs() {
    let bodies = [
        ball(material("glass", 2600.0, 62e9, 0.2), 0.01, DVec3::ZERO),
        pan_steel_ball(0.02, DVec3::new(0.0, -0.03, 0.0)),
    ];
    let point = DVec3::new(0.0, -0.01, 0.0);
    let forth = &pulses(&bodies, &[row(0, 1, point, DVec3::Y, 1.0, 0.02, 1)]).0[0];
    let back = &pulses(&bodies, &[row(1, 0, point, DVec3::NEG_Y, 1.0, 0.02, 1)]).0[0];
    // Residual seen: 1e-16.
    assert!((forth.duration / back.duration - 1.0).abs() < 1e-14);
    assert_eq!(forth.bodies[0].unwrap().impulse, back.bodies[1].unwrap().impulse);
}

#[test]
fn eccentric_impact_feels_less_mass_however_the_body_is_turned() {
    let (edge, offset) = (0.02, 0.007);
    let turn = DQuat::from_scaled_axis(DVec3::new(0.4, -1.0, 0.7));
    let centre = DVec3::new(0.5, 0.2, -0.3);
    let body = Body { pose: Pose { position: centre, orientation: turn }, ..cube(edge) };
    let (point, normal) = (turn * DVec3::new(offset, -0.5 * edge, 0.0) + centre, turn * DVec3::Y);
    let (mass, inertia) = (body.mass, body.mass * edge * edge / 6.0);
    let (pulses, _) = pulses(&[body], &[row(0, u32::MAX, point, normal, 1.0, 0.02, 1)]);
    // [PAN] eq. (9) with I = M edge²/6. Residual seen: 4e-16.
    let expected = 1.0 / (1.0 / mass + offset * offset / inertia);
    assert!((pulses[0].effective_mass / expected - 1.0).abs() < 1e-12);
    // The torque is about the axis normal to arm and normal: 0.02 N s times the offset. Residual seen: 5e-20.
    let torque = pulses[0].bodies[0].unwrap().angular_impulse;
    assert!((torque - turn * DVec3::Z * (0.02 * offset)).length() < 1e-17);
}

#[test]
fn floor_radiates_nothing_but_softens_the_contact() {
    let bodies = ball_and_floor();
    let on = |other| pulses(&bodies, &[row(0, other, DVec3::ZERO, DVec3::Y, 1.0, 0.06, 1)]).0.remove(0);
    let (floor, rigid) = (on(1), on(u32::MAX));
    assert!(floor.bodies[1].is_none() && rigid.bodies[1].is_none());
    // Twice the compliance: τ grows by 2^{2/5}. Residual seen: 2e-16.
    assert!((floor.duration / rigid.duration - 2f64.powf(0.4)).abs() < 1e-12);
    assert_eq!(floor.effective_mass, bodies[0].mass);
    assert!(floor.bodies[0].unwrap().transit_ratio > 1.0);
}

#[test]
fn silent_impacts_are_counted_by_reason() {
    let bodies = ball_and_floor();
    let rows = [
        row(0, 1, DVec3::ZERO, DVec3::Y, 0.049, 0.06, 1),
        row(0, 1, DVec3::ZERO, DVec3::Y, 1.0, 0.0, 2),
        row(1, u32::MAX, DVec3::ZERO, DVec3::Y, 1.0, 0.06, 3),
        ContactRow { kind: ContactKind::Contact, ..row(0, 1, DVec3::ZERO, DVec3::Y, 1.0, 0.06, 0) },
        row(0, 1, DVec3::ZERO, DVec3::Y, 1.0, 0.06, 0),
    ];
    let (pulses, report) = pulses(&bodies, &rows);
    assert_eq!(pulses.len(), 1);
    assert_eq!((report.slow, report.without_impulse, report.immovable, report.pulses), (1, 1, 1, 1));
    assert_eq!((report.bodies[0].slow, report.bodies[0].pulses), (1, 1));
}

#[test]
fn impact_travels_along_a_touching_chain() {
    let balls: Vec<Body> = (0..5).map(|i| pan_steel_ball(0.01, DVec3::X * (0.02 * i as f64))).collect();
    let touch = |i: u32| {
        let point = DVec3::X * (0.02 * f64::from(i) + 0.01);
        row(i + 1, i, point, DVec3::X, 1.0, 0.03, u64::from(i) + 1)
    };
    let rows: Vec<ContactRow> = (0..4).map(touch).collect();
    let (chain, report) = pulses(&balls, &rows);
    assert_eq!(report.delayed, 3);
    for (k, pulse) in chain.iter().enumerate() {
        // Residual seen: 0.
        let expected = 1.0 + 0.5 * k as f64 * pulse.duration;
        assert!((pulse.onset - expected).abs() < 1e-15, "contact {k}");
        assert_eq!(pulse.time, 1.0);
    }

    let off = ContactSettings { chain_onset: false, ..ContactSettings::default() };
    let poses = PoseHistory::try_new(&balls, &[]).unwrap();
    let (together, report) = impact_pulses(&balls, &rows, &poses, &off).unwrap();
    assert_eq!(report.delayed, 0);
    assert!(together.iter().all(|pulse| pulse.onset == 1.0));
}

#[test]
fn the_pulses_of_one_impact_begin_together() {
    // Two forces of the first impact, the stronger one shorter, and an impact that they are passed on to; no
    // poses say who moves.
    let balls: Vec<Body> = (0..3).map(|i| pan_steel_ball(0.01, DVec3::X * (0.02 * i as f64))).collect();
    let touch = |i: u32, speed: f64| {
        let point = DVec3::X * (0.02 * f64::from(i) + 0.01);
        row(i + 1, i, point, DVec3::X, speed, 0.03, u64::from(i) + 1)
    };
    let (chain, _) = pulses(&balls, &[touch(0, 1.0), touch(1, 0.5)]);
    let [strong, next] =
        [&chain[0], &chain[1]].map(|pulse| ImpactPulse { onset: pulse.time, ..pulse.clone() });
    let weak_points = strong.points.iter().map(|(place, j)| (*place, 0.1 * *j)).collect();
    let weak = ImpactPulse { duration: 3.0 * strong.duration, points: weak_points, ..strong.clone() };
    for own in [[&weak, &strong], [&strong, &weak]] {
        let mut all: Vec<ImpactPulse> = own.into_iter().chain([&next]).cloned().collect();
        assert_eq!(delay_chains(&mut all), 1);
        assert_eq!([all[0].onset, all[1].onset], [strong.time; 2]);
        // Residual seen: 0.
        assert!((all[2].onset - strong.time - 0.5 * strong.duration).abs() < 1e-15);
    }
}

/// Pose of a ball at the time of [`row`].
fn pose(body: u32, x: f64, velocity: f64) -> PoseRow {
    PoseRow {
        time: 1.0,
        body: BodyId(body),
        position: DVec3::X * x,
        orientation: DQuat::IDENTITY,
        velocity: DVec3::X * velocity,
        angular_velocity: DVec3::ZERO,
    }
}

#[test]
fn impact_crosses_narrow_gaps_as_if_closed_and_wide_gaps_in_their_own_time() {
    // Balls of equal mass pass the whole velocity of 1 m/s on across three gaps.
    let balls: Vec<Body> = (0..4).map(|i| pan_steel_ball(0.01, DVec3::X * (0.02 * i as f64))).collect();
    let momentum = balls[0].mass;
    let onsets = |gap: f64| {
        let (mut rows, mut poses) = (Vec::new(), Vec::new());
        for i in 0..3u32 {
            let (x, time) = (0.02 * f64::from(i), 1.0 + gap * f64::from(i));
            let touch = row(i + 1, i, DVec3::X * (x + 0.01), DVec3::X, 1.0, momentum, u64::from(i) + 1);
            rows.push(ContactRow { time, ..touch });
            // Approach before the instant: without gaps only the first ball moves.
            let moving = if i == 0 || gap > 0.0 { 1.0 } else { 0.0 };
            poses.push(PoseRow { time, ..pose(i, x, moving) });
            poses.push(PoseRow { time, ..pose(i + 1, x + 0.02, 0.0) });
        }
        let poses = PoseHistory::try_new(&balls, &poses).unwrap();
        let (pulses, _) = impact_pulses(&balls, &rows, &poses, &ContactSettings::default()).unwrap();
        (pulses.iter().map(|pulse| pulse.onset - 1.0).collect::<Vec<f64>>(), 0.5 * pulses[0].duration)
    };
    for (gap, wide) in [(0.0, false), (5e-6, false), (30e-6, false), (50e-6, true)] {
        let (onsets, half) = onsets(gap);
        // Half a duration is 39 µs.
        assert_eq!(gap > half, wide);
        for (k, onset) in onsets.iter().enumerate() {
            let expected = k as f64 * gap.max(half);
            // Residual seen: 1e-16, the rounding of times near 1 s.
            assert!((onset - expected).abs() < 1e-14, "{gap}: {onset} against {expected}");
        }
    }
}

#[test]
fn two_balls_struck_at_once_sound_at_once() {
    let balls: Vec<Body> = (0..3).map(|i| pan_steel_ball(0.01, DVec3::X * (0.02 * i as f64))).collect();
    for lag in [0.0, 1e-9] {
        // The middle ball stands; both neighbours hit it.
        let left = row(1, 0, DVec3::X * 0.01, DVec3::X, 1.0, 0.03, 1);
        let right = ContactRow { time: 1.0 + lag, ..row(2, 1, DVec3::X * 0.03, DVec3::X, 1.0, 0.03, 2) };
        let after = 0.03 / balls[1].mass * if lag > 0.0 { 1.0 } else { 0.0 };
        let states = [pose(0, 0.0, 1.0), pose(1, 0.02, 0.0), pose(2, 0.04, -1.0)];
        let later = [pose(1, 0.02, after), pose(2, 0.04, -1.0)].map(|p| PoseRow { time: 1.0 + lag, ..p });
        let all: Vec<PoseRow> = states.into_iter().chain(later).collect();
        let poses = PoseHistory::try_new(&balls, &all).unwrap();
        let (pulses, report) =
            impact_pulses(&balls, &[left, right], &poses, &ContactSettings::default()).unwrap();
        assert_eq!((pulses.len(), report.delayed), (2, 0), "{lag} s apart");
    }
}

#[test]
fn impacts_of_one_instant_that_share_only_the_floor_are_no_chain() {
    let [ball, floor] = ball_and_floor();
    let other = Body { pose: Pose::at(DVec3::X), ..ball.clone() };
    let bodies = [ball, floor, other];
    let rows = [row(0, 1, DVec3::ZERO, DVec3::Y, 1.0, 0.06, 1), row(2, 1, DVec3::X, DVec3::Y, 1.0, 0.06, 2)];
    assert_eq!(pulses(&bodies, &rows).1.delayed, 0);
}

#[test]
fn pose_of_the_impact_is_found_and_others_are_between_their_neighbours() {
    let bodies = [pan_steel_ball(0.01, DVec3::ZERO)];
    let pose = |time: f64, x: f64, turn: f64| PoseRow {
        time,
        body: BodyId(0),
        position: DVec3::X * x,
        orientation: DQuat::from_rotation_y(turn),
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
    };
    let history =
        PoseHistory::try_new(&bodies, &[pose(2.0, 3.0, 0.4), pose(1.0, 1.0, 0.2), pose(1.5, 9.0, 0.0)])
            .unwrap();
    assert_eq!(history.at(BodyId(0), 1.5).position.x, 9.0);
    assert_eq!(history.at(BodyId(0), 0.5).position.x, 0.5);
    assert_eq!(history.at(BodyId(0), 7.0).position.x, 3.0);
    // Residual seen: 1e-17.
    assert!(history.at(BodyId(0), 0.5).orientation.angle_between(DQuat::from_rotation_y(0.1)) < 1e-7);
    let unknown = PoseRow { body: BodyId(3), ..pose(0.0, 0.0, 0.0) };
    let error = PoseHistory::try_new(&bodies, &[unknown]).unwrap_err();
    assert!(matches!(error, ContactError::UnknownBody { body: 3, bodies: 1, .. }));
}

#[test]
fn bad_rows_are_errors() {
    let bodies = ball_and_floor();
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let run = |row| impact_pulses(&bodies, &[row], &poses, &ContactSettings::default());
    let good = row(0, 1, DVec3::ZERO, DVec3::Y, 1.0, 0.06, 1);
    assert!(matches!(run(ContactRow { impulse_n: f64::NAN, ..good }), Err(ContactError::NotFinite { .. })));
    assert!(matches!(run(ContactRow { body_b: BodyId(2), ..good }), Err(ContactError::UnknownBody { .. })));
}
