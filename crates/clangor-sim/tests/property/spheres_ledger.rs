//! Momentum and angular momentum of every ball, every step: m Δv − m g Δt − Σ logged impulses.

use crate::sphere_worlds::{G, material, plane, run, settings, sphere, world};
use clangor_core::body::{BodyId, Link, LinkEnd, Motion, Surface, World};
use clangor_core::timeline::{ContactKind, PoseRow, Timeline};
use glam::{DMat3, DVec3};

/// A power of two, so that steps and poses have the same times to the last bit.
const STEP: f64 = 1.0 / 1024.0;

fn radius(world: &World, body: BodyId) -> f64 {
    match *world.bodies[body.index()].surface {
        Surface::Sphere { radius } => radius,
        _ => f64::INFINITY,
    }
}

/// Largest residual of the momentum and of the angular momentum, relative to the step's impulses.
fn worst(world: &World, timeline: &Timeline) -> (f64, f64) {
    let sampled = |body: BodyId| -> Vec<PoseRow> {
        let on_step = |p: &&PoseRow| p.body == body && (p.time / STEP).fract() == 0.0;
        timeline.poses.iter().filter(on_step).copied().collect()
    };
    let (mut linear, mut angular) = (0.0_f64, 0.0_f64);
    for (index, body) in world.bodies.iter().enumerate().filter(|(_, b)| b.motion == Motion::Free) {
        let id = BodyId(index as u32);
        let poses = sampled(id);
        assert!(poses.len() > 100);
        let own = radius(world, id);
        for pair in poses.windows(2) {
            let (from, to) = (&pair[0], &pair[1]);
            let (mut sum, mut torque, mut size) = (DVec3::ZERO, DVec3::ZERO, 0.0);
            let acting = timeline.contacts.iter().filter(|r| r.time > from.time && r.time <= to.time);
            for row in acting.filter(|r| r.body_a == id || r.body_b == id) {
                let sign = if row.body_a == id { 1.0 } else { -1.0 };
                let impulse = row.impulse() * sign;
                let arm = match row.kind {
                    ContactKind::Constraint => DVec3::ZERO,
                    _ => row.normal * (-sign * own),
                };
                sum += impulse;
                torque += arm.cross(impulse) + row.couple * sign;
                size += impulse.length();
            }
            let weight = world.gravity * (body.mass * STEP);
            let change = (to.velocity - from.velocity) * body.mass;
            let spin = (to.angular_velocity - from.angular_velocity) * body.inertia.x_axis.x;
            let size = size + weight.length() + 1e-6 * body.mass;
            let residual = (change - weight - sum).length() / size;
            if residual > linear {
                linear = residual;
            }
            angular = angular.max((spin - torque).length() / (size * own));
        }
    }
    (linear, angular)
}

fn check(name: &str, world: &World, duration: f64) {
    let mut settings = settings(duration, true, 1.0 / STEP);
    settings.time_step = STEP;
    let (timeline, _) = run(world, &settings).unwrap();
    let (linear, angular) = worst(world, &timeline);
    println!("{name}: momentum {linear:.1e}, angular momentum {angular:.1e}");
    // Residuals seen: 2e-12 in the groove, 2e-14 elsewhere.
    assert!(linear < 1e-10 && angular < 1e-10, "{name}: {linear:e} {angular:e}");
}

#[test]
fn thrown_balls_balance() {
    let steel = material(0.6, 0.4, 2e-4);
    let mut bodies: Vec<_> = (0..12)
        .map(|k| {
            let k = f64::from(k);
            let at = DVec3::new(0.03 * (k % 3.0), 0.05 + 0.03 * (k / 3.0).floor(), 0.001 * k);
            sphere(0.008 + 0.0005 * k, at, DVec3::new(0.3 - 0.05 * k, 0.2, 0.04 * k), &steel)
        })
        .collect();
    bodies.push(plane(DVec3::ZERO, DVec3::Y, &steel));
    for (point, normal) in [(-0.05, DVec3::X), (0.15, DVec3::NEG_X)] {
        bodies.push(plane(DVec3::X * point, normal, &steel));
    }
    check("thrown", &world(bodies, vec![], G), 2.0);
}

#[test]
fn sliding_rolling_and_spinning_balance() {
    let rubber = material(0.3, 0.35, 4e-4);
    let mut ball = sphere(0.02, DVec3::Y * 0.02, DVec3::new(0.5, 0.0, 0.1), &rubber);
    ball.angular_velocity = DVec3::new(4.0, 20.0, 30.0);
    let floor = plane(DVec3::ZERO, DVec3::Y, &rubber);
    let tilted = plane(DVec3::ZERO, DVec3::new(0.1, 1.0, 0.05), &rubber);
    check("flat", &world(vec![ball.clone(), floor], vec![], G), 2.0);
    ball.pose.position = DVec3::new(0.1, 1.0, 0.05).normalize() * 0.02;
    check("slope", &world(vec![ball, tilted], vec![], G), 2.0);
}

#[test]
fn a_groove_balances() {
    let rubber = material(0.3, 0.35, 4e-4);
    let mut ball = sphere(0.02, DVec3::Y * 0.06, DVec3::new(0.0, 0.0, 0.4), &rubber);
    ball.angular_velocity = DVec3::new(4.0, 20.0, 30.0);
    let sides = [DVec3::new(0.5, 1.0, 0.0), DVec3::new(-0.7, 1.0, 0.1)];
    let planes = sides.map(|n| plane(DVec3::ZERO, n, &rubber));
    check("groove", &world(vec![ball].into_iter().chain(planes).collect(), vec![], G), 2.0);
}

#[test]
fn rods_and_springs_balance() {
    let steel = material(0.7, 0.3, 0.0);
    let mut bodies = Vec::new();
    for k in 0..4 {
        bodies.push(sphere(0.01, DVec3::new(0.021 * f64::from(k), -0.3, 0.002), DVec3::ZERO, &steel));
    }
    bodies[0].pose.position = DVec3::new(-0.15, -0.2, 0.05);
    bodies[0].velocity = DVec3::new(0.0, 0.0, 0.2);
    bodies[3].inertia = DMat3::from_diagonal(DVec3::splat(bodies[3].inertia.x_axis.x));
    let anchor = |k: f64| DVec3::new(0.021 * k, 0.0, 0.0);
    let links = vec![
        Link::Hang { body: BodyId(0), anchor: anchor(0.0) },
        Link::Hang { body: BodyId(1), anchor: anchor(1.0) + DVec3::Z * 0.1 },
        Link::Hang { body: BodyId(1), anchor: anchor(1.0) - DVec3::Z * 0.1 },
        Link::Spring {
            body: BodyId(2),
            at: DVec3::ZERO,
            to: LinkEnd::Point(anchor(2.0)),
            rest_length: 0.25,
            stiffness: 20.0,
            damping: 0.05,
        },
        Link::Spring {
            body: BodyId(2),
            at: DVec3::ZERO,
            to: LinkEnd::centre(BodyId(3)),
            rest_length: 0.03,
            stiffness: 30.0,
            damping: 0.02,
        },
    ];
    check("links", &world(bodies, links, G), 1.5);
}
