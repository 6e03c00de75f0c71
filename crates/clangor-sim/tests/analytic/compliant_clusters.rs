//! Rows and racks of balls that press on each other, against their equations of motion integrated by
//! Runge–Kutta; ledger and energy of their raw logs.

use crate::sphere_worlds::{G, kinetic_energy, last_poses, material, plane, rack, run, sphere, world};
use clangor_core::body::{BodyId, Surface, World};
use clangor_core::contact::compliant::restitution_damping;
use clangor_core::timeline::{ContactKind, PoseRow, Timeline};
use clangor_sim::{ContactModel, SimulationSettings, Solver};
use glam::{DMat3, DVec3};

fn settings(duration: f64, raw: bool, pose_rate: f64) -> SimulationSettings {
    let rigid = crate::sphere_worlds::settings(duration, raw, pose_rate);
    SimulationSettings { contact: ContactModel::Compliant, ..rigid }
}

/// Velocities of balls of one material without friction after a time, by the classical Runge–Kutta method.
fn reference(world: &World, duration: f64, step: f64) -> Vec<DVec3> {
    let balls = &world.bodies;
    let radius = |k: usize| match *balls[k].surface {
        Surface::Sphere { radius } => radius,
        _ => panic!("a ball"),
    };
    let compliance = 2.0 * balls[0].material.contact_compliance();
    let alpha = restitution_damping(balls[0].material.restitution);
    let rate = |x: &[DVec3], v: &[DVec3]| {
        let mut a = vec![world.gravity; x.len()];
        for i in 0..x.len() {
            for j in i + 1..x.len() {
                let (d, w) = (x[i] - x[j], v[i] - v[j]);
                let overlap = radius(i) + radius(j) - d.length();
                if overlap <= 0.0 {
                    continue;
                }
                let (n, joint) = (d.normalize(), 1.0 / (1.0 / radius(i) + 1.0 / radius(j)));
                let stiffness = 4.0 / 3.0 * joint.sqrt() / compliance;
                let reduced = 1.0 / (1.0 / balls[i].mass + 1.0 / balls[j].mass);
                let damping = alpha * (stiffness * reduced).sqrt() * overlap.powf(0.25);
                let force = (stiffness * overlap.powf(1.5) - damping * n.dot(w)).max(0.0);
                a[i] += n * (force / balls[i].mass);
                a[j] -= n * (force / balls[j].mass);
            }
        }
        a
    };
    let mut x: Vec<DVec3> = balls.iter().map(|b| b.pose.position).collect();
    let mut v: Vec<DVec3> = balls.iter().map(|b| b.velocity).collect();
    let along = |x: &[DVec3], k: &[DVec3], h: f64| -> Vec<DVec3> {
        x.iter().zip(k).map(|(x, k)| *x + *k * h).collect()
    };
    for _ in 0..(duration / step).round() as usize {
        let a1 = rate(&x, &v);
        let (x2, v2) = (along(&x, &v, 0.5 * step), along(&v, &a1, 0.5 * step));
        let a2 = rate(&x2, &v2);
        let (x3, v3) = (along(&x, &v2, 0.5 * step), along(&v, &a2, 0.5 * step));
        let a3 = rate(&x3, &v3);
        let (x4, v4) = (along(&x, &v3, step), along(&v, &a3, step));
        let a4 = rate(&x4, &v4);
        for k in 0..x.len() {
            x[k] += (v[k] + 2.0 * v2[k] + 2.0 * v3[k] + v4[k]) * (step / 6.0);
            v[k] += (a1[k] + 2.0 * a2[k] + 2.0 * a3[k] + a4[k]) * (step / 6.0);
        }
    }
    v
}

/// Velocities at the end of a run, and the largest deviation from the reference [m/s].
fn deviation(world: &World, duration: f64, step: f64) -> (Vec<DVec3>, f64) {
    deviation_by(Solver::Auto, world, duration, step)
}

