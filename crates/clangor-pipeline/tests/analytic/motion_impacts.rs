//! Impacts of motions in closed form, sampled at several rates: who, when, where, and with which impulse.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, MeshSurface, Surface, World};
use clangor_core::material::presets;
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;
use clangor_core::timeline::ContactKind;
use clangor_pipeline::motion::impacts::{MotionImpacts, find_impacts};
use clangor_pipeline::motion::recording::{Frame, RecordedBody};
use glam::{DQuat, DVec3};

const GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);
const RATES: [f64; 5] = [24.0, 60.0, 120.0, 240.0, 1000.0];

/// Free flight from a state at a time, with constant angular velocity.
#[derive(Clone, Copy)]
struct Flight {
    from: f64,
    pose: Pose,
    velocity: DVec3,
    spin: DVec3,
}

impl Flight {
    fn at(&self, time: f64) -> Pose {
        let t = time - self.from;
        Pose {
            position: self.pose.position + self.velocity * t + GRAVITY * (0.5 * t * t),
            orientation: DQuat::from_scaled_axis(self.spin * t) * self.pose.orientation,
        }
    }
}

fn sampled(body: u32, rate: f64, duration: f64, pose: impl Fn(f64) -> Pose) -> RecordedBody {
    let frame = |k: u64| Frame { time: k as f64 / rate, pose: pose(k as f64 / rate), row: k };
    RecordedBody {
        body: BodyId(body),
        frames: (0..=(duration * rate) as u64).map(frame).collect(),
        group: None,
    }
}

fn world(bodies: Vec<Body>) -> World {
    World { bodies, links: Vec::new(), gravity: GRAVITY }
}

fn floor() -> Body {
    Body::plane("floor", presets::GRANITE.material(), DVec3::ZERO, DVec3::Y)
}

fn cube(edge: f64) -> Body {
    let mesh = Shape::parse(&format!("box:{edge}x{edge}x{edge}")).unwrap().mesh();
    let (surface, mass) = MeshSurface::try_new(mesh, Vec::new()).unwrap();
    Body::solid("cube", presets::STEEL.material(), Arc::new(Surface::Mesh(surface)), &mass)
}

fn heard(found: &MotionImpacts) -> Vec<clangor_core::timeline::ContactRow> {
    found.contacts.iter().filter(|row| row.kind == ContactKind::Impact).copied().collect()
}

#[test]
fn analytic_a_bounce_between_frames_is_found_at_its_instant() {
    let ball = Body::sphere("ball", presets::STEEL.material(), 0.01);
    let (instant, before, after) = (0.5012345, DVec3::new(0.4, -3.0, 0.1), DVec3::new(0.3, 2.1, 0.1));
    let at_impact = Pose::at(DVec3::Y * 0.01);
    let flights = [(0.0, before), (0.0, after)].map(|(_, velocity)| Flight {
        from: instant,
        pose: at_impact,
        velocity,
        spin: DVec3::ZERO,
    });
    for rate in RATES {
        let path = |time: f64| flights[usize::from(time > instant)].at(time);
        let found = find_impacts(&world(vec![ball.clone(), floor()]), &[sampled(0, rate, 0.9, path)], 0.05);
        let rows = heard(&found);
        assert_eq!(rows.len(), 1, "{rate} Hz: {rows:?}");
        let row = rows[0];
        assert_eq!((row.body_a, row.body_b), (BodyId(0), BodyId(1)));
        // A ball of steel on granite without spin keeps its tangential velocity within friction; what the
        // floor gives is m Δv at the point below it. Largest errors seen: 2e-9 s, 4e-9 m/s, 1e-8 of the
        // impulse.
        println!(
            "{rate} Hz: {:.1e} s, {:.1e} m, {:.1e} m/s, impulse {:.1e}",
            row.time - instant,
            row.point.length(),
            row.approach_speed() - 3.0,
            row.impulse_n / (ball.mass * (after - before).y) - 1.0
        );
        assert!((row.time - instant).abs() < 1e-12, "{rate} Hz: {}", row.time);
        assert!(row.point.distance(DVec3::ZERO) < 1e-12, "{rate} Hz: {}", row.point);
        assert!((row.approach_speed() - 3.0).abs() < 1e-12, "{rate} Hz: {}", row.approach_speed());
        let normal = ball.mass * (after - before).y;
        assert!((row.impulse_n / normal - 1.0).abs() < 1e-10, "{rate} Hz: {} for {normal}", row.impulse_n);
    }
}

