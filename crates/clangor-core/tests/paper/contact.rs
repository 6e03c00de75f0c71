//! Numbers that the papers print about contact.

use crate::bodies::pan_steel_ball;
use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{ContactSettings, PoseHistory, impact_pulses};
use clangor_core::glam::DVec3;
use clangor_core::timeline::{ContactKind, ContactRow};

/// Duration [s] of the impact of a ball that touches y = 0 on the world, a rigid plane, at a speed [m/s].
fn duration_on_rigid_plane(body: Body, speed: f64) -> f64 {
    let row = ContactRow {
        time: 0.0,
        body_a: BodyId(0),
        body_b: BodyId::WORLD,
        kind: ContactKind::Impact,
        point: DVec3::ZERO,
        normal: DVec3::Y,
        impulse_n: 2.0 * body.mass * speed,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: DVec3::new(0.3, -speed, 0.0),
        depth: 0.0,
        impact_id: 1,
        effective_mass: None,
    };
    let bodies = [body];
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let (pulses, _) = impact_pulses(&bodies, &[row], &poses, &ContactSettings::default()).unwrap();
    pulses[0].duration
}

#[test]
fn ball_bearing_pulse_time_scale_of_pan_table_1() {
    let ball = pan_steel_ball(0.0075, DVec3::Y * 0.0075);
    let h = duration_on_rigid_plane(ball, 5.0) / 5.0;
    // [PAN] Table 1 prints 7.3264 µs; seen: 7.335 µs.
    assert!((h - 7.34e-6).abs() < 0.01e-6, "{h:e}");
}
