//! Recorded bodies on joints of the scene: their impulses and effective masses are those of linkages.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, JointKind, Link, LinkEnd, MeshSurface, Motion, Surface, World};
use clangor_core::material::presets;
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;
use clangor_core::timeline::{ContactKind, ContactRow};
use clangor_pipeline::motion::impacts::find_impacts;
use clangor_pipeline::motion::recording::{Frame, RecordedBody};
use glam::{DQuat, DVec3};

const GRAVITY: f64 = 9.81;
const RATES: [f64; 3] = [60.0, 240.0, 1000.0];
/// Length and half of the thickness of a bar that hangs from its upper end \[m\].
const LENGTH: f64 = 0.4;
const HALF: f64 = 0.01;
/// Radius of a ball at the lower end of the way of a bar \[m\], and its depth below the hinge.
const BALL: f64 = 0.02;
const DEPTH: f64 = 0.35;
/// Instant of the impact \[s\], angular velocities of the bar before it and after it [rad/s].
const INSTANT: f64 = 0.3071;
const BEFORE: f64 = -3.0;
const AFTER: f64 = 1.8;

fn bar() -> Body {
    let mesh = Shape::parse("box:0.02x0.4x0.02").unwrap().mesh();
    let (surface, properties) = MeshSurface::try_new(mesh, Vec::new()).unwrap();
    Body::solid("bar", presets::STEEL.material(), Arc::new(Surface::Mesh(surface)), &properties)
}

/// About the hinge [kg m²].
fn inertia(bar: &Body) -> f64 {
    bar.inertia.z_axis.z + bar.mass * (0.5 * LENGTH).powi(2)
}

/// A hinge of a bar at a fixed point, about z.
fn hinge(body: u32, point: DVec3) -> Link {
    Link::Joint {
        body: BodyId(body),
        at: DVec3::Y * (0.5 * LENGTH),
        to: LinkEnd::Point(point),
        kind: JointKind::Hinge { axis: DVec3::Z, damping: 0.0 },
        collide: false,
    }
}

/// Angle of a swinging bar at a time since its impact at angle 0, by Runge and Kutta in steps of 10 µs at
/// most.
fn angle(bar: &Body, since: f64) -> f64 {
    let stiffness = bar.mass * GRAVITY * 0.5 * LENGTH / inertia(bar);
    let steps = (since.abs() / 1e-5).ceil().max(1.0);
    let h = since / steps;
    let (mut at, mut speed) = (0.0, if since < 0.0 { BEFORE } else { AFTER });
    for _ in 0..steps as u64 {
        let rate = |at: f64, speed: f64| (speed, -stiffness * f64::sin(at));
        let (a, b) = rate(at, speed);
        let (c, d) = rate(at + 0.5 * h * a, speed + 0.5 * h * b);
        let (e, f) = rate(at + 0.5 * h * c, speed + 0.5 * h * d);
        let (g, i) = rate(at + h * e, speed + h * f);
        at += h / 6.0 * (a + 2.0 * c + 2.0 * e + g);
        speed += h / 6.0 * (b + 2.0 * d + 2.0 * f + i);
    }
    at
}

/// A bar below `point` that swings with a sign of its angles.
fn swinging(body: u32, point: DVec3, sign: f64, rate: f64) -> RecordedBody {
    let one = bar();
    let frame = |k: u64| {
        let time = k as f64 / rate;
        let orientation = DQuat::from_rotation_z(sign * angle(&one, time - INSTANT));
        let pose = Pose { position: point - orientation * DVec3::Y * (0.5 * LENGTH), orientation };
        Frame { time, pose, row: k }
    };
    RecordedBody { body: BodyId(body), frames: (0..=(0.6 * rate) as u64).map(frame).collect(), group: None }
}

fn impacts(bodies: Vec<Body>, links: Vec<Link>, recorded: &[RecordedBody]) -> Vec<ContactRow> {
    let mut world = World { bodies, links, gravity: DVec3::NEG_Y * GRAVITY };
    for RecordedBody { body, frames, .. } in recorded {
        world.bodies[body.index()].pose = frames[0].pose;
    }
    let found = find_impacts(&world, recorded, 0.05);
    found.contacts.into_iter().filter(|row| row.kind == ContactKind::Impact).collect()
}

/// A ball that nothing moves beside the lower end of a bar that hangs from the origin.
fn stop() -> Body {
    let mut stop = Body::sphere("stop", presets::STEEL.material(), BALL);
    stop.pose = Pose::at(DVec3::new(-BALL - HALF, -DEPTH, 0.0));
    stop.motion = Motion::Fixed;
    stop
}

#[test]
fn analytic_a_bar_on_a_hinge_gives_a_stop_its_angular_momentum_over_the_arm() {
    for rate in RATES {
        let rows =
            impacts(vec![bar(), stop()], vec![hinge(0, DVec3::ZERO)], &[swinging(0, DVec3::ZERO, 1.0, rate)]);
        assert_eq!(rows.len(), 1, "{rate} Hz: {rows:?}");
        let expected = inertia(&bar()) * (AFTER - BEFORE) / DEPTH;
        let off = rows[0].impulse_n / expected - 1.0;
        let mass = rows[0].effective_mass.unwrap() / (inertia(&bar()) / DEPTH.powi(2)) - 1.0;
        let across = rows[0].impulse_t.length() / rows[0].impulse_n;
        println!("{rate} Hz: impulse {off:.1e}, effective mass {mass:.1e}, friction {across:.1e}");
        // Seen: 5.5e-3, 3.8e-4, 2.0e-5; masses 8.3e-4, 1.1e-4, 4.7e-7.
        assert!(off.abs() < 4.0 * (BEFORE / rate).powi(2) && mass.abs() < 0.002, "{rate} Hz: {off} {mass}");
    }
}

#[test]
fn analytic_two_bars_on_hinges_share_their_angular_momentum() {
    let apart = DVec3::X * (2.0 * HALF);
    for rate in RATES {
        let recorded = [swinging(0, apart, 1.0, rate), swinging(1, DVec3::ZERO, -1.0, rate)];
        let rows = impacts(vec![bar(), bar()], vec![hinge(0, apart), hinge(1, DVec3::ZERO)], &recorded);
        // They meet along their whole faces: what is known is the moment of the impulses about the hinges.
        let moment: f64 = rows.iter().map(|row| row.impulse_n * -row.point.y).sum();
        let off = moment / (inertia(&bar()) * (AFTER - BEFORE)) - 1.0;
        println!("{rate} Hz: {} rows, moment {off:.1e}", rows.len());
        for row in &rows {
            let expected = 0.5 * inertia(&bar()) / row.point.y.powi(2);
            let mass = row.effective_mass.unwrap() / expected - 1.0;
            println!("  at {:.3} m: {:.4} N s, effective mass {mass:.1e}", row.point.y, row.impulse_n);
            // Seen: 7.7e-4.
            assert!(mass.abs() < 0.002 && row.point.y < -0.05, "{row:?}");
        }
        // Seen: 5.4e-3, 3.9e-4, 2.0e-5.
        assert!(off.abs() < 12.0 * (BEFORE / rate).powi(2), "{rate} Hz: {off}");
    }
}

/// What has left its hinge is a free body.
#[test]
fn analytic_a_bar_off_its_hinge_has_no_effective_mass() {
    let recorded = [swinging(0, DVec3::ZERO, 1.0, 240.0)];
    let rows = impacts(vec![bar(), stop()], vec![hinge(0, DVec3::X * 0.1)], &recorded);
    assert!(!rows.is_empty() && rows.iter().all(|row| row.effective_mass.is_none()), "{rows:?}");
}
