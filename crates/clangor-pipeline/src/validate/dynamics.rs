//! Motion and impulses of both solvers against ballistics, momentum and symmetry.

use std::ops::ControlFlow;

use clangor_core::body::{Body, BodyId, World};
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::{Material, presets};
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;
use clangor_core::timeline::{ContactKind, ContactRow, Timeline};
use clangor_sim::record::RecordSettings;
use clangor_sim::{ContactModel, SimulationSettings, Solver, simulate};

use super::{Check, Extent, Fault, Outcome, Timing, Validation, cpu_time};

const SECTION: &str = "Dynamics";
pub(super) const RADIUS: f64 = 0.0075;
pub(super) const GRAVITY: f64 = 9.81;

pub(super) fn run(extent: Extent, table: &mut Validation) -> Outcome {
    for (solver, name, steps) in
        [(Solver::Spheres, "spheres", &[2.5e-4][..]), (Solver::Rigid, "rigid", &[1e-4, 2.5e-4][..])]
    {
        for &time_step in steps {
            let label = match solver {
                Solver::Rigid => format!("{name}, step {} ms", time_step * 1e3),
                _ => name.to_string(),
            };
            bouncing_ball(solver, time_step, &label, table)?;
            cradle(solver, time_step, &label, table)?;
            v_break(solver, time_step, &label, table)?;
        }
    }
    first_impact(table)?;
    gas(extent, table)
}

pub(super) fn material(restitution: f64, friction: f64) -> Result<Material, Fault> {
    let steel = presets::preset("steel").ok_or("there is no preset steel")?;
    Ok(Material { friction, rolling_loss: 0.0, ..steel.with_restitution(restitution) })
}

pub(super) fn ball(name: &str, material: &Material, position: DVec3, velocity: DVec3) -> Body {
    Body::sphere(name, material.clone(), RADIUS).at(position).with_velocity(velocity).with_edge_radius(0.0)
}

/// A half-space through `point` whose outward normal is `normal`.
pub(super) fn plane(material: &Material, point: DVec3, normal: DVec3) -> Body {
    Body::plane(format!("plane {point} {normal}"), material.clone(), point, normal)
}

fn run_world(world: &World, solver: Solver, time_step: f64, duration: f64) -> Result<Timeline, Fault> {
    let mut timeline = Timeline::default();
    let settings = SimulationSettings {
        solver,
        contact: ContactModel::Rigid,
        duration,
        time_step,
        record: RecordSettings { v_min: 0.0, pose_rate: 1000.0, raw: false },
        sleep: false,
    };
    simulate(world, &settings, &mut timeline, &mut |_| ControlFlow::Continue(()))?;
    Ok(timeline)
}

/// A ball dropped 1 m: impulses, bounce ratios and times of the first five impacts.
fn bouncing_ball(solver: Solver, time_step: f64, label: &str, table: &mut Validation) -> Outcome {
    for restitution in [0.7, 1.0] {
        let material = material(restitution, 0.0)?;
        let bodies = vec![
            ball("ball", &material, DVec3::Y * (1.0 + RADIUS), DVec3::ZERO),
            plane(&material, DVec3::ZERO, DVec3::Y),
        ];
        let mass = bodies[0].mass;
        let world = World { bodies, links: Vec::new(), gravity: DVec3::NEG_Y * GRAVITY };
        let timeline = run_world(&world, solver, time_step, 4.0)?;
        let impacts = timeline.contacts.iter().filter(|r| r.kind == ContactKind::Impact).take(4);
        let mut speed = (2.0 * GRAVITY).sqrt();
        let mut time = speed / GRAVITY;
        let (mut impulse_error, mut time_error, mut count) = (0.0f64, 0.0f64, 0);
        for row in impacts {
            let exact = (1.0 + restitution) * mass * speed;
            impulse_error = impulse_error.max((row.impulse_n / exact - 1.0).abs());
            time_error = time_error.max((row.time - time).abs());
            speed *= restitution;
            time += 2.0 * speed / GRAVITY;
            count += 1;
        }
        if count < 4 {
            impulse_error = f64::INFINITY;
        }
        let quantity =
            |what: &str| format!("ball dropped 1 m, e = {restitution} ({label}): {what} of four bounces");
        table.checks.push(Check {
            section: SECTION,
            quantity: quantity("impulse"),
            reference: "(1 + e) m v with v from free fall",
            error: impulse_error,
            bar: 1e-9,
            unit: "",
        });
        table.checks.push(Check {
            section: SECTION,
            quantity: quantity("time"),
            reference: "free fall",
            error: time_error * 1e9,
            bar: 1.0,
            unit: "ns",
        });
    }
    Ok(())
}

