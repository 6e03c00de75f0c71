//! Sliding, rolling, spinning and rest of the event-driven solver against closed forms.

use crate::sphere_worlds::{G, last_poses, material, plane, run, settings, sphere, world};
use clangor_core::body::{Body, World};
use clangor_core::timeline::PoseRow;
use glam::DVec3;

const RADIUS: f64 = 0.028575;

fn on_floor(mut ball: Body, normal: DVec3) -> World {
    let normal = normal.normalize();
    ball.pose.position = normal * RADIUS;
    let material = ball.material.clone();
    world(vec![ball, plane(DVec3::ZERO, normal, &material)], vec![], G)
}

fn end(world: &World, duration: f64) -> PoseRow {
    let (timeline, _) = run(world, &settings(duration, false, 1.0 / duration)).unwrap();
    last_poses(&timeline)[0]
}

#[test]
fn a_sliding_ball_rolls_after_two_sevenths() {
    let (friction, speed) = (0.2, 1.5);
    let cloth = material(0.5, friction, 0.0);
    let world = on_floor(sphere(RADIUS, DVec3::ZERO, DVec3::X * speed, &cloth), DVec3::Y);
    let rolls = 2.0 / 7.0 * speed / (friction * G);
    for time in [0.5 * rolls, rolls, 2.0 * rolls] {
        let pose = end(&world, time);
        let slid = time.min(rolls);
        let reached = speed - friction * G * slid;
        let x = speed * slid - 0.5 * friction * G * slid * slid + reached * (time - slid);
        // Residuals seen: 2e-16.
        assert!((pose.velocity - DVec3::X * reached).length() < 1e-14);
        assert!((pose.position.x - x).abs() < 1e-14);
        let spin = -2.5 * friction * G * slid / RADIUS;
        assert!((pose.angular_velocity - DVec3::Z * spin).length() < 1e-12);
    }
    let rolling = end(&world, 2.0 * rolls);
    assert!((rolling.velocity.x / (5.0 / 7.0 * speed) - 1.0).abs() < 1e-14);
    assert!((rolling.velocity.x + rolling.angular_velocity.z * RADIUS).abs() < 1e-15);
}

#[test]
fn a_rolling_ball_stops_where_its_losses_say() {
    let (loss, speed) = (3e-4, 1.2);
    let cloth = material(0.5, 0.2, loss);
    let mut ball = sphere(RADIUS, DVec3::ZERO, DVec3::X * speed, &cloth);
    ball.angular_velocity = DVec3::Z * (-speed / RADIUS);
    let world = on_floor(ball, DVec3::Y);
    let pull = 5.0 / 7.0 * loss * G / RADIUS;
    let pose = end(&world, 1.01 * speed / pull);
    // Residual seen: 2e-16 relative.
    assert!((pose.position.x / (0.5 * speed * speed / pull) - 1.0).abs() < 1e-13);
    assert!(pose.velocity == DVec3::ZERO && pose.angular_velocity == DVec3::ZERO);
    let before = end(&world, 0.5 * speed / pull);
    assert!((before.velocity.x / (0.5 * speed) - 1.0).abs() < 1e-13);
}

#[test]
fn a_spinning_ball_is_slowed_by_the_loss_couple() {
    let (loss, spin) = (3e-4, 40.0);
    let cloth = material(0.5, 0.2, loss);
    let mut ball = sphere(RADIUS, DVec3::ZERO, DVec3::ZERO, &cloth);
    ball.angular_velocity = DVec3::Y * spin;
    let stops = spin * 0.4 * RADIUS * RADIUS / (loss * G);
    let world = on_floor(ball, DVec3::Y);
    assert!((end(&world, 0.25 * stops).angular_velocity.y / (0.75 * spin) - 1.0).abs() < 1e-13);
    assert_eq!(end(&world, 1.01 * stops).angular_velocity, DVec3::ZERO);
}

