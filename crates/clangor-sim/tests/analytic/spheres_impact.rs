//! Impacts of the event-driven solver against closed forms: bounces, cradle, symmetric break.

use crate::sphere_worlds::{
    G, kinetic_energy, last_poses, material, plane, rows_of, run, settings, sphere, world,
};
use clangor_core::body::World;
use clangor_sim::{SimulationSettings, Solver};
use glam::DVec3;

fn bounce(restitution: f64) {
    let material = material(restitution, 0.5, 0.0);
    let (radius, height) = (7.5e-3, 1.0);
    let ball = sphere(radius, DVec3::Y * (height + radius), DVec3::ZERO, &material);
    let mass = ball.mass;
    let world = world(vec![ball, plane(DVec3::ZERO, DVec3::Y, &material)], vec![], G);
    let (timeline, _) = run(&world, &settings(3.5, false, 1000.0)).unwrap();
    let rows = rows_of(&timeline, 0);
    assert!(rows.len() >= 4, "{}", rows.len());
    let (mut time, mut speed) = ((2.0 * height / G).sqrt(), (2.0 * G * height).sqrt());
    for row in rows.iter().take(5) {
        // Residuals seen: 2e-15 s, 1e-14 relative.
        assert!((row.time - time).abs() < 1e-12, "{} {time}", row.time);
        assert!((row.approach_speed() / speed - 1.0).abs() < 1e-12);
        assert!((row.impulse_n / ((1.0 + restitution) * mass * speed) - 1.0).abs() < 1e-12);
        assert!(row.impulse_t.length() == 0.0 && row.normal == DVec3::Y);
        assert!(row.point.length() < 1e-14 && row.depth.abs() < 1e-14);
        speed *= restitution;
        time += 2.0 * speed / G;
    }
}

#[test]
fn a_dropped_ball_bounces_to_e_squared_of_its_height() {
    bounce(0.7);
    bounce(1.0);
}

#[test]
fn a_bouncing_ball_comes_to_rest_when_the_bounces_end() {
    let material = material(0.7, 0.5, 0.0);
    let radius = 7.5e-3;
    let ball = sphere(radius, DVec3::Y * (1.0 + radius), DVec3::ZERO, &material);
    let world = world(vec![ball, plane(DVec3::ZERO, DVec3::Y, &material)], vec![], G);
    let (timeline, _) = run(&world, &settings(4.0, false, 1000.0)).unwrap();
    // The geometric series of the flights: t = √(2h/g) (1 + e)/(1 − e) = 2.559 s.
    let end = (2.0_f64 / G).sqrt() * 1.7 / 0.3;
    let last = rows_of(&timeline, 0).last().unwrap().time;
    assert!(last < end && end - last < 2e-4, "{last} {end}");
    let pose = last_poses(&timeline)[0];
    assert!(pose.velocity.length() == 0.0 && (pose.position.y - radius).abs() < 1e-12);
}

fn cradle(gap: f64, struck: usize) -> World {
    let material = material(1.0, 0.0, 0.0);
    let radius = 0.01;
    let balls = (0..5).map(|k| {
        let moving = k < struck;
        let x = f64::from(k as u32) * (2.0 * radius + gap) - if moving { 0.05 } else { 0.0 };
        sphere(radius, DVec3::X * x, if moving { DVec3::X } else { DVec3::ZERO }, &material)
    });
    world(balls.collect(), vec![], 0.0)
}

#[test]
fn a_cradle_passes_the_momentum_on_whatever_the_gaps() {
    for gap in [0.0, 1e-9, 1e-5, 1e-4] {
        for struck in [1, 2, 3] {
            let world = cradle(gap, struck);
            let (timeline, _) = run(&world, &settings(0.2, false, 10.0)).unwrap();
            let poses = last_poses(&timeline);
            for (k, pose) in poses.iter().enumerate() {
                let wanted = if k >= 5 - struck { DVec3::X } else { DVec3::ZERO };
                // Residual seen: 0.
                assert!((pose.velocity - wanted).length() < 1e-10, "gap {gap} ball {k}: {}", pose.velocity);
            }
        }
    }
}

