//! Joints, rods, ropes, springs off the centre, forces, and hands of the time-stepped solver, against closed
//! forms.

use std::f64::consts::{PI, TAU};

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{Body, BodyId, Guide, JointKind, Link, LinkEnd, Motion, World};
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::timeline::ContactKind;
use clangor_sim::rigid::{RigidWorld, StepLog};

use crate::scenes::{ball, cuboid, floor, material, solid, world};

const G: f64 = 9.81;
const STEP: f64 = 1e-4;

/// A bar along x.
fn bar(half: DVec3) -> Body {
    solid("bar", &material(7850.0, 0.5, 0.3, 0.0), &[cuboid(half)])
}

fn to_world(body: u32, at: DVec3, point: DVec3, kind: JointKind) -> Link {
    Link::Joint { body: BodyId(body), at, to: LinkEnd::Point(point), kind, collide: false }
}

fn to_body(body: u32, at: DVec3, (other, far): (u32, DVec3), kind: JointKind) -> Link {
    let to = LinkEnd::Body { body: BodyId(other), at: far };
    Link::Joint { body: BodyId(body), at, to, kind, collide: false }
}

fn hinge(axis: DVec3) -> JointKind {
    JointKind::Hinge { axis, damping: 0.0 }
}

/// Calls `seen` with the world after each step.
fn run(world: &World, duration: f64, seen: &mut dyn FnMut(&RigidWorld, &StepLog)) {
    let mut rigid = RigidWorld::try_new(world, STEP, true).unwrap();
    let mut log = StepLog::new();
    for _ in 0..(duration / STEP).round() as usize {
        rigid.step(&mut log).unwrap();
        seen(&rigid, &log);
    }
}

/// Times at which a coordinate grows through zero \[s\], by straight lines between steps.
fn crossings(world: &World, duration: f64, coordinate: &dyn Fn(&RigidWorld) -> f64) -> Vec<f64> {
    let (mut times, mut last) = (Vec::new(), f64::NAN);
    run(world, duration, &mut |rigid, _| {
        let now = coordinate(rigid);
        if last < 0.0 && now >= 0.0 {
            times.push(rigid.time() - STEP * now / (now - last));
        }
        last = now;
    });
    times
}

