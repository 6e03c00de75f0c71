//! Degenerate worlds finish without panic, and the same world gives the same bits.

use crate::sphere_worlds::{G, kinetic_energy, last_poses, material, plane, run, settings, sphere, world};
use clangor_core::body::{Body, BodyId, Link, LinkEnd, Motion, World};
use clangor_sim::SimulationError;
use glam::DVec3;

/// Runs a world and checks that kinetic plus potential energy never grows by more than rounding and the short
/// flights in piles.
fn ends(name: &str, world: &World, duration: f64) -> f64 {
    let (timeline, report) = run(world, &settings(duration, true, 256.0)).unwrap();
    let mut energies = Vec::new();
    let count = world.bodies.iter().filter(|b| b.motion == Motion::Free).count();
    let mut samples: Vec<_> =
        timeline.poses.iter().filter(|p| (p.time * 256.0).fract() == 0.0).copied().collect();
    samples.sort_by(|a, b| a.time.total_cmp(&b.time));
    for chunk in samples.chunk_by(|a, b| a.time == b.time) {
        assert!(chunk.len() >= count && chunk.iter().all(|p| p.position.is_finite()));
        let height: f64 =
            chunk.iter().map(|p| -world.bodies[p.body.index()].mass * world.gravity.dot(p.position)).sum();
        energies.push(kinetic_energy(world, chunk) + height);
    }
    let mass: f64 = world.bodies.iter().filter(|b| b.motion == Motion::Free).map(|b| b.mass).sum();
    let gain = energies.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max) / mass;
    println!("{name}: {} rows, overlap {:.1e} m, gain {gain:.1e} J/kg", report.rows, report.deepest_overlap);
    assert!(gain < 1e-6, "{name} gains {gain:e}");
    // Deepest seen: 1.6e-6 m in the heap, 2e-8 m elsewhere.
    assert!(report.deepest_overlap < 5e-6, "{name} overlaps by {:e}", report.deepest_overlap);
    last_poses(&timeline).iter().map(|p| p.velocity.length()).fold(0.0, f64::max)
}

fn box_of(bodies: Vec<Body>, edge: f64, gravity: f64) -> World {
    let material = bodies[0].material.clone();
    let mut all = bodies;
    for axis in DVec3::AXES {
        all.push(plane(DVec3::ZERO, axis, &material));
        all.push(plane(axis * edge, -axis, &material));
    }
    world(all, vec![], gravity)
}

#[test]
fn nothing_hangs_at_the_ends_of_the_coefficients() {
    let r = 0.01;
    for restitution in [0.0, 0.3, 1.0] {
        for friction in [0.0, 0.6] {
            for gravity in [0.0, G] {
                let m = material(restitution, friction, 1e-4);
                let name = format!("e {restitution} mu {friction} g {gravity}");
                let still = |at: DVec3| sphere(r, at, DVec3::ZERO, &m);
                // One ball, in the air; on the floor; in a corner of three planes.
                ends(&name, &box_of(vec![still(DVec3::splat(0.05))], 0.2, gravity), 1.0);
                ends(&name, &box_of(vec![still(DVec3::new(0.05, r, 0.05))], 0.2, gravity), 1.0);
                ends(&name, &box_of(vec![still(DVec3::splat(r))], 0.2, gravity), 1.0);
                // Touching at the start: a row on the floor, and a tower.
                let row = (0..4).map(|k| still(DVec3::new(r + 2.0 * r * f64::from(k), r, r)));
                ends(&name, &box_of(row.collect(), 0.2, gravity), 0.5);
                let tower = (0..3).map(|k| still(DVec3::new(0.1, r + 2.0 * r * f64::from(k), 0.1)));
                ends(&name, &box_of(tower.collect(), 0.2, gravity), 0.5);
                // A ball hits a row of balls.
                let mut struck: Vec<Body> =
                    (0..4).map(|k| still(DVec3::new(0.06 + 2.0 * r * f64::from(k), r, r))).collect();
                struck[0].pose.position.x = r;
                struck[0].velocity = DVec3::X;
                ends(&name, &box_of(struck, 0.2, gravity), 0.5);
            }
        }
    }
}

#[test]
fn a_heap_of_balls_keeps_going() {
    let m = material(0.4, 0.3, 1e-4);
    let mut bodies: Vec<Body> = (0..18)
        .map(|k| {
            let at = DVec3::new(f64::from(k % 3), f64::from(k / 9), f64::from(k / 3 % 3)) * 0.021;
            let jitter = DVec3::new(0.1, 0.0, 0.05) * f64::from(k % 7) * 1e-3;
            sphere(0.01, at + jitter + 0.012, DVec3::ZERO, &m)
        })
        .collect();
    let sides = [(DVec3::X, 0.0), (DVec3::Z, 0.0), (DVec3::NEG_X, 0.068), (DVec3::NEG_Z, 0.068)];
    bodies.extend(sides.map(|(normal, at)| plane(-normal * at, normal, &m)));
    bodies.push(plane(DVec3::ZERO, DVec3::Y, &m));
    ends("heap", &world(bodies, vec![], G), 0.2);
}