fn deviation_by(solver: Solver, world: &World, duration: f64, step: f64) -> (Vec<DVec3>, f64) {
    let settings = SimulationSettings { solver, ..settings(duration, false, 1.0 / duration) };
    let (timeline, _) = run(world, &settings).unwrap();
    let found: Vec<DVec3> = last_poses(&timeline).iter().map(|p| p.velocity).collect();
    let exact = reference(world, duration, step);
    assert_eq!(found.len(), exact.len());
    let worst = found.iter().zip(&exact).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    (found, worst)
}

#[test]
fn five_balls_in_a_row_pass_the_push_on_as_their_equations_say() {
    let steel = material(1.0, 0.0, 0.0);
    for gap in [0.0, 1e-6, 1e-5, 5e-5] {
        let ball = |k: u32| {
            let x = f64::from(k) * (0.02 + gap) - if k == 0 { 1e-4 } else { 0.0 };
            sphere(0.01, DVec3::X * x, DVec3::X * if k == 0 { 1.0 } else { 0.0 }, &steel)
        };
        let world = world((0..5).map(ball).collect(), vec![], 0.0);
        for solver in [Solver::Spheres, Solver::Rigid] {
            let (found, worst) = deviation_by(solver, &world, 2f64.powi(-9), 2f64.powi(-9) / 20_000.0);
            let speeds: Vec<String> = found.iter().map(|v| format!("{:.5}", v.x)).collect();
            println!("{solver:?}, gap {gap:.0e} m: {} m/s, within {worst:.1e} m/s", speeds.join(" "));
            // Residual seen: 3.4e-4 m/s without gaps, 4e-8 m/s at 50 µm.
            assert!(worst < 5e-4, "gap {gap}: {worst}");
        }
    }
}

#[test]
fn a_rack_breaks_as_its_equations_say() {
    for aside in [0.003, 0.0] {
        let world = rack(aside);
        let (found, worst) = deviation(&world, 2f64.powi(-7), 2f64.powi(-7) / 40_000.0);
        let (_, stepped) = deviation_by(Solver::Rigid, &world, 2f64.powi(-7), 2f64.powi(-7) / 40_000.0);
        println!("time-stepped: within {stepped:.1e} m/s");
        // Residual seen: 4.0e-2 m/s, because its normals are those of the first instant.
        assert!(stepped < 5e-2, "{aside}: {stepped}");
        let corners = [10, 14].map(|k: usize| found[k].length());
        println!("{aside} m aside: corners {corners:.4?} m/s, within {worst:.1e} m/s");
        // Residual seen: 1.6e-3 m/s.
        assert!(worst < 1e-2, "{aside}: {worst}");
        if aside == 0.0 {
            for row in 0..5_usize {
                let first = row * (row + 1) / 2;
                for k in 0..=row {
                    let (one, two) = (found[first + k], found[first + row - k]);
                    let off = one.distance(DVec3::new(two.x, two.y, -two.z));
                    assert!(off < 1e-3, "ball {}: {off}", first + k);
                }
            }
        }
    }
}

