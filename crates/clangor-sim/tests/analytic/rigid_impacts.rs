//! Impacts of the time-stepped solver against closed forms: bounces, Newton's cradle, the break of three
//! balls.

use clangor_core::body::{Body, BodyId, World};
use clangor_core::glam::DVec3;
use clangor_core::timeline::ContactKind;
use clangor_sim::rigid::{RigidWorld, StepLog};

use crate::scenes::{ball, floor, material, world};

const RADIUS: f64 = 7.5e-3;

fn weightless(bodies: Vec<Body>) -> World {
    World { gravity: DVec3::ZERO, ..world(bodies) }
}

fn run(world: &World, time_step: f64, duration: f64) -> RigidWorld {
    let mut rigid = RigidWorld::try_new(world, time_step, false).unwrap();
    let mut log = StepLog::new();
    for _ in 0..(duration / time_step).round() as usize {
        rigid.step(&mut log).unwrap();
    }
    rigid
}

/// A ball that falls 1 m bounces at known times with known impulses, whatever the step.
#[test]
fn a_bouncing_ball_keeps_time_and_impulse() {
    let (mut late, mut strength, mut ratio) = (0.0_f64, 0.0_f64, 0.0_f64);
    for restitution in [0.7, 1.0] {
        for time_step in [1e-5, 1e-4, 2.5e-4] {
            let material = material(7850.0, restitution, 0.0, 0.0);
            let mut falling = ball(&material, RADIUS);
            falling.pose.position = DVec3::new(0.0, 1.0 + RADIUS, 0.0);
            let mass = falling.mass;
            let mut rigid =
                RigidWorld::try_new(&world(vec![floor(&material), falling]), time_step, false).unwrap();
            let gravity = 9.81_f64;
            let (mut speed, mut time) = ((2.0 * gravity).sqrt(), (2.0 / gravity).sqrt());
            let mut log = StepLog::new();
            let mut bounces = 0;
            while bounces < 6 {
                rigid.step(&mut log).unwrap();
                for impulse in log.impulses().iter().filter(|i| i.row.kind == ContactKind::Impact) {
                    let row = &impulse.row;
                    let expected = (1.0 + restitution) * mass * speed;
                    late = late.max((row.time - time).abs());
                    strength = strength.max((row.impulse_n / expected - 1.0).abs());
                    ratio = ratio.max((row.approach_speed() / speed - 1.0).abs());
                    speed *= restitution;
                    time += 2.0 * speed / gravity;
                    bounces += 1;
                }
            }
        }
    }
    println!("ball: time {late:.1e} s, impulse {strength:.1e}, speed {ratio:.1e}");
    // Residuals seen: 1.4e-12 s, 4.3e-13, 4.3e-13.
    assert!(late < 1e-9 && strength < 1e-9 && ratio < 1e-9);
}

/// `count` balls come in from the left on a row of five; as many leave on the right.
fn cradle(gap: f64, count: usize, time_step: f64) {
    let material = material(7850.0, 1.0, 0.0, 0.0);
    let mut x = 0.0;
    let balls = (0..5)
        .map(|i| {
            let mut b = ball(&material, RADIUS);
            b.name = format!("{i}");
            // The incoming balls start 2.5 mm away, apart by the same gap.
            b.pose.position = DVec3::X * (x + if i < count { -2.5e-3 } else { 0.0 });
            b.velocity = if i < count { DVec3::X } else { DVec3::ZERO };
            x += 2.0 * RADIUS + gap;
            b
        })
        .collect();
    let rigid = run(&weightless(balls), time_step, 0.05);
    let speeds: Vec<f64> = (0..5).map(|i| rigid.pose(BodyId(i)).velocity.x).collect();
    let total: f64 = speeds.iter().map(|v| v * v).sum();
    let out: f64 = speeds[5 - count..].iter().map(|v| v * v).sum();
    println!("cradle {gap:e} {count}: {:.1e}", (out / count as f64 - 1.0).abs());
    // Residuals seen: 0.
    assert!((out / count as f64 - 1.0).abs() < 1e-9, "gap {gap:e}, {count} in: {speeds:?}");
    assert!((total / count as f64 - 1.0).abs() < 1e-9, "gap {gap:e}, {count} in: {speeds:?}");
    for v in &speeds[5 - count..] {
        assert!((v - 1.0).abs() < 1e-9, "gap {gap:e}, {count} in: {speeds:?}");
    }
}

#[test]
fn the_last_ball_of_a_cradle_takes_all_energy() {
    for time_step in [1e-4, 2.5e-4] {
        for gap in [0.0, 1e-9, 1e-5, 1e-4] {
            cradle(gap, 1, time_step);
        }
    }
}

#[test]
fn two_balls_in_send_two_out() {
    for time_step in [1e-4, 2.5e-4] {
        for gap in [0.0, 1e-9, 1e-5, 1e-4] {
            cradle(gap, 2, time_step);
        }
    }
}

/// One ball onto two that touch: v (−1/5; 3/5, ±√12/10).
#[test]
fn a_ball_on_two_breaks_symmetrically() {
    let material = material(7850.0, 1.0, 0.0, 0.0);
    for time_step in [1e-4, 2.5e-4] {
        let height = 2.0 * RADIUS * 0.75_f64.sqrt();
        let mut balls = vec![ball(&material, RADIUS)];
        balls[0].pose.position = DVec3::new(-height - 7e-3, 0.0, 0.0);
        balls[0].velocity = DVec3::X;
        for side in [-1.0, 1.0] {
            let mut b = ball(&material, RADIUS);
            b.pose.position = DVec3::new(0.0, 0.0, side * RADIUS);
            balls.push(b);
        }
        let rigid = run(&weightless(balls), time_step, 0.03);
        let v: Vec<DVec3> = (0..3).map(|i| rigid.pose(BodyId(i)).velocity).collect();
        let sideways = 0.12_f64.sqrt();
        let expected =
            [DVec3::new(-0.2, 0.0, 0.0), DVec3::new(0.6, 0.0, -sideways), DVec3::new(0.6, 0.0, sideways)];
        for (v, e) in v.iter().zip(expected) {
            println!("break: {:.1e}", (*v - e).length());
            // Residual seen: 4.9e-12.
            assert!((*v - e).length() < 1e-9, "{time_step}: {v} against {e}");
        }
    }
}