/// The sound of a chain begins where it is struck, which the states before the impacts of its instant say.
#[test]
fn poses_at_an_impact_are_those_before_all_impacts_of_the_instant() {
    // Lengths without rounding: the impacts of the chain have one instant.
    let material = material(1.0, 0.0, 0.0);
    let balls = (0..5).map(|k| {
        let (x, speed) = (0.03125 * f64::from(k), if k == 0 { 1.0 } else { 0.0 });
        sphere(0.015625, DVec3::X * (x - 0.0625 * speed), DVec3::X * speed, &material)
    });
    let chain = world(balls.collect(), vec![], 0.0);
    for solver in [Solver::Spheres, Solver::Rigid] {
        let settings = SimulationSettings { solver, ..settings(0.1, false, 10.0) };
        let (timeline, _) = run(&chain, &settings).unwrap();
        let impacts: Vec<f64> = timeline.contacts.iter().map(|row| row.time).collect();
        assert_eq!(impacts.len(), 4);
        assert!(impacts.iter().all(|time| *time == impacts[0]), "{impacts:?}");
        for ball in 0..5 {
            let at = timeline.poses.iter().filter(|pose| pose.time == impacts[0] && pose.body.0 == ball);
            let velocities: Vec<DVec3> = at.map(|pose| pose.velocity).collect();
            let before = if ball == 0 { DVec3::X } else { DVec3::ZERO };
            let are_before = velocities.iter().all(|v| (*v - before).length() < 1e-9);
            // Residual seen: 0.
            assert!(!velocities.is_empty() && are_before, "{solver:?}, {ball}: {velocities:?}");
        }
    }
}

#[test]
fn one_ball_on_two_breaks_symmetrically() {
    let material = material(1.0, 0.0, 0.0);
    let radius = 0.02;
    let side = 2.0 * radius;
    let corner = DVec3::new(side * 0.75_f64.sqrt(), 0.5 * side, 0.0);
    let (down, away) = (DVec3::new(corner.x, -corner.y, 0.0), DVec3::X * -0.1);
    let balls = vec![
        sphere(radius, away, DVec3::X, &material),
        sphere(radius, corner, DVec3::ZERO, &material),
        sphere(radius, down, DVec3::ZERO, &material),
    ];
    let (timeline, _) = run(&world(balls, vec![], 0.0), &settings(0.3, false, 10.0)).unwrap();
    let poses = last_poses(&timeline);
    let across = 0.12_f64.sqrt();
    let wanted = [DVec3::X * -0.2, DVec3::new(0.6, across, 0.0), DVec3::new(0.6, -across, 0.0)];
    for (pose, wanted) in poses.iter().zip(wanted) {
        // Residual seen: 6e-17.
        assert!((pose.velocity - wanted).length() < 1e-12, "{} {wanted}", pose.velocity);
    }
}

#[test]
fn friction_turns_two_sevenths_of_the_slip_into_spin() {
    // A ball without spin meets a plane at 45°: a wide cone stops the slip, a narrow one limits the impulse.
    for friction in [0.9, 0.05, 0.0] {
        let material = material(0.8, friction, 0.0);
        let radius = 0.01;
        let ball = sphere(radius, DVec3::Y * 0.05, DVec3::new(1.0, -1.0, 0.0), &material);
        let (mass, inertia) = (ball.mass, ball.inertia.x_axis.x);
        let world = world(vec![ball, plane(DVec3::ZERO, DVec3::Y, &material)], vec![], 0.0);
        let (timeline, _) = run(&world, &settings(0.1, false, 100.0)).unwrap();
        let tangential = (friction * 1.8_f64).min(2.0 / 7.0);
        let pose = last_poses(&timeline)[0];
        assert!((pose.velocity - DVec3::new(1.0 - tangential, 0.8, 0.0)).length() < 1e-14);
        let spin = -tangential * mass * radius / inertia;
        assert!((pose.angular_velocity - DVec3::Z * spin).length() < 1e-11);
        let before = kinetic_energy(&world, &timeline.poses[..1]);
        assert!(kinetic_energy(&world, &[pose]) <= before);
    }
}