/// Largest residuals of momentum and angular momentum of the balls between two poses, over the impulses.
fn ledger(world: &World, timeline: &Timeline, step: f64) -> [f64; 2] {
    let radius = |body: BodyId| match world.bodies.get(body.index()).map(|b| (*b.surface).clone()) {
        Some(Surface::Sphere { radius }) => radius,
        _ => f64::INFINITY,
    };
    let mut worst = [0.0_f64; 2];
    let moving = world.bodies.iter().enumerate().filter(|(_, b)| b.mass.is_finite());
    for (index, body) in moving {
        let id = BodyId(index as u32);
        let on_step = |p: &&PoseRow| p.body == id && (p.time / step).fract() == 0.0;
        let poses: Vec<PoseRow> = timeline.poses.iter().filter(on_step).copied().collect();
        for pair in poses.windows(2) {
            let (from, to) = (&pair[0], &pair[1]);
            let (mut sum, mut torque, mut size) = (DVec3::ZERO, DVec3::ZERO, 0.0);
            for row in &timeline.contacts {
                let acts = row.time > from.time && row.time <= to.time && row.kind != ContactKind::Constraint;
                if !acts || (row.body_a != id && row.body_b != id) {
                    continue;
                }
                let sign = if row.body_a == id { 1.0 } else { -1.0 };
                // The point lies between the surfaces, at a part of the distance in proportion to the radii.
                let other = radius(if row.body_a == id { row.body_b } else { row.body_a });
                let share = if other.is_finite() { radius(id) / (radius(id) + other) } else { 0.0 };
                let arm = row.normal * (-sign * (radius(id) - share * row.depth.max(0.0)));
                sum += row.impulse() * sign;
                torque += arm.cross(row.impulse() * sign) + row.couple * sign;
                size += row.impulse().length();
            }
            let weight = world.gravity * (body.mass * (to.time - from.time));
            let size = size + weight.length() + 1e-6 * body.mass;
            let change = (to.velocity - from.velocity) * body.mass - weight - sum;
            let spin = (to.angular_velocity - from.angular_velocity) * body.inertia.x_axis.x - torque;
            worst[0] = worst[0].max(change.length() / size);
            worst[1] = worst[1].max(spin.length() / (size * radius(id)));
        }
    }
    worst
}

#[test]
fn the_raw_log_of_clusters_balances_and_energy_does_not_grow() {
    let rough = material(0.7, 0.3, 1e-4);
    let step = 2f64.powi(-8);
    for (name, gravity, floor) in [("free", 0.0, false), ("on a floor", G, true)] {
        let mut bodies = Vec::new();
        for layer in 0..3_u32 {
            for k in 0..9 {
                let at = DVec3::new(f64::from(k % 3), f64::from(layer), f64::from(k / 3)) * 0.020_02;
                let r = 0.0099 + 1e-5 * f64::from(k + layer);
                bodies.push(sphere(r, at + DVec3::Y * 0.0101, DVec3::ZERO, &rough));
            }
        }
        let mut striker = sphere(0.015, DVec3::new(0.021, 0.09, 0.018), DVec3::new(0.1, -2.0, 0.05), &rough);
        striker.angular_velocity = DVec3::new(40.0, 10.0, -30.0);
        striker.inertia = DMat3::from_diagonal(DVec3::splat(striker.inertia.x_axis.x));
        bodies.push(striker);
        if floor {
            bodies.push(plane(DVec3::ZERO, DVec3::Y, &rough));
        }
        let world = world(bodies, vec![], gravity);
        let settings = SimulationSettings { time_step: step, ..settings(0.25, true, 1.0 / step) };
        let (timeline, report) = run(&world, &settings).unwrap();
        let [linear, angular] = ledger(&world, &timeline, step);
        println!("{name}: {} rows, momentum {linear:.1e}, angular momentum {angular:.1e}", report.rows);
        let frames: Vec<PoseRow> =
            timeline.poses.iter().filter(|p| (p.time / step).fract() == 0.0).copied().collect();
        // Between two poses some of the energy may be in the contacts.
        let (mut before, mut last) = (f64::INFINITY, f64::INFINITY);
        for frame in frames.chunks(28) {
            let height: f64 =
                frame.iter().map(|p| world.bodies[p.body.index()].mass * gravity * p.position.y).sum();
            let energy = kinetic_energy(&world, frame) + height;
            let most = last.max(before);
            assert!(energy <= most * (1.0 + 1e-9), "{name}, {} s: {energy} J after {most}", frame[0].time);
            (before, last) = (last, energy);
        }
        // Residuals seen: 6e-15 and 2e-15; on the floor, where hundreds of thousands of small impacts follow,
        // 3e-12 and 3e-13.
        assert!(linear < 1e-10 && angular < 1e-10, "{name}: {linear:e} {angular:e}");
    }
}
