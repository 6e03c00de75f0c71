//! Balances of the log of the time-stepped solver: momentum in every step, energy of lossless systems, and
//! the same bits for the same input.

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{BodyId, JointKind, Link, LinkEnd, World};
use clangor_core::glam::DVec3;
use clangor_sim::rigid::{Impulse, RigidWorld, StepLog};

use crate::scenes::{
    Random, ball, cuboid, cylinder, die, floor, material, prism, ring, rock, rock_pile, solid, world,
};

/// Steps a world and returns the worst imbalance of momentum and angular momentum of any body that was awake,
/// relative to the impulses of the body in that step (times its size).
fn worst_imbalance(world: &World, time_step: f64, duration: f64) -> (f64, f64) {
    let mut rigid = RigidWorld::try_new(world, time_step, true).unwrap();
    let mut log = StepLog::new();
    let count = world.bodies.len();
    let (mut linear, mut angular) = (0.0_f64, 0.0_f64);
    for _ in 0..(duration / time_step).round() as usize {
        let id = |i: usize| BodyId(i as u32);
        let before: Vec<_> = (0..count).map(|i| (rigid.momentum(id(i)), rigid.is_asleep(id(i)))).collect();
        rigid.step(&mut log).unwrap();
        let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, 0.0); count];
        for Impulse { row, arm_a, arm_b } in log.impulses() {
            for (body, arm, sign) in [(row.body_a, arm_a, 1.0), (row.body_b, arm_b, -1.0)] {
                let Some(sum) = sums.get_mut(body.index()) else { continue };
                sum.0 += row.impulse() * sign;
                sum.1 += (arm.cross(row.impulse()) + row.couple) * sign;
                sum.2 += row.impulse().length();
            }
        }
        for i in (0..count).filter(|&i| world.bodies[i].motion == clangor_core::body::Motion::Free) {
            let slept_through = before[i].1 && rigid.is_asleep(id(i));
            if slept_through {
                continue;
            }
            let body = &world.bodies[i];
            let weight = world.gravity * (body.mass * time_step);
            let (after, (momentum, spin)) = (rigid.momentum(id(i)), before[i].0);
            let scale = sums[i].2 + weight.length();
            let size = body.surface.bounding_radius();
            linear = linear.max((after.0 - momentum - weight - sums[i].0).length() / scale);
            angular = angular.max((after.1 - spin - sums[i].1).length() / (scale * size));
        }
    }
    (linear, angular)
}

#[test]
fn a_pile_of_rocks_with_sleep_balances_momentum() {
    let material = material(2650.0, 0.4, 0.5, 5e-5);
    let (linear, angular) = worst_imbalance(&rock_pile(60, 0.06, &material, 7), 2.5e-4, 1.5);
    println!("rocks: {linear:.2e} {angular:.2e}");
    // Residuals seen: 1.7e-13 and 8e-15.
    assert!(linear < 1e-10 && angular < 1e-10, "linear {linear:.2e}, angular {angular:.2e}");
}

#[test]
fn a_mixed_heap_balances_momentum() {
    let material = material(7850.0, 0.5, 0.4, 1e-4);
    let mut random = Random(3);
    let kinds = [
        ball(&material, 0.0075),
        cylinder(&material, 0.012, 0.001),
        solid("die", &material, &[die(0.008, 0.0008)]),
        solid("prism", &material, &[prism(6, 0.010, 0.003)]),
        solid("ring", &material, &ring(0.012, 0.0025, 24, 8)),
    ];
    let mut bodies = vec![floor(&material)];
    for i in 0..20 {
        let mut body = kinds[i % kinds.len()].clone();
        body.pose.position =
            DVec3::new((i % 2) as f64 * 0.035, 0.02 + 0.035 * (i / 2) as f64, (i % 3) as f64 * 0.004);
        body.pose.orientation = random.orientation();
        body.angular_velocity = random.direction() * 10.0;
        bodies.push(body);
    }
    let (linear, angular) = worst_imbalance(&world(bodies), 2.5e-4, 1.5);
    println!("heap: {linear:.2e} {angular:.2e}");
    // Residuals seen: 1.8e-13 and 1e-14.
    assert!(linear < 1e-10 && angular < 1e-10, "linear {linear:.2e}, angular {angular:.2e}");
}