/// Velocities of all bodies when the run ends.
fn final_velocities(world: &World, timeline: &Timeline) -> Vec<DVec3> {
    let last = |index: usize| {
        let of_body = |p: &&clangor_core::timeline::PoseRow| p.body == BodyId(index as u32);
        timeline
            .poses
            .iter()
            .filter(of_body)
            .max_by(|a, b| a.time.total_cmp(&b.time))
            .map_or(DVec3::NAN, |p| p.velocity)
    };
    (0..world.bodies.len()).map(last).collect()
}

/// Newton's cradle of five balls without gravity.
fn cradle(solver: Solver, time_step: f64, label: &str, table: &mut Validation) -> Outcome {
    let material = material(1.0, 0.0)?;
    let mut worst = 0.0f64;
    for gap in [0.0, 1e-9, 1e-5, 1e-4] {
        for moving in [1, 2] {
            let x = |i: usize| {
                let approach = if i < moving { -0.01 } else { 0.0 };
                i as f64 * (2.0 * RADIUS + gap) + approach
            };
            let bodies: Vec<Body> = (0..5)
                .map(|i| {
                    let velocity = if i < moving { DVec3::X } else { DVec3::ZERO };
                    ball(&format!("ball {i}"), &material, DVec3::X * x(i), velocity)
                })
                .collect();
            let world = World { bodies, links: Vec::new(), gravity: DVec3::ZERO };
            let timeline = run_world(&world, solver, time_step, 0.05)?;
            let velocities = final_velocities(&world, &timeline);
            let energy: f64 = velocities[5 - moving..].iter().map(|v| v.length_squared()).sum();
            worst = worst.max((energy / moving as f64 - 1.0).abs());
        }
    }
    table.checks.push(Check {
        section: SECTION,
        quantity: format!(
            "Newton's cradle, one and two in, gaps 0 to 100 µm ({label}): kinetic energy that arrives"
        ),
        reference: "all of it",
        error: worst,
        bar: 1e-9,
        unit: "",
    });
    Ok(())
}

/// One ball hits two touching balls between them.
fn v_break(solver: Solver, time_step: f64, label: &str, table: &mut Validation) -> Outcome {
    let material = material(1.0, 0.0)?;
    let height = 2.0 * RADIUS * 0.75f64.sqrt();
    let bodies = vec![
        ball("cue", &material, DVec3::new(0.0, 0.0, -0.02 - height), DVec3::Z),
        ball("left", &material, DVec3::new(-RADIUS, 0.0, 0.0), DVec3::ZERO),
        ball("right", &material, DVec3::new(RADIUS, 0.0, 0.0), DVec3::ZERO),
    ];
    let world = World { bodies, links: Vec::new(), gravity: DVec3::ZERO };
    let timeline = run_world(&world, solver, time_step, 0.05)?;
    let side = 0.12f64.sqrt();
    let exact = [DVec3::NEG_Z * 0.2, DVec3::new(-side, 0.0, 0.6), DVec3::new(side, 0.0, 0.6)];
    let velocities = final_velocities(&world, &timeline);
    let error = velocities.iter().zip(exact).map(|(v, e)| (*v - e).length()).fold(0.0, f64::max);
    table.checks.push(Check {
        section: SECTION,
        quantity: format!("V-break, e = 1 ({label}): velocities over that of the cue ball"),
        reference: "−1/5; 3/5, ±√3/5",
        error,
        bar: 1e-9,
        unit: "",
    });
    Ok(())
}