#[test]
fn a_ball_rolls_slides_or_rests_on_a_slope() {
    let angle = 0.3_f64;
    let normal = DVec3::new(angle.sin(), angle.cos(), 0.0);
    let down = DVec3::new(angle.cos(), -angle.sin(), 0.0);
    let tangent = angle.tan();
    // It rolls for tan θ ≤ 3.5 μ and slips beyond; rolling loss holds it for tan θ ≤ ρ/r.
    for (friction, loss, acceleration) in [
        (0.5, 0.0, 5.0 / 7.0 * G * angle.sin()),
        (tangent / 3.5 * 1.001, 0.0, 5.0 / 7.0 * G * angle.sin()),
        (0.05, 0.0, G * (angle.sin() - 0.05 * angle.cos())),
        (0.0, 0.0, G * angle.sin()),
        (0.5, 0.1 * RADIUS, 5.0 / 7.0 * G * (angle.sin() - 0.1 * angle.cos())),
        (0.5, 1.01 * tangent * RADIUS, 0.0),
    ] {
        let cloth = material(0.5, friction, loss);
        let world = on_floor(sphere(RADIUS, DVec3::ZERO, DVec3::ZERO, &cloth), normal);
        let pose = end(&world, 0.8);
        let wanted = normal.normalize() * RADIUS + down * (0.5 * acceleration * 0.64);
        // Residuals seen: 2e-15.
        assert!((pose.position - wanted).length() < 1e-12, "{friction} {loss}: {}", pose.position - wanted);
    }
}

#[test]
fn a_ball_thrown_across_a_slope_follows_the_equations_of_motion() {
    let (friction, angle) = (0.25, 0.2_f64);
    let cloth = material(0.5, friction, 0.0);
    let normal = DVec3::new(angle.sin(), angle.cos(), 0.0);
    let mut ball = sphere(RADIUS, DVec3::ZERO, DVec3::Z * 0.8, &cloth);
    ball.angular_velocity = DVec3::new(5.0, 0.0, 3.0);
    // Reference: fourth-order Runge–Kutta of the slip, the velocity and the position, to the end of sliding.
    let g_n = G * angle.cos();
    let g_t = DVec3::new(angle.cos(), -angle.sin(), 0.0) * (G * angle.sin());
    let spin = ball.angular_velocity;
    let mut slip = ball.velocity - spin.cross(normal) * RADIUS;
    let (mut v, mut x, mut time, h) = (ball.velocity, normal * RADIUS, 0.0, 1e-6);
    let rate = |u: DVec3| {
        let direction = u.normalize();
        (g_t - direction * (3.5 * friction * g_n), g_t - direction * (friction * g_n))
    };
    while slip.length() > 1e-5 {
        let (k1, a1) = rate(slip);
        let (k2, a2) = rate(slip + k1 * (0.5 * h));
        let (k4, a4) = rate(slip + k2 * h);
        x += v * h + a2 * (0.5 * h * h);
        v += (a1 + a2 * 4.0 + a4) * (h / 6.0);
        slip += (k1 + k2 * 4.0 + k4) * (h / 6.0);
        time += h;
    }
    let world = on_floor(ball, normal);
    let pose = end(&world, time);
    let (off, slow) = ((pose.position - x).length(), (pose.velocity - v).length());
    println!("across a slope: {off:.1e} m, {slow:.1e} m/s after {time:.3} s");
    // Residuals seen: 6e-8 m and 3e-7 m/s: pieces of 2 % of the speed, second order.
    assert!(off < 2e-6 && slow < 2e-5, "{off:e} {slow:e}");
}

#[test]
fn a_rolling_ball_bounces_off_a_wall_and_meets_a_flying_one() {
    let cloth = material(0.8, 0.0, 0.0);
    let rolling = sphere(RADIUS, DVec3::Y * RADIUS, DVec3::X, &cloth);
    // It falls onto the first ball's path.
    let flying = sphere(RADIUS, DVec3::new(0.22, 0.3, 0.0), DVec3::ZERO, &cloth);
    let bodies = vec![
        rolling,
        flying,
        plane(DVec3::ZERO, DVec3::Y, &cloth),
        plane(DVec3::X * 2.0, DVec3::NEG_X, &cloth),
    ];
    let world = world(bodies, vec![], G);
    let (timeline, _) = run(&world, &settings(3.0, false, 100.0)).unwrap();
    // Their distance is 2r then, and never before.
    let gap = |t: f64| (0.22 - t).hypot(0.3 - RADIUS - 0.5 * G * t * t) - 2.0 * RADIUS;
    let met = timeline.contacts.iter().find(|r| r.body_a.0 == 0 && r.body_b.0 == 1).unwrap();
    // Residual seen: 1e-17 m.
    assert!(gap(met.time).abs() < 1e-14, "{:e}", gap(met.time));
    assert!((0..1000).all(|k| gap(met.time * f64::from(k) / 1000.0) > 0.0));
    let wall = timeline.contacts.iter().find(|r| r.body_b.0 == 3).unwrap();
    assert!((wall.point.x - 2.0).abs() < 1e-12);
}
