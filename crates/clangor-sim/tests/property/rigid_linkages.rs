//! Linkages, ropes and hands together with contacts: what lies on them does not sink, what is pressed stays
//! down, pinned bodies are not free in impacts, and what cannot be is refused.

use clangor_core::body::{Body, BodyId, Guide, JointKind, Link, LinkEnd, Motion, World};
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_sim::SimulationError;
use clangor_sim::rigid::{RigidWorld, StepLog};

use crate::scenes::{ball, cuboid, floor, material, solid, world};

const STEP: f64 = 2.5e-4;

fn block(half: DVec3, at: DVec3) -> Body {
    let mut block = solid("block", &material(7850.0, 0.3, 0.4, 0.0), &[cuboid(half)]);
    block.pose.position = at;
    block
}

fn rope(body: u32, at: DVec3, to: DVec3, length: f64) -> Link {
    let to = LinkEnd::Point(to);
    Link::Joint { body: BodyId(body), at, to, kind: JointKind::Rope { length }, collide: true }
}

fn led(body: Body, keys: &[(f64, Pose)], press: Option<f64>, let_go: Option<f64>) -> Body {
    let keys = keys.iter().map(|(time, pose)| Keyframe { time: *time, pose: *pose }).collect();
    let guide = Guide { track: Track::try_new(keys).unwrap(), press, let_go };
    Body { motion: Motion::Guided(guide), ..body }
}

/// Runs a world and calls `seen` after each step.
fn run(
    world: &World,
    duration: f64,
    seen: &mut dyn FnMut(&RigidWorld, &StepLog),
) -> Result<(), SimulationError> {
    let mut rigid = RigidWorld::try_new(world, STEP, true)?;
    let mut log = StepLog::new();
    for _ in 0..(duration / STEP).round() as usize {
        rigid.step(&mut log)?;
        seen(&rigid, &log);
    }
    Ok(())
}

#[test]
fn what_lies_on_a_tray_on_ropes_does_not_sink() {
    let tray = block(DVec3::new(0.2, 0.01, 0.2), DVec3::Y * 0.5);
    let cube = block(DVec3::splat(0.05), DVec3::new(0.02, 0.56, 0.0));
    let mut world = world(vec![tray, cube]);
    for corner in [(-0.2, -0.2), (-0.2, 0.2), (0.2, -0.2), (0.2, 0.2)] {
        let at = DVec3::new(corner.0, 0.0, corner.1);
        world.links.push(rope(0, at, at + DVec3::Y * 1.0, 0.5));
    }
    let mut deepest = 0.0_f64;
    run(&world, 2.0, &mut |rigid, _| deepest = deepest.max(rigid.deepest_overlap())).unwrap();
    println!("{:.2} µm", 1e6 * deepest);
    // Residual seen: 10 µm, the overlap that is tolerated.
    assert!(deepest < 2e-5, "{deepest:.2e} m");
}

#[test]
fn a_blocked_body_stays_down_whatever_its_track_does() {
    let low = Pose { position: DVec3::ZERO, orientation: DQuat::from_rotation_y(1.0) };
    for (press, stop) in [(12.0, 0.02), (5.0, 0.1), (1000.0, 0.1)] {
        let start = Pose::at(DVec3::Y * 0.05);
        let body =
            led(block(DVec3::splat(0.02), start.position), &[(0.0, start), (stop, low)], Some(press), None);
        let metal = material(7850.0, 0.3, 0.4, 0.0);
        let (mut highest, mut lowest, mut speed) = (0.0_f64, f64::INFINITY, 0.0_f64);
        run(&world(vec![body, floor(&metal)]), 0.6, &mut |rigid, _| {
            let row = rigid.pose(BodyId(0));
            lowest = lowest.min(row.position.y);
            if rigid.time() > stop {
                highest = highest.max(row.position.y);
            }
            speed = row.velocity.length() + 0.02 * row.angular_velocity.length();
        })
        .unwrap();
        println!(
            "{press} N: {:.2} mm up, {:.1} µm down, {speed:.1e} m/s",
            1e3 * (highest - 0.02),
            1e6 * (0.02 - lowest)
        );
        // Residuals seen: 25, 0.2 and 0 mm up, 1.3, 0.6 and 17 µm down. A bounce is as high as restitution
        // lets it be, against the hand.
        assert!(highest < 0.05 && lowest > 0.0199 && speed < 1e-2, "{press} N: {highest} {lowest} {speed}");
    }
}

