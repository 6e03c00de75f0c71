//! Hung balls and springs of the event-driven solver against closed forms.

use std::f64::consts::PI;

use crate::sphere_worlds::{
    G, kinetic_energy, last_poses, material, plane, rows_of, run, settings, sphere, world,
};
use clangor_core::body::{BodyId, Link, LinkEnd, Motion};
use clangor_core::timeline::PoseRow;
use glam::DVec3;

/// cn(u)/dn(u) of modulus k, by descending Landen transformation (arithmetic-geometric mean).
fn jacobi_cd(u: f64, k: f64) -> f64 {
    let (mut a, mut b, mut c) = (vec![1.0], (1.0 - k * k).sqrt(), vec![k]);
    // Quadratic convergence: far below rounding after seven steps.
    for _ in 0..7 {
        let last = *a.last().unwrap();
        c.push(0.5 * (last - b));
        a.push(0.5 * (last + b));
        b = (last * b).sqrt();
    }
    let n = a.len() - 1;
    let mut phi = f64::powi(2.0, n as i32) * a[n] * u;
    let mut above = phi;
    for j in (1..=n).rev() {
        above = phi;
        phi = 0.5 * (phi + (c[j] / a[j] * phi.sin()).clamp(-1.0, 1.0).asin());
    }
    // dn = cos φ₀ / cos(φ₁ − φ₀), so cn/dn = cos(φ₁ − φ₀).
    (above - phi).cos()
}

/// Angle of a plane pendulum of length `l` released at rest from `start`.
fn pendulum_angle(time: f64, l: f64, start: f64) -> f64 {
    let k = (0.5 * start).sin();
    2.0 * (k * jacobi_cd((G / l).sqrt() * time, k)).asin()
}

fn hung_at(angle: f64, l: f64) -> DVec3 {
    DVec3::new(angle.sin(), -angle.cos(), 0.0) * l
}

fn hang(body: u32, anchor: DVec3) -> Link {
    Link::Hang { body: BodyId(body), anchor }
}

#[test]
fn a_pendulum_follows_the_elliptic_functions() {
    // The period by the arithmetic-geometric mean checks the reference itself.
    let (l, start) = (0.7, 2.5_f64);
    let (mut a, mut b) = (1.0, (0.5 * start).cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    let period = 2.0 * PI * (l / G).sqrt() / a;
    assert!((pendulum_angle(period, l, start) - start).abs() < 1e-7);
    assert!((pendulum_angle(0.5 * period, l, start) + start).abs() < 1e-7);

    let steel = material(0.5, 0.3, 0.0);
    for start in [0.05, 1.0, 2.5] {
        let ball = sphere(0.01, hung_at(start, l), DVec3::ZERO, &steel);
        let world = world(vec![ball], vec![hang(0, DVec3::ZERO)], G);
        let (timeline, _) = run(&world, &settings(5.0, false, 50.0)).unwrap();
        let error = timeline
            .poses
            .iter()
            .map(|p| (p.position - hung_at(pendulum_angle(p.time, l, start), l)).length() / l)
            .fold(0.0, f64::max);
        // Residuals seen: 5e-16, 4e-15 and 4e-14.
        println!("pendulum from {start} rad: {error:.1e}");
        assert!(error < 1e-12, "{start}: {error:e}");
    }
}

#[test]
fn a_conical_pendulum_circles() {
    let (l, angle) = (0.5, 0.6_f64);
    let rate = (G / (l * angle.cos())).sqrt();
    let steel = material(0.5, 0.3, 0.0);
    let speed = rate * l * angle.sin();
    let ball = sphere(0.01, hung_at(angle, l), DVec3::Z * speed, &steel);
    let world = world(vec![ball], vec![hang(0, DVec3::ZERO)], G);
    let (timeline, _) = run(&world, &settings(5.0, false, 20.0)).unwrap();
    for p in &timeline.poses {
        let (sin, cos) = (rate * p.time).sin_cos();
        let wanted = DVec3::new(angle.sin() * cos, -angle.cos(), angle.sin() * sin) * l;
        // Residual seen: 6e-14.
        assert!((p.position - wanted).length() < 1e-12 * l, "{:e}", (p.position - wanted).length());
    }
}

#[test]
fn two_rods_leave_a_circle() {
    // Anchors at z = ±w: the ball swings as a plane pendulum of length √(l² − w²) about the line between
    // them.
    let (l, start, half_width) = (0.4, 0.8, 0.15);
    let steel = material(0.5, 0.3, 0.0);
    let ball = sphere(0.01, hung_at(start, l), DVec3::ZERO, &steel);
    let links = vec![hang(0, DVec3::Z * half_width), hang(0, DVec3::Z * -half_width)];
    let (timeline, _) = run(&world(vec![ball], links, G), &settings(3.0, false, 20.0)).unwrap();
    for p in &timeline.poses {
        let wanted = hung_at(pendulum_angle(p.time, l, start), l);
        // Residual seen: 3e-14.
        assert!((p.position - wanted).length() < 1e-12 * l, "{:e}", (p.position - wanted).length());
    }
}

#[test]
fn a_swinging_ball_strikes_at_the_exact_time() {
    let (l, radius, start, target) = (0.6, 0.02, 1.2_f64, -0.3_f64);
    let steel = material(1.0, 0.0, 0.0);
    let ball = sphere(radius, hung_at(start, l), DVec3::ZERO, &steel);
    let mut post = sphere(radius, hung_at(target, l), DVec3::ZERO, &steel);
    post.motion = Motion::Fixed;
    let world = world(vec![ball, post], vec![hang(0, DVec3::ZERO)], G);
    let (timeline, _) = run(&world, &settings(2.0, false, 50.0)).unwrap();
    // Contact where the chord between the centres is 2r.
    let contact = target + 2.0 * (radius / l).asin();
    let (mut low, mut high) = (0.0, 0.6);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if pendulum_angle(middle, l, start) > contact { low = middle } else { high = middle }
    }
    let rows = rows_of(&timeline, 0);
    println!("strike: {:.1e} s", rows[0].time - low);
    // Residual seen: 1e-16 s.
    assert!((rows[0].time - low).abs() < 1e-12, "{} {low}", rows[0].time);
    // It swings back and hits again after the same time in each direction.
    assert!((rows[1].time - 3.0 * low).abs() < 1e-10, "{} {}", rows[1].time, 3.0 * low);
}