/// Mean period over whole swings \[s\].
fn period(times: &[f64]) -> f64 {
    (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64
}

/// Period of a pendulum of this amplitude over that of a small one, by the arithmetic-geometric mean.
fn swing_factor(amplitude: f64) -> f64 {
    let (mut a, mut g) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..20 {
        (a, g) = (0.5 * (a + g), f64::sqrt(a * g));
    }
    1.0 / a
}

/// A bar hung at its end by a hinge along z, turned by an angle from the vertical.
fn hung_bar(angle: f64) -> (World, f64, f64) {
    let mut hung = bar(DVec3::new(0.25, 0.01, 0.005));
    let arm = 0.25;
    let turn = DQuat::from_rotation_z(angle - 0.5 * PI);
    hung.pose = Pose { position: turn * (DVec3::X * arm), orientation: turn };
    let about_pivot = hung.inertia.col(2).z + hung.mass * arm * arm;
    let small = TAU * (about_pivot / (hung.mass * G * arm)).sqrt();
    let mut world = world(vec![hung]);
    world.links = vec![to_world(0, DVec3::NEG_X * arm, DVec3::ZERO, hinge(DVec3::Z))];
    (world, small, about_pivot)
}

#[test]
fn a_hung_bar_swings_with_the_period_of_a_compound_pendulum() {
    for amplitude in [0.05, 1.0, 2.5] {
        let (world, small, _) = hung_bar(amplitude);
        let found = period(&crossings(&world, 8.0, &|rigid| rigid.pose(BodyId(0)).position.x));
        let expected = small * swing_factor(amplitude);
        let error = found / expected - 1.0;
        println!("amplitude {amplitude}: {found:.7} s, {error:.1e}");
        // Residuals seen: 1.2e-8, 1.9e-8, 2.6e-8.
        assert!(error.abs() < 1e-6, "{amplitude}: {error:.2e}");
    }
}

#[test]
fn two_hinges_of_a_door_are_one() {
    let (mut world, small, _) = hung_bar(0.3);
    for z in [-0.2, 0.3] {
        let (at, point) = (DVec3::new(-0.25, 0.0, z), DVec3::Z * z);
        world.links.push(to_world(0, at, point, hinge(DVec3::Z)));
    }
    let found = period(&crossings(&world, 5.0, &|rigid| rigid.pose(BodyId(0)).position.x));
    let error = found / (small * swing_factor(0.3)) - 1.0;
    println!("{error:.1e}");
    // Residual seen: 1.3e-8.
    assert!(error.abs() < 1e-6, "{error:.2e}");
}

#[test]
fn a_ball_on_a_rod_or_rope_goes_round_as_a_conical_pendulum() {
    let length: f64 = 0.4;
    for kind in [JointKind::Rod { length }, JointKind::Rope { length }] {
        let tilt: f64 = 0.7;
        let rate = (G / (length * tilt.cos())).sqrt();
        let mut bob = ball(&material(7850.0, 0.5, 0.3, 0.0), 0.02);
        bob.pose.position = DVec3::new(length * tilt.sin(), -length * tilt.cos(), 0.0);
        bob.velocity = DVec3::Z * (rate * length * tilt.sin());
        let mut world = world(vec![bob]);
        world.links = vec![to_world(0, DVec3::ZERO, DVec3::ZERO, kind)];
        let height = -length * tilt.cos();
        let mut risen = 0.0_f64;
        run(&world, 3.0, &mut |rigid, _| {
            risen = risen.max((rigid.pose(BodyId(0)).position.y - height).abs());
        });
        let found = period(&crossings(&world, 5.0, &|rigid| rigid.pose(BodyId(0)).position.z));
        let error = found * rate / TAU - 1.0;
        println!("{kind:?}: {error:.1e}, height within {risen:.1e} m");
        // Residuals seen: 1.9e-8 and 5e-9 m.
        assert!(error.abs() < 1e-6 && risen < 1e-6, "{kind:?}: {error:.2e}, {risen:.2e}");
    }
}

/// A chain of three bars under hinges, ball joints and a rod. Energy of free joints oscillates by (ω Δt)² and
/// does not grow; ends stay together.
#[test]
fn a_chain_keeps_its_energy_and_its_ends_together() {
    let half = DVec3::new(0.1, 0.01, 0.006);
    let mut bodies = Vec::new();
    for k in 0..3 {
        let mut link = bar(half);
        link.name = format!("bar {k}");
        link.pose.position = DVec3::X * (0.1 + 0.2 * f64::from(k));
        bodies.push(link);
    }
    let (near, far) = (DVec3::NEG_X * 0.1, DVec3::X * 0.1);
    let mut world = world(bodies);
    world.bodies[2].angular_velocity = DVec3::new(3.0, 1.0, 0.0);
    world.links = vec![
        to_world(0, near, DVec3::ZERO, JointKind::Ball { damping: 0.0 }),
        to_body(1, near, (0, far), hinge(DVec3::Z)),
        to_body(2, near, (1, far), JointKind::Ball { damping: 0.0 }),
    ];
    let (mut drift, mut gain, mut first) = (0.0_f64, 0.0_f64, None);
    let mut scale = 0.0_f64;
    run(&world, 10.0, &mut |rigid, _| {
        let point = |body: u32, at: DVec3| {
            let row = rigid.pose(BodyId(body));
            row.position + row.orientation * at
        };
        drift = drift.max(point(0, near).length());
        drift = drift.max(point(1, near).distance(point(0, far)));
        drift = drift.max(point(2, near).distance(point(1, far)));
        let energy = rigid.energy();
        gain = gain.max(energy - *first.get_or_insert(energy));
        scale = scale.max(rigid.kinetic_energy());
    });
    println!("drift {drift:.1e} m, energy grows by {:.1e} of {scale:.3} J", gain / scale);
    // Residuals seen: 2.5e-6 m, 4e-5, both the same after 60 s.
    assert!(drift < 1e-5 && gain < 1e-4 * scale, "{drift:.2e} m, {:.2e}", gain / scale);
}

#[test]
fn a_rope_stops_a_falling_body_at_its_length_and_loses_energy() {
    let mut hung = bar(DVec3::new(0.05, 0.01, 0.01));
    hung.pose.position = DVec3::new(0.05, 0.0, 0.0);
    hung.pose.orientation = DQuat::from_rotation_y(0.4);
    let at = DVec3::NEG_X * 0.05;
    let mut world = world(vec![hung]);
    world.links = vec![to_world(0, at, DVec3::ZERO, JointKind::Rope { length: 0.3 })];
    let (mut longest, mut last, mut gain) = (0.0_f64, f64::INFINITY, 0.0_f64);
    let mut scale = 0.0_f64;
    run(&world, 5.0, &mut |rigid, _| {
        let row = rigid.pose(BodyId(0));
        longest = longest.max((row.position + row.orientation * at).length());
        let energy = rigid.energy();
        gain = gain.max(energy - last);
        last = last.min(energy);
        scale = scale.max(rigid.kinetic_energy());
    });
    println!("longest {:.2e} m over, energy grows by {:.1e}", longest - 0.3, gain / scale);
    // Residuals seen: 1.2e-8 m and 3.7e-5.
    assert!(longest < 0.3 + 1e-5 && gain < 1e-4 * scale, "{longest}, {:.2e}", gain / scale);
}

/// A ball hits a hung bar at its lower end: the reaction of the hinge takes part in the impact.
#[test]
fn an_impact_on_a_hung_bar_is_that_of_a_body_with_a_fixed_axis() {
    let (mut world, _, about_pivot) = hung_bar(0.0);
    let metal = material(7850.0, 0.5, 0.0, 0.0);
    let mut bullet = ball(&metal, 0.02);
    let (lever, speed) = (0.42, 3.0);
    bullet.pose.position = DVec3::new(-0.0301, -lever, 0.0);
    bullet.velocity = DVec3::X * speed;
    let mass = bullet.mass;
    world.bodies.push(bullet);
    world.gravity = DVec3::ZERO;
    let impulse = 1.5 * speed / (1.0 / mass + lever * lever / about_pivot);
    let mut rates = None;
    run(&world, 2e-4, &mut |rigid, log| {
        if log.impulses().iter().any(|i| i.row.kind == ContactKind::Impact) {
            let (bar, bullet) = (rigid.pose(BodyId(0)), rigid.pose(BodyId(1)));
            rates = Some((bar.angular_velocity.z, bullet.velocity.x));
        }
    });
    let (turned, left) = rates.unwrap();
    let (bar_error, ball_error) =
        (turned / (impulse * lever / about_pivot) - 1.0, left / (speed - impulse / mass) - 1.0);
    println!("{bar_error:.1e}, {ball_error:.1e}");
    // Residuals seen: 2.2e-8 and 2e-15.
    assert!(bar_error.abs() < 1e-6 && ball_error.abs() < 1e-6, "{bar_error:.2e}, {ball_error:.2e}");
}

/// A bar on a hinge falls on a post, bounces and comes to rest: m = I / r² at every point and time.
#[test]
fn the_effective_mass_of_a_hinged_bar_is_its_inertia_about_the_hinge_over_the_square_of_the_lever() {
    let (mut world, _, about_pivot) = hung_bar(0.5 * PI);
    let mut post = solid("post", &material(7850.0, 0.5, 0.3, 0.0), &[cuboid(DVec3::new(0.02, 0.05, 0.02))]);
    post.pose.position = DVec3::new(0.35, -0.0605, 0.0);
    post.motion = Motion::Fixed;
    world.bodies.push(post);
    let (mut counts, mut worst) = ([0; 2], 0.0_f64);
    run(&world, 0.3, &mut |_, log| {
        for row in log.impulses().iter().map(|impulse| impulse.row) {
            let kind = [ContactKind::Impact, ContactKind::Contact].iter().position(|kind| *kind == row.kind);
            let Some(kind) = kind else { continue };
            counts[kind] += 1;
            let lever = row.point.cross(row.normal).z;
            let error = row.effective_mass.unwrap() * lever * lever / about_pivot - 1.0;
            worst = worst.max(error.abs());
        }
    });
    println!("{} impact rows, {} contact rows, {worst:.1e}", counts[0], counts[1]);
    assert!(counts.iter().all(|count| *count > 4), "{counts:?}");
    // Residual seen: 5.5e-10, from the drift of the joint.
    assert!(worst < 1e-8, "{worst:.2e}");
}

/// A ball hits one that hangs on a taut rope, obliquely: along the rope nothing gives way, if it is pulled.
#[test]
fn a_rope_takes_part_in_the_effective_mass_only_if_it_is_pulled() {
    let metal = material(7850.0, 0.5, 0.0, 0.0);
    for (height, rope) in [(1.0, true), (-1.0, false)] {
        let [mut bob, mut bullet] = [ball(&metal, 0.02), ball(&metal, 0.01)];
        let aside = DVec3::new(1.0, height, 0.0).normalize();
        bullet.pose.position = aside * 0.0301;
        bullet.velocity = aside * -2.0;
        bob.pose.position = DVec3::ZERO;
        let alone = 1.0 / bullet.mass + 1.0 / bob.mass;
        // Across the rope, only sin² 45° of the bob's mobility is left.
        let expected = if rope { 1.0 / bullet.mass + 0.5 / bob.mass } else { alone }.recip();
        let mut world = world(vec![bob, bullet]);
        world.gravity = DVec3::ZERO;
        let length = 0.3;
        world.links = vec![to_world(0, DVec3::ZERO, DVec3::Y * length, JointKind::Rope { length })];
        let mut found = None;
        run(&world, 2e-4, &mut |_, log| {
            let impact = log.impulses().iter().find(|impulse| impulse.row.kind == ContactKind::Impact);
            found = found.or(impact.and_then(|impulse| impulse.row.effective_mass));
        });
        let error = found.unwrap() / expected - 1.0;
        println!("pulled {rope}: {error:.1e}");
        assert!(error.abs() < 1e-6, "{rope}: {error:.2e}");
    }
}

#[test]
fn a_damped_hinge_slows_exponentially() {
    let (mut world, _, about_pivot) = hung_bar(0.0);
    world.gravity = DVec3::ZERO;
    let damping = 0.05;
    world.links[0] =
        to_world(0, DVec3::NEG_X * 0.25, DVec3::ZERO, JointKind::Hinge { axis: DVec3::Z, damping });
    let hung = &mut world.bodies[0];
    hung.angular_velocity = DVec3::Z * 2.0;
    hung.velocity = hung.angular_velocity.cross(hung.pose.position);
    let mut spin = 0.0;
    run(&world, 1.0, &mut |rigid, _| spin = rigid.pose(BodyId(0)).angular_velocity.z);
    let error = spin / (2.0 * f64::exp(-damping / about_pivot)) - 1.0;
    println!("{error:.1e}");
    // Residual seen: 2.0e-4, of first order in the step.
    assert!(error.abs() < 1e-3, "{error:.2e}");
}

/// A bar on a hinge through its centre, and springs at its ends.
#[test]
fn springs_off_the_centre_turn_a_body() {
    let mut seesaw = bar(DVec3::new(0.25, 0.01, 0.01));
    let inertia = seesaw.inertia.col(2).z;
    let angle = 1e-3;
    seesaw.pose.orientation = DQuat::from_rotation_z(angle);
    let (arm, stiffness, length) = (0.2, 400.0, 1.0);
    let mut world = world(vec![seesaw]);
    world.gravity = DVec3::ZERO;
    let spring = |x: f64| Link::Spring {
        body: BodyId(0),
        at: DVec3::X * x,
        to: LinkEnd::Point(DVec3::new(x, length, 0.0)),
        rest_length: length,
        stiffness,
        damping: 0.0,
    };
    world.links = vec![to_world(0, DVec3::ZERO, DVec3::ZERO, hinge(DVec3::Z)), spring(arm), spring(-arm)];
    let expected = TAU * (inertia / (2.0 * stiffness * arm * arm)).sqrt();
    let height = |rigid: &RigidWorld| (rigid.pose(BodyId(0)).orientation * DVec3::X).y;
    let error = period(&crossings(&world, 3.0, &height)) / expected - 1.0;
    println!("{error:.1e}");
    // Residual seen: 1.6e-7.
    assert!(error.abs() < 1e-4, "{error:.2e}");
}

#[test]
fn a_force_over_time_gives_its_integral() {
    let body = bar(DVec3::new(0.1, 0.02, 0.02));
    let (mass, inertia) = (body.mass, body.inertia.col(2).z);
    let mut world = world(vec![body]);
    world.gravity = DVec3::ZERO;
    let triangle = vec![(0.01, DVec3::ZERO), (0.013, DVec3::Y * 50.0), (0.0204, DVec3::ZERO)];
    world.links = vec![Link::Load {
        body: BodyId(0),
        at: DVec3::X * 0.1,
        force: LoadCurve::try_new(triangle).unwrap(),
        torque: LoadCurve::try_new(vec![(0.0, DVec3::X * 1e-3), (0.01, DVec3::X * 1e-3)]).unwrap(),
    }];
    let mut last = None;
    run(&world, 0.05, &mut |rigid, _| last = Some((rigid.pose(BodyId(0)), rigid.momentum(BodyId(0)).1)));
    let (row, momentum) = last.unwrap();
    let impulse = 0.5 * 50.0 * 0.0104;
    println!("{:.1e}", row.velocity.y * mass / impulse - 1.0);
    // Rounding; the arm turns by 1e-3 meanwhile.
    assert!((row.velocity.y * mass / impulse - 1.0).abs() < 1e-12);
    assert!((row.angular_velocity.z * inertia / (impulse * 0.1) - 1.0).abs() < 0.01);
    assert!((momentum.x - 1e-5).abs() < 1e-6);
}

fn track(keys: &[(f64, DVec3)]) -> Track {
    let key = |(time, position): &(f64, DVec3)| Keyframe { time: *time, pose: Pose::at(*position) };
    Track::try_new(keys.iter().map(key).collect()).unwrap()
}

/// A body that is led 2 cm into the floor presses on it with the force of the hand, beyond its weight.
#[test]
fn a_hand_presses_with_its_force() {
    let metal = material(7850.0, 0.2, 0.3, 0.0);
    let mut block = solid("block", &metal, &[cuboid(DVec3::splat(0.02))]);
    let keys = [(0.0, DVec3::Y * 0.05), (0.3, DVec3::Y * 0.0), (0.31, DVec3::Y * 0.0)];
    let guide = Guide { track: track(&keys), press: Some(12.0), let_go: None };
    block.motion = Motion::Guided(guide);
    block.pose.position = DVec3::Y * 0.05;
    let mut sum = 0.0;
    let mut heights = [0.0; 2];
    let world = world(vec![block, floor(&metal)]);
    run(&world, 1.0, &mut |rigid, log| {
        let height = rigid.pose(BodyId(0)).position.y;
        if rigid.time() < 0.1 {
            let led = keys[0].1.y - height;
            heights[0] = f64::max(heights[0], led);
        }
        heights[1] = height;
        if rigid.time() > 0.5 {
            let rows = log.impulses().iter().filter(|i| i.row.body_b == BodyId(1));
            sum += rows.map(|i| i.row.impulse().y).sum::<f64>();
        }
    });
    let force = sum / 0.5;
    println!("{force:.4} N at {:.2e} m", heights[1] - 0.02);
    // Residual seen: below 1e-4 N.
    assert!((force - 12.0).abs() < 0.05, "{force} N");
    assert!(heights[0] > 1e-3 && (heights[1] - 0.02).abs() < 1e-4);
}

#[test]
fn a_hand_lets_go_with_the_velocity_of_its_track() {
    for press in [None, Some(200.0)] {
        let mut thrown = ball(&material(7850.0, 0.5, 0.3, 0.0), 0.02);
        let start = DVec3::Y * 1.0;
        let at = |time: f64| start + DVec3::new(2.0 * time, time, 0.0);
        let keys: Vec<(f64, DVec3)> =
            (0..=10).map(|k| (0.05 * f64::from(k), at(0.05 * f64::from(k)))).collect();
        let let_go = 0.2;
        thrown.motion = Motion::Guided(Guide { track: track(&keys), press, let_go: Some(let_go) });
        thrown.pose.position = start;
        let mut row = None;
        run(&world(vec![thrown]), 0.5, &mut |rigid, _| row = Some(rigid.pose(BodyId(0))));
        let free = 0.3;
        let expected = at(let_go) + DVec3::new(2.0, 1.0, 0.0) * free + DVec3::NEG_Y * (0.5 * G * free * free);
        let error = (row.unwrap().position - expected).length();
        println!("{press:?}: {error:.1e} m");
        // Residuals seen: 7e-14 and 7e-13 m.
        assert!(error < 1e-3, "{press:?}: {error:.2e}");
    }
}