/// A damper acts on the whole linkage, not on the spin of a small body alone.
#[test]
fn a_strongly_damped_pendulum_creeps() {
    let (length, damping) = (1.0, 0.5);
    let mut bob = ball(&material(7850.0, 0.5, 0.3, 0.0), 0.01);
    bob.pose.position = DVec3::X * length;
    let (mass, inertia) = (bob.mass, bob.inertia.col(0).x + bob.mass * length * length);
    let mut world = world(vec![bob]);
    let kind = JointKind::Hinge { axis: DVec3::Z, damping };
    let (at, to) = (DVec3::NEG_X * length, LinkEnd::Point(DVec3::ZERO));
    world.links = vec![Link::Joint { body: BodyId(0), at, to, kind, collide: true }];
    let mut angle = 0.0;
    run(&world, 2.0, &mut |rigid, _| {
        let at = rigid.pose(BodyId(0)).position;
        angle = at.y.atan2(at.x);
    })
    .unwrap();
    // I ω' = −m g L cos θ − c ω, by small steps of the exact equation.
    let (mut theta, mut omega, step) = (0.0_f64, 0.0_f64, 1e-6);
    for _ in 0..2_000_000 {
        omega += step * (-mass * 9.81 * length * theta.cos() - damping * omega) / inertia;
        theta += step * omega;
    }
    println!("{angle:.5} of {theta:.5} rad");
    assert!((angle - theta).abs() < 2e-3 * theta.abs(), "{angle} of {theta}");
}

#[test]
fn a_pinned_ball_at_the_end_of_a_row_throws_the_first_back() {
    let metal = material(7850.0, 1.0, 0.0, 0.0);
    let mut row: Vec<Body> = (0..3).map(|_| ball(&metal, 0.02)).collect();
    for (body, x) in row.iter_mut().zip([-0.06, 0.0, 0.04]) {
        body.pose.position = DVec3::X * x;
    }
    row[0].velocity = DVec3::X;
    let mut world = world(row);
    world.gravity = DVec3::ZERO;
    let kind = JointKind::Ball { damping: 0.0 };
    let to = LinkEnd::Point(DVec3::X * 0.04);
    world.links = vec![Link::Joint { body: BodyId(2), at: DVec3::ZERO, to, kind, collide: true }];
    let mut speeds = [0.0; 3];
    run(&world, 0.1, &mut |rigid, _| {
        speeds = [0, 1, 2].map(|body| rigid.pose(BodyId(body)).velocity.x);
    })
    .unwrap();
    let energy: f64 = speeds.iter().map(|v| v * v).sum();
    println!("{speeds:?}");
    assert!((energy - 1.0).abs() < 1e-9 && speeds[0] < -0.1 && speeds[2].abs() < 1e-12, "{speeds:?}");
}