/// What a body did before its first frame is not recorded; one that is released at rest there explains an
/// impact before the second frame.
#[test]
fn analytic_a_ball_released_at_rest_lands_before_its_second_frame() {
    let ball = Body::sphere("ball", presets::STEEL.material(), 0.01);
    for rate in [24.0, 60.0, 120.0] {
        let instant = 0.8 / rate;
        // No floor throws a body back faster than it came.
        let (before, after) = (GRAVITY * instant, DVec3::new(0.02, 0.7 * 9.81 * instant, 0.0));
        let flights = [before, after].map(|velocity| Flight {
            from: instant,
            pose: Pose::at(DVec3::Y * 0.01),
            velocity,
            spin: DVec3::ZERO,
        });
        let path = |time: f64| flights[usize::from(time > instant)].at(time);
        let found = find_impacts(&world(vec![ball.clone(), floor()]), &[sampled(0, rate, 0.3, path)], 0.05);
        let rows = heard(&found);
        assert_eq!(rows.len(), 1, "{rate} Hz: {rows:?}");
        let row = rows[0];
        let normal = ball.mass * (after - before).y;
        println!(
            "{rate} Hz: {:.1e} s, {:.1e} m/s, impulse {:.1e}",
            row.time - instant,
            row.approach_speed() + before.y,
            row.impulse_n / normal - 1.0
        );
        // Seen: 2e-18 s, 0 m/s, 3e-16 of the impulse.
        assert!((row.time - instant).abs() < 1e-12, "{rate} Hz: {}", row.time);
        assert!((row.approach_speed() + before.y).abs() < 1e-12, "{rate} Hz: {}", row.approach_speed());
        assert!((row.impulse_n / normal - 1.0).abs() < 1e-10, "{rate} Hz: {} for {normal}", row.impulse_n);
    }
}

/// A cube, whose inertia is a number, hits the floor with a corner: an impulse J there gives Δv = J/m and
/// Δω = r × J / I.
#[test]
fn analytic_a_corner_off_the_centre_gets_the_impulse_of_both_jumps() {
    let cube = cube(0.04);
    let corner = DVec3::splat(-0.02);
    let orientation = DQuat::from_rotation_x(0.5) * DQuat::from_rotation_z(-0.4);
    // The lowest corner touches the floor at the origin.
    let corners: Vec<DVec3> = (0..8)
        .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * 0.04 + corner)
        .collect();
    let lowest = corners.iter().copied().min_by(|a, b| (orientation * *a).y.total_cmp(&(orientation * *b).y));
    let arm = orientation * lowest.unwrap();
    let at_impact = Pose { position: -arm, orientation };
    let (instant, velocity, spin) = (0.3007, DVec3::new(0.5, -2.0, 0.2), DVec3::new(3.0, -2.0, 4.0));
    let impulse = DVec3::new(0.03, 0.6, -0.05) * cube.mass;
    let before = Flight { from: instant, pose: at_impact, velocity, spin };
    let after = Flight {
        velocity: velocity + impulse / cube.mass,
        spin: spin + arm.cross(impulse) / cube.inertia.x_axis.x,
        ..before
    };
    for rate in RATES {
        let path = |time: f64| if time > instant { after.at(time) } else { before.at(time) };
        let found = find_impacts(&world(vec![cube.clone(), floor()]), &[sampled(0, rate, 0.6, path)], 0.05);
        let rows = heard(&found);
        assert!(!rows.is_empty(), "{rate} Hz");
        let id = rows[0].impact_id;
        assert!(rows.iter().all(|row| row.impact_id == id && row.body_b == BodyId(1)), "{rate} Hz");
        let sum: DVec3 = rows.iter().map(|row| row.impulse()).sum();
        let error = sum.distance(impulse) / impulse.length();
        println!("{rate} Hz: impulse off by {error:.1e}, instant by {:.1e} s", rows[0].time - instant);
        // A cube has a constant angular velocity, which frames give exactly. Largest errors: 5e-7, 3e-7 s.
        assert!(error < 1e-5, "{rate} Hz: {sum} for {impulse}");
        assert!((rows[0].time - instant).abs() < 5e-6, "{rate} Hz: {}", rows[0].time);
    }
}