/// A mobile of bars, joints, ropes, springs and forces, with a hand and a heap of balls below.
#[test]
fn linkages_balance_momentum() {
    let material = material(7850.0, 0.5, 0.4, 1e-4);
    let mut bodies = vec![floor(&material)];
    for k in 0..4 {
        let mut bar = solid("bar", &material, &[cuboid(DVec3::new(0.1, 0.01, 0.006))]);
        bar.pose.position = DVec3::new(0.2 * f64::from(k), 0.12, 0.0);
        bar.angular_velocity = DVec3::X * f64::from(k);
        bodies.push(bar);
    }
    for k in 0..6 {
        let mut ball = ball(&material, 0.02);
        ball.pose.position = DVec3::new(0.1 * f64::from(k), 0.02 + 0.05 * f64::from(k % 2), 0.01);
        bodies.push(ball);
    }
    let end = |body: u32, x: f64| LinkEnd::Body { body: BodyId(body), at: DVec3::X * x };
    let joint = |body: u32, x: f64, to, kind| Link::Joint {
        body: BodyId(body),
        at: DVec3::X * x,
        to,
        kind,
        collide: false,
    };
    let fixed = LinkEnd::Point(DVec3::new(-0.1, 0.12, 0.0));
    let mut world = world(bodies);
    world.links = vec![
        joint(1, -0.1, fixed, JointKind::Hinge { axis: DVec3::Z, damping: 0.01 }),
        joint(2, -0.1, end(1, 0.1), JointKind::Ball { damping: 0.002 }),
        joint(3, -0.1, end(2, 0.1), JointKind::Hinge { axis: DVec3::Y, damping: 0.0 }),
        joint(4, 0.1, LinkEnd::Point(DVec3::new(0.7, 0.4, 0.0)), JointKind::Rope { length: 0.3 }),
        joint(5, 0.0, end(4, 0.0), JointKind::Rod { length: 0.61 }),
        Link::Spring {
            body: BodyId(4),
            at: DVec3::NEG_X * 0.1,
            to: end(3, 0.1),
            rest_length: 0.02,
            stiffness: 100.0,
            damping: 0.1,
        },
        Link::Load {
            body: BodyId(6),
            at: DVec3::Y * 0.01,
            force: LoadCurve::try_new(vec![(0.1, DVec3::ZERO), (0.2, DVec3::X), (0.5, DVec3::Z)]).unwrap(),
            torque: LoadCurve::default(),
        },
    ];
    let distance = world.bodies[5].pose.position.distance(world.bodies[4].pose.position);
    if let Link::Joint { kind: JointKind::Rod { length }, .. } = &mut world.links[4] {
        *length = distance;
    }
    let (linear, angular) = worst_imbalance(&world, 2.5e-4, 1.5);
    println!("linkages: {linear:.2e} {angular:.2e}");
    // Residuals seen: 7e-14 and 1e-14.
    assert!(linear < 1e-9 && angular < 1e-9, "linear {linear:.2e}, angular {angular:.2e}");
}

/// Without friction and loss a tumbling body keeps its energy through every bounce.
#[test]
fn elastic_tumbling_keeps_energy() {
    let material = material(2500.0, 1.0, 0.0, 0.0);
    let mut worst = 0.0_f64;
    for seed in 1..6 {
        let shapes = [
            solid("rock", &material, &[rock(seed, 20, 0.015)]),
            solid("prism", &material, &[prism(6, 0.012, 0.002)]),
            cylinder(&material, 0.01213, 0.000875),
        ];
        for mut body in shapes {
            let mut random = Random(seed * 101);
            body.pose.position = DVec3::Y * 0.15;
            body.pose.orientation = random.orientation();
            body.angular_velocity = random.direction() * 20.0;
            let name = body.name.clone();
            let mut rigid = RigidWorld::try_new(&world(vec![floor(&material), body]), 2.5e-4, false).unwrap();
            let mut log = StepLog::new();
            let start = rigid.energy();
            let mut impacts = 0;
            for _ in 0..8000 {
                rigid.step(&mut log).unwrap();
                impacts += log.impulses().len();
            }
            let change = (rigid.energy() / start - 1.0).abs();
            println!("{name} {seed}: {impacts} impulses, energy {change:.2e}");
            worst = worst.max(change);
        }
    }
    // Residual seen: 2.3e-9.
    assert!(worst < 1e-4, "energy changed by {worst:.2e}");
}

#[test]
fn the_same_world_gives_the_same_bits() {
    let material = material(2650.0, 0.4, 0.5, 5e-5);
    let run = || {
        let world = rock_pile(30, 0.06, &material, 11);
        let mut rigid = RigidWorld::try_new(&world, 2.5e-4, true).unwrap();
        let (mut log, mut all) = (StepLog::new(), Vec::new());
        for _ in 0..2000 {
            rigid.step(&mut log).unwrap();
            all.extend_from_slice(log.impulses());
        }
        all
    };
    let (first, second) = (run(), run());
    assert!(first.len() > 1000);
    let bits = |i: &Impulse| {
        let r = &i.row;
        [r.time, r.impulse_n, r.impulse_t.x, r.point.z, r.velocity.y, r.couple.x, r.depth].map(f64::to_bits)
    };
    assert!(first.iter().map(bits).eq(second.iter().map(bits)));
}