#[test]
fn a_body_that_is_not_let_go_yet_moves_as_by_keyframes() {
    let glass = material(2500.0, 0.9, 0.2, 0.0);
    let keys =
        [(0.0, Pose::at(DVec3::Y * 0.3)), (0.2, Pose::at(DVec3::Y * 0.0)), (0.4, Pose::at(DVec3::Y * 0.3))];
    let struck = |let_go: Option<f64>| {
        let mut target = block(DVec3::new(0.05, 0.01, 0.05), DVec3::new(0.02, 0.15, 0.0));
        target.velocity = DVec3::Y;
        let hammer = led(ball(&glass, 0.02), &keys, None, let_go);
        let mut end = None;
        run(&world(vec![hammer, target]), 0.3, &mut |rigid, _| end = Some(rigid.pose(BodyId(1)))).unwrap();
        end.unwrap()
    };
    assert_eq!(struck(None), struck(Some(10.0)));
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    // Keyframes pull a joint apart.
    let mut held = ball(&material(7850.0, 0.5, 0.3, 0.0), 0.02);
    held.name = "held".into();
    let away = led(
        ball(&material(7850.0, 0.5, 0.3, 0.0), 0.02),
        &[(0.0, Pose::at(DVec3::X)), (1.0, Pose::at(DVec3::X * 3.0))],
        None,
        None,
    );
    let mut torn = world(vec![held, away]);
    let joint = |to, kind| Link::Joint { body: BodyId(0), at: DVec3::ZERO, to, kind, collide: true };
    torn.links = vec![
        joint(LinkEnd::Point(DVec3::ZERO), JointKind::Ball { damping: 0.0 }),
        joint(LinkEnd::centre(BodyId(1)), JointKind::Rod { length: 1.0 }),
    ];
    let refused = run(&torn, 1.0, &mut |_, _| {});
    assert!(
        matches!(&refused, Err(SimulationError::LooseJoint { body, .. }) if body == "held"),
        "{refused:?}"
    );
    // A force that moves the body through the floor in a step.
    let start = Pose::at(DVec3::Y * 0.05);
    let slammed = led(block(DVec3::splat(0.02), start.position), &[(0.0, start)], Some(1e4), None);
    let refused = run(&world(vec![slammed]), 1.0, &mut |_, _| {});
    let Err(SimulationError::PushedTooFar(push)) = refused else { panic!("{refused:?}") };
    assert_eq!((push.what, push.size), ("hand", 1e4));
    // Let go inside the floor.
    let metal = material(7850.0, 0.3, 0.4, 0.0);
    let deep = led(block(DVec3::splat(0.02), DVec3::ZERO), &[(0.0, Pose::at(DVec3::ZERO))], None, Some(0.1));
    let refused = run(&world(vec![deep, floor(&metal)]), 1.0, &mut |_, _| {});
    let Err(SimulationError::StartOverlap { depth, time, .. }) = refused else { panic!("{refused:?}") };
    assert!((depth - 0.02).abs() < 1e-6 && (time - 0.1).abs() < STEP, "{depth} m, {time} s");
}

/// Twenty ropes in a row, and a bob of a thousand times the mass of a link.
#[test]
fn a_heavy_bob_on_a_chain_of_ropes_hangs() {
    let metal = material(7850.0, 0.5, 0.3, 0.0);
    let mut bodies: Vec<Body> = (0..8).map(|_| ball(&metal, 0.005)).collect();
    bodies.push(ball(&metal, 0.03));
    for (k, body) in bodies.iter_mut().enumerate() {
        body.pose.position = DVec3::X * (0.05 * (k + 1) as f64);
    }
    let count = bodies.len();
    let mut world = world(bodies);
    world.links = (0..count as u32)
        .map(|k| Link::Joint {
            body: BodyId(k),
            at: DVec3::ZERO,
            to: if k == 0 { LinkEnd::Point(DVec3::ZERO) } else { LinkEnd::centre(BodyId(k - 1)) },
            kind: JointKind::Rope { length: 0.05 },
            collide: false,
        })
        .collect();
    let mut longest = 0.0_f64;
    run(&world, 1.5, &mut |rigid, _| {
        let mut last = DVec3::ZERO;
        for k in 0..count as u32 {
            let at = rigid.pose(BodyId(k)).position;
            longest = longest.max(at.distance(last) - 0.05);
            last = at;
        }
    })
    .unwrap();
    println!("longest {:.2} µm", 1e6 * longest);
    assert!(longest < 1e-5, "{longest:.2e} m");
}