/// First impact of a tumbling die, against a step fifty times as fine.
fn first_impact(table: &mut Validation) -> Outcome {
    let material = material(0.5, 0.3)?;
    let (surface, mass) = Shape::parse("die:0.016x0")?.surface()?;
    let pose =
        Pose { position: DVec3::Y * 0.2, orientation: DQuat::from_scaled_axis(DVec3::new(0.3, -0.8, 0.5)) };
    let die = Body::solid("die", material.clone(), surface, &mass)
        .at(pose)
        .with_velocity(DVec3::new(0.3, 0.0, -0.1))
        .with_angular_velocity(DVec3::new(11.0, -7.0, 5.0))
        .with_edge_radius(0.0);
    let floor = plane(&material, DVec3::ZERO, DVec3::Y);
    let world = World { bodies: vec![die, floor], links: Vec::new(), gravity: DVec3::NEG_Y * GRAVITY };
    let first = |time_step: f64| -> Result<ContactRow, Fault> {
        let timeline = run_world(&world, Solver::Rigid, time_step, 0.25)?;
        let row = timeline.contacts.iter().find(|r| r.kind == ContactKind::Impact);
        Ok(*row.ok_or("there is no impact")?)
    };
    let fine = first(2.5e-4 / 50.0)?;
    let coarse = first(2.5e-4)?;
    table.checks.push(Check {
        section: SECTION,
        quantity: "first impact of a tumbling die, step 0.25 ms: time".into(),
        reference: "step 0.005 ms",
        error: (coarse.time - fine.time).abs() * 1e6,
        bar: 0.1,
        unit: "µs",
    });
    table.checks.push(Check {
        section: SECTION,
        quantity: "first impact of a tumbling die, step 0.25 ms: impulse".into(),
        reference: "step 0.005 ms",
        error: (coarse.impulse() - fine.impulse()).length() / fine.impulse().length(),
        bar: 1e-5,
        unit: "",
    });
    Ok(())
}

/// Elastic balls in a box: energy, and the cost of a simulated second.
fn gas(extent: Extent, table: &mut Validation) -> Outcome {
    let side_count: usize = match extent {
        Extent::Quick => 10,
        Extent::Full => 22,
    };
    let material = material(1.0, 0.0)?;
    let count = side_count.pow(3);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let side = (count as f64 * volume / 0.045).cbrt();
    let spacing = side / side_count as f64;
    let mut bodies: Vec<Body> = (0..count)
        .map(|i| {
            let cell = [i % side_count, i / side_count % side_count, i / side_count / side_count];
            let position = DVec3::from_array(cell.map(|c| (c as f64 + 0.5) * spacing));
            // Directions spread over the sphere by the golden angle: no generator is needed.
            let y = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
            let angle = 2.399_963_229_728_653 * i as f64;
            let across = (1.0 - y * y).sqrt();
            ball(
                &format!("ball {i}"),
                &material,
                position,
                DVec3::new(across * angle.cos(), y, across * angle.sin()),
            )
        })
        .collect();
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        bodies.push(plane(&material, DVec3::ZERO, axis));
        bodies.push(plane(&material, axis * side, -axis));
    }
    let world = World { bodies, links: Vec::new(), gravity: DVec3::ZERO };
    let begin = cpu_time();
    let mut timeline = Timeline::default();
    let duration = 1.0;
    let settings = SimulationSettings {
        solver: Solver::Spheres,
        contact: ContactModel::Rigid,
        duration,
        time_step: 2.5e-4,
        // Impacts are not of interest here: none is fast enough to be kept.
        record: RecordSettings { v_min: f64::MAX, pose_rate: 1.0 / duration, raw: false },
        sleep: false,
    };
    let report = simulate(&world, &settings, &mut timeline, &mut |_| ControlFlow::Continue(()))?;
    let seconds = cpu_time() - begin;
    let energy: f64 = final_velocities(&world, &timeline)[..count].iter().map(|v| v.length_squared()).sum();
    table.checks.push(Check {
        section: SECTION,
        quantity: format!(
            "{count} elastic balls in a box, 1 s, {} collisions: kinetic energy",
            report.dropped_impacts
        ),
        reference: "its start",
        error: (energy / count as f64 - 1.0).abs(),
        bar: 1e-12,
        unit: "",
    });
    table
        .timings
        .push(Timing { what: format!("{count} elastic balls, 1 simulated second"), cpu_seconds: seconds });
    Ok(())
}