#[test]
fn analytic_two_balls_in_flight_get_opposite_impulses() {
    let ball = |name: &str, radius: f64| Body::sphere(name, presets::GLASS.material(), radius);
    let (a, b) = (ball("a", 0.01), ball("b", 0.02));
    let normal = DVec3::new(0.6, 0.0, 0.8);
    let instant = 0.2503;
    let place = Pose::at(DVec3::Y * 5.0);
    let other = Pose::at(place.position - normal * 0.03);
    let impulse = normal * 0.004;
    let (va, vb) = (normal * -1.0, normal * 0.5);
    let flight = |pose, velocity| Flight { from: instant, pose, velocity, spin: DVec3::ZERO };
    let pairs = [
        [flight(place, va), flight(place, va + impulse / a.mass)],
        [flight(other, vb), flight(other, vb - impulse / b.mass)],
    ];
    for rate in RATES {
        let path = |body: usize| move |time: f64| pairs[body][usize::from(time > instant)].at(time);
        let recorded = [sampled(0, rate, 0.5, path(0)), sampled(1, rate, 0.5, path(1))];
        let found = find_impacts(&world(vec![a.clone(), b.clone()]), &recorded, 0.05);
        let rows = heard(&found);
        assert_eq!(rows.len(), 1, "{rate} Hz: {rows:?}");
        let row = rows[0];
        let on_a = if row.body_a == BodyId(0) { row.impulse() } else { -row.impulse() };
        println!("{rate} Hz: {:.1e}", on_a.distance(impulse) / impulse.length());
        // Largest error seen: 5e-15.
        assert!(on_a.distance(impulse) < 1e-10 * impulse.length(), "{rate} Hz: {on_a} for {impulse}");
        assert!((row.approach_speed() - 1.5).abs() < 1e-6, "{rate} Hz: {}", row.approach_speed());
        assert!(found.confidence[&row.impact_id] > 0.999);
    }
}

#[test]
fn analytic_what_rests_rolls_or_flies_has_no_impact() {
    let ball = Body::sphere("ball", presets::STEEL.material(), 0.01);
    let rest = |_: f64| Pose::at(DVec3::Y * 0.01);
    let roll = |t: f64| Pose {
        position: DVec3::new(0.3 * t, 0.01, 0.0),
        orientation: DQuat::from_rotation_z(-30.0 * t),
    };
    let fly =
        |t: f64| Flight { from: 0.0, pose: Pose::at(DVec3::Y), velocity: DVec3::Y, spin: DVec3::X }.at(t);
    for rate in RATES {
        for recorded in [sampled(0, rate, 0.4, rest), sampled(0, rate, 0.4, roll), sampled(0, rate, 0.4, fly)]
        {
            let found = find_impacts(&world(vec![ball.clone(), floor()]), &[recorded], 0.05);
            assert_eq!(heard(&found), [], "{rate} Hz");
        }
    }
}

/// A jump in the air has no partner: it is counted, and makes no sound.
#[test]
fn analytic_a_jump_that_touches_nothing_is_told() {
    let ball = Body::sphere("ball", presets::STEEL.material(), 0.01);
    let flight =
        |velocity| Flight { from: 0.205, pose: Pose::at(DVec3::Y * 3.0), velocity, spin: DVec3::ZERO };
    let path = |t: f64| flight(if t > 0.205 { DVec3::X } else { DVec3::ZERO }).at(t);
    let found = find_impacts(&world(vec![ball, floor()]), &[sampled(0, 120.0, 0.4, path)], 0.05);
    assert_eq!(heard(&found), []);
    assert_eq!(found.untouched.len(), 1);
    assert_eq!(found.untouched[0].0, BodyId(0));
}

/// After its last frame a body rests where that left it, as in a timeline.
#[test]
fn analytic_a_body_rests_after_its_last_frame() {
    let ball = |name: &str| Body::sphere(name, presets::STEEL.material(), 0.01);
    let (a, b) = (ball("a"), ball("b"));
    let world = world(vec![a, b]);
    // One flies to x = 0.2 m and is recorded no more; the other comes along z and bounces there.
    let flight = |from, place, velocity| Flight { from, pose: Pose::at(place), velocity, spin: DVec3::ZERO };
    let (instant, end) = (0.4011, DVec3::new(0.2, 3.0, 0.0));
    let first = |t: f64| flight(0.2, end, DVec3::X).at(t);
    let second = |t: f64| {
        let speed = if t < instant { -2.0 } else { 1.0 };
        flight(instant, end + DVec3::Z * 0.02, DVec3::Z * speed).at(t)
    };
    for rate in RATES.into_iter().filter(|rate| *rate > 100.0) {
        let recorded = [sampled(0, rate, 0.2, first), sampled(1, rate, 0.6, second)];
        let found = find_impacts(&world, &recorded, 0.05);
        let rows = heard(&found);
        assert_eq!((rows.len(), found.untouched.len()), (1, 0), "{rate} Hz: {rows:?}");
        // Seen: 2e-15.
        assert!((rows[0].approach_speed() - 2.0).abs() < 1e-9, "{rate} Hz: {}", rows[0].approach_speed());
    }
}