#[test]
fn an_off_axis_impact_is_taken_up_by_the_rod() {
    // A ball thrown along the rod's direction at 45° moves the hung one along its arc only.
    let (l, radius) = (0.5, 0.02);
    let steel = material(1.0, 0.0, 0.0);
    let direction = DVec3::new(1.0, 1.0, 0.0).normalize();
    let hung = sphere(radius, DVec3::NEG_Y * l, DVec3::ZERO, &steel);
    let thrown = sphere(radius, DVec3::NEG_Y * l - direction * 0.1, direction, &steel);
    let world = world(vec![hung, thrown], vec![hang(0, DVec3::ZERO)], 0.0);
    let (timeline, _) = run(&world, &settings(0.061, true, 1000.0)).unwrap();
    // Effective inverse mass of the hung ball along the normal: cos²45°/m, so j = 2 m v/(1 + ½).
    let row = rows_of(&timeline, 0).into_iter().find(|r| r.body_b == BodyId(1)).unwrap();
    let mass = world.bodies[0].mass;
    assert!((row.impulse_n / (mass * 4.0 / 3.0) - 1.0).abs() < 1e-12);
    let poses = last_poses(&timeline);
    assert!((poses[0].velocity.length() - 4.0 / 3.0 * 0.5_f64.sqrt()).abs() < 1e-12);
    assert!((kinetic_energy(&world, &poses) / (0.5 * mass) - 1.0).abs() < 1e-12);
}

#[test]
fn a_damped_spring_follows_the_oscillator() {
    let (stiffness, rest, damping) = (40.0, 0.3, 0.05);
    let steel = material(0.5, 0.3, 0.0);
    let ball = sphere(0.012, DVec3::new(0.0, -0.5, 0.0), DVec3::Y * 0.2, &steel);
    let mass = ball.mass;
    let link = Link::Spring {
        body: BodyId(0),
        at: DVec3::ZERO,
        to: LinkEnd::Point(DVec3::ZERO),
        rest_length: rest,
        stiffness,
        damping,
    };
    let (timeline, _) = run(&world(vec![ball], vec![link], G), &settings(5.0, false, 40.0)).unwrap();
    let balance = -rest - mass * G / stiffness;
    let gamma = 0.5 * damping / mass;
    let omega = (stiffness / mass - gamma * gamma).sqrt();
    let (x_0, v_0) = (-0.5 - balance, 0.2);
    let mut worst = 0.0_f64;
    for p in &timeline.poses {
        let (sin, cos) = (omega * p.time).sin_cos();
        let wanted = balance + (-gamma * p.time).exp() * (x_0 * cos + (v_0 + gamma * x_0) / omega * sin);
        worst = worst.max((p.position.y - wanted).abs());
    }
    println!("spring: {worst:.1e} m");
    // Residual seen: 7e-16 m.
    assert!(worst < 1e-12);
}