#[test]
fn a_tilted_corner_comes_to_rest() {
    let m = material(0.3, 0.4, 2e-4);
    let mut bodies = vec![sphere(0.01, DVec3::new(0.01, 0.06, 0.0), DVec3::new(0.2, 0.0, 0.3), &m)];
    for k in 0..3 {
        let (sin, cos) = (f64::from(k) * 2.1).sin_cos();
        bodies.push(plane(DVec3::ZERO, DVec3::new(cos, 1.0, sin), &m));
    }
    let speed = ends("tilted corner", &world(bodies, vec![], G), 4.0);
    assert!(speed == 0.0, "{speed:e}");
}

#[test]
fn a_ball_runs_down_a_groove() {
    // Symmetric groove of 90°: rolling without slip on two contacts at distance r/√2 from the axis.
    let m = material(0.2, 0.8, 0.0);
    let tilt = 0.2_f64;
    let along = DVec3::new(0.0, -tilt.sin(), tilt.cos());
    let up = DVec3::new(0.0, tilt.cos(), tilt.sin());
    let normals = [(up + DVec3::X).normalize(), (up - DVec3::X).normalize()];
    let r = 0.01;
    let mut bodies = vec![sphere(r, up * (r * 2.0_f64.sqrt()), DVec3::ZERO, &m)];
    bodies.extend(normals.map(|n| plane(DVec3::ZERO, n, &m)));
    let world = world(bodies, vec![], G);
    let (timeline, _) = run(&world, &settings(0.5, false, 2.0)).unwrap();
    let pose = last_poses(&timeline)[0];
    // a = g sin θ / (1 + I/(m b²)), b = r/√2.
    let acceleration = G * tilt.sin() / (1.0 + 0.4 * 2.0);
    // Residual seen: 1e-9 relative.
    assert!((pose.velocity.dot(along) / (0.5 * acceleration) - 1.0).abs() < 1e-6, "{}", pose.velocity);
    assert!((pose.velocity - along * pose.velocity.dot(along)).length() < 1e-9);
}

#[test]
fn overlaps_are_refused_unless_they_are_rounding() {
    let m = material(0.5, 0.1, 0.0);
    let pair = |gap: f64| {
        let at = DVec3::X * (0.02 + gap);
        let bodies = vec![sphere(0.01, DVec3::ZERO, DVec3::X, &m), sphere(0.01, at, DVec3::ZERO, &m)];
        run(&world(bodies, vec![], 0.0), &settings(0.1, false, 10.0))
    };
    let Err(SimulationError::StartOverlap { depth, .. }) = pair(-2e-6) else { panic!("accepted") };
    assert!((depth - 2e-6).abs() < 1e-12);
    let (timeline, _) = pair(-1e-8).unwrap();
    assert!(last_poses(&timeline)[0].velocity.x < last_poses(&timeline)[1].velocity.x);
    let sunk = vec![sphere(0.01, DVec3::Y * 0.009, DVec3::ZERO, &m), plane(DVec3::ZERO, DVec3::Y, &m)];
    let sunk = run(&world(sunk, vec![], G), &settings(0.1, false, 10.0));
    assert!(matches!(sunk, Err(SimulationError::StartOverlap { .. })));
}

#[test]
fn what_is_no_sphere_is_named() {
    let m = material(0.5, 0.1, 0.0);
    let mut free_plane = plane(DVec3::ZERO, DVec3::Y, &m);
    free_plane.motion = Motion::Free;
    let refused = run(&world(vec![free_plane], vec![], G), &settings(0.1, false, 10.0));
    assert!(matches!(refused, Err(SimulationError::NotASphere { ref body, .. }) if body == "body0"));
    let ball = sphere(0.01, DVec3::ZERO, DVec3::ZERO, &m);
    let rod = Link::Hang { body: BodyId(0), anchor: DVec3::ZERO };
    let refused = run(&world(vec![ball.clone()], vec![rod], G), &settings(0.1, false, 10.0));
    assert!(matches!(refused, Err(SimulationError::NotASphere { .. })));
    let mut lost = ball;
    lost.velocity.x = f64::NAN;
    let refused = run(&world(vec![lost], vec![], G), &settings(0.1, false, 10.0));
    assert!(matches!(refused, Err(SimulationError::Diverged { .. })));
}

#[test]
fn the_same_world_gives_the_same_bits() {
    let m = material(0.7, 0.3, 1e-4);
    let mut balls: Vec<Body> = (0..60)
        .map(|k| {
            let at = DVec3::new(f64::from(k % 4), f64::from(k / 16), f64::from(k / 4 % 4)) * 0.03 + 0.03;
            let speed = DVec3::new((f64::from(k) * 1.7).sin(), (f64::from(k) * 2.3).cos(), 0.3);
            sphere(0.008 + 0.0001 * f64::from(k % 5), at, speed, &m)
        })
        .collect();
    balls[3].velocity = DVec3::ZERO;
    let mut world = box_of(balls, 0.16, G);
    world.links.push(Link::Spring {
        body: BodyId(3),
        at: DVec3::ZERO,
        to: LinkEnd::Point(DVec3::splat(0.08)),
        rest_length: 0.02,
        stiffness: 20.0,
        damping: 0.01,
    });
    let settings = settings(0.4, true, 100.0);
    let (one, two) = (run(&world, &settings).unwrap(), run(&world, &settings).unwrap());
    assert!(one.1.impacts > 500);
    assert_eq!(one, two);
}
