//! Worlds of spheres and planes for the tests of the event-driven solver.
#![allow(dead_code, reason = "every test file uses some of it")]

pub(crate) mod live;

use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Link, Motion, Surface, World};
use clangor_core::material::{Damping, Material};
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactRow, PoseRow, Timeline};
use clangor_sim::record::RecordSettings;
use clangor_sim::{ContactModel, SimulationError, SimulationReport, SimulationSettings, Solver, simulate};
use glam::{DMat3, DQuat, DVec3};

pub(crate) const G: f64 = 9.81;

pub(crate) fn material(restitution: f64, friction: f64, rolling_loss: f64) -> Material {
    Material {
        name: "test".into(),
        density: 7850.0,
        youngs_modulus: 200e9,
        poisson_ratio: 0.29,
        restitution,
        restitution_speed: None,
        rigid_restitution: None,
        yield_strength: None,
        friction,
        rolling_loss,
        damping: Damping::LossFactor(1e-3),
        tensile_strength: None,
        fracture_energy: None,
        source: "test".into(),
    }
}

pub(crate) fn sphere(radius: f64, position: DVec3, velocity: DVec3, material: &Material) -> Body {
    let mass = material.density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let inertia = DMat3::from_diagonal(DVec3::splat(0.4 * mass * radius * radius));
    Body::new("", material.clone(), Surface::Sphere { radius }, mass, inertia)
        .at(position)
        .with_velocity(velocity)
        .with_edge_radius(radius)
}

pub(crate) fn plane(point: DVec3, normal: DVec3, material: &Material) -> Body {
    Body {
        surface: Arc::new(Surface::HalfSpace),
        mass: f64::INFINITY,
        pose: Pose { position: point, orientation: DQuat::from_rotation_arc(DVec3::Y, normal.normalize()) },
        motion: Motion::Fixed,
        ..sphere(1.0, DVec3::ZERO, DVec3::ZERO, material)
    }
}

pub(crate) fn world(mut bodies: Vec<Body>, links: Vec<Link>, gravity: f64) -> World {
    for (index, body) in bodies.iter_mut().enumerate() {
        body.name = format!("body{index}");
    }
    World { bodies, links, gravity: DVec3::NEG_Y * gravity }
}

pub(crate) fn settings(duration: f64, raw: bool, pose_rate: f64) -> SimulationSettings {
    SimulationSettings {
        solver: Solver::Spheres,
        contact: ContactModel::Rigid,
        duration,
        time_step: 1e-3,
        record: RecordSettings { v_min: 0.0, pose_rate, raw },
        sleep: true,
    }
}

pub(crate) fn run(
    world: &World,
    settings: &SimulationSettings,
) -> Result<(Timeline, SimulationReport), SimulationError> {
    let mut timeline = Timeline::default();
    let report = simulate(world, settings, &mut timeline, &mut |_| ControlFlow::Continue(()))?;
    Ok((timeline, report))
}

/// The rows with a given body as A.
pub(crate) fn rows_of(timeline: &Timeline, body: u32) -> Vec<ContactRow> {
    timeline.contacts.iter().filter(|r| r.body_a == BodyId(body)).copied().collect()
}

/// The poses at the pose rate (impacts write poses of their own) at the last sampled time.
pub(crate) fn last_poses(timeline: &Timeline) -> Vec<PoseRow> {
    let last = timeline.poses.iter().fold(0.0_f64, |t, p| t.max(p.time));
    timeline.poses.iter().filter(|p| p.time == last).copied().collect()
}

pub(crate) fn kinetic_energy(world: &World, poses: &[PoseRow]) -> f64 {
    poses
        .iter()
        .map(|p| {
            let body = &world.bodies[p.body.index()];
            0.5 * body.mass * p.velocity.length_squared()
                + 0.5 * body.inertia.x_axis.x * p.angular_velocity.length_squared()
        })
        .sum()
}

/// Fifteen balls with gaps of 50 µm, and a cue ball that meets the first one off its middle.
pub(crate) fn rack(aside: f64) -> World {
    let phenolic =
        Material { density: 1700.0, youngs_modulus: 5.8e9, poisson_ratio: 0.34, ..material(0.93, 0.0, 0.0) };
    let (radius, pitch) = (0.028575, 2.0 * 0.028575 + 5e-5);
    let mut bodies = Vec::new();
    for row in 0..5_u32 {
        let x = f64::from(row) * pitch * 0.75_f64.sqrt();
        for k in 0..=row {
            let z = (f64::from(k) - 0.5 * f64::from(row)) * pitch;
            bodies.push(sphere(radius, DVec3::new(x, 0.0, z), DVec3::ZERO, &phenolic));
        }
    }
    let start = DVec3::new(-2.0 * radius - 1e-3, 0.0, aside);
    bodies.push(sphere(radius, start, DVec3::X * 6.79, &phenolic));
    world(bodies, vec![], 0.0)
}