#[test]
fn two_balls_on_a_spring_beat_at_the_reduced_mass() {
    let (stiffness, rest) = (30.0, 0.2);
    let steel = material(0.5, 0.3, 0.0);
    let left = sphere(0.01, DVec3::ZERO, DVec3::Y, &steel);
    let right = sphere(0.02, DVec3::X * 0.25, DVec3::Y, &steel);
    let (m, n) = (left.mass, right.mass);
    let link = Link::Spring {
        body: BodyId(0),
        at: DVec3::ZERO,
        to: LinkEnd::centre(BodyId(1)),
        rest_length: rest,
        stiffness,
        damping: 0.0,
    };
    let (timeline, _) = run(&world(vec![left, right], vec![link], 0.0), &settings(3.0, false, 40.0)).unwrap();
    let omega = (stiffness * (1.0 / m + 1.0 / n)).sqrt();
    let pairs: Vec<&[PoseRow]> = timeline.poses.chunks(2).collect();
    for pair in pairs {
        let time = pair[0].time;
        let length = rest + 0.05 * (omega * time).cos();
        let centre = (pair[0].position * m + pair[1].position * n) / (m + n);
        // Residuals seen: 5e-14.
        assert!((pair[0].position.distance(pair[1].position) - length).abs() < 1e-12);
        assert!((centre - DVec3::new(0.25 * n / (m + n), time, 0.0)).length() < 1e-12);
    }
}

/// Five hung balls, the first `lifted` raised together; the speeds a quarter of a period after the impact.
fn hung_cradle(gap: f64, lifted: usize) -> Vec<f64> {
    let (l, radius, start) = (0.4, 0.01, 0.3_f64);
    let steel = material(1.0, 0.0, 0.0);
    let (mut bodies, mut links) = (Vec::new(), Vec::new());
    for k in 0..5 {
        let anchor = DVec3::new(f64::from(k) * (2.0 * radius + gap), l, 0.0);
        let angle = if (k as usize) < lifted { -start } else { 0.0 };
        bodies.push(sphere(radius, anchor + hung_at(angle, l), DVec3::ZERO, &steel));
        links.push(hang(k, anchor));
    }
    let world = world(bodies, links, G);
    // Between the strike at the bottom and the return to it.
    let mut strike = 0.0;
    while pendulum_angle(strike, l, start) > 0.0 {
        strike += 1e-4;
    }
    let (timeline, _) = run(&world, &settings(strike + 0.01, false, 1.0 / (strike + 0.01))).unwrap();
    let poses = last_poses(&timeline);
    let whole = kinetic_energy(&world, &poses);
    poses.iter().map(|p| kinetic_energy(&world, &[*p]) / whole).collect()
}

#[test]
fn a_hung_cradle_passes_the_energy_on() {
    for (gap, bar) in [(0.0, 1e-12), (1e-9, 1e-12), (1e-5, 1e-9), (1e-4, 1e-7)] {
        for lifted in [1, 2] {
            let shares = hung_cradle(gap, lifted);
            let outgoing: f64 = shares[5 - lifted..].iter().sum();
            println!("hung cradle, gap {gap:e}, {lifted} lifted: 1 - share = {:.1e}", 1.0 - outgoing);
            // Residuals seen: 0, 0, 1e-10, 1e-8. With a gap each ball has left the bottom when it hits the
            // next, and the lines of centres are no longer horizontal: the remaining motion is a physical
            // effect of second order.
            assert!(1.0 - outgoing < bar, "{gap:e} {lifted}: {shares:?}");
            let each = 1.0 / lifted as f64;
            assert!(shares[5 - lifted..].iter().all(|s| (s - each).abs() < bar.max(2e-3 * gap / 1e-4)));
        }
    }
}

#[test]
fn a_hung_ball_lies_on_a_plane_without_end() {
    // The rod is slack-free, so a plane through the bottom of the swing stops it; nothing may hang.
    let (l, radius) = (0.3, 0.01);
    let steel = material(0.6, 0.4, 0.0);
    let ball = sphere(radius, hung_at(0.5, l), DVec3::ZERO, &steel);
    let floor = plane(DVec3::new(0.0, -l * 0.3_f64.cos() - radius, 0.0), DVec3::Y, &steel);
    let (timeline, report) =
        run(&world(vec![ball, floor], vec![hang(0, DVec3::ZERO)], G), &settings(1.0, false, 10.0)).unwrap();
    assert!(report.impacts > 3);
    let end = last_poses(&timeline)[0];
    // Hovering on the plane: residual seen 1e-9 m.
    assert!(end.velocity.length() < 1e-2 && (end.position.y + l * 0.3_f64.cos()).abs() < 1e-6, "{end:?}");
}
