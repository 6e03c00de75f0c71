//! Live worlds for tests and benches.
#![allow(dead_code, reason = "every file uses some of it")]

use clangor_core::body::{BodyId, Surface, World};
use clangor_core::material::Material;
use clangor_sim::live::LiveWorld;
use glam::DVec3;

use super::{plane, sphere, world};

/// Marbles in an open box, on a slightly perturbed grid above its floor.
pub(crate) fn marbles_in_a_box(count: usize, radius: f64, material: &Material) -> World {
    // About as wide as the pile is high.
    let side = ((1.2 * count as f64).cbrt() as usize).max(2);
    let half = side as f64 * 1.2 * radius;
    let mut bodies: Vec<_> = (0..count)
        .map(|k| {
            let (i, j, layer) = (k % side, k / side % side, k / (side * side));
            let jitter = |seed: usize| 0.1 * radius * ((k * seed % 97) as f64 / 97.0 - 0.5);
            let place = |n: usize| 2.4 * radius * (n as f64 - 0.5 * (side - 1) as f64);
            let height = radius * (2.0 + 2.4 * layer as f64);
            let at = DVec3::new(place(i) + jitter(31), height, place(j) + jitter(57));
            sphere(radius, at, DVec3::new(jitter(13), 0.0, jitter(71)), material)
        })
        .collect();
    bodies.push(plane(DVec3::ZERO, DVec3::Y, material));
    for normal in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z] {
        bodies.push(plane(normal * -half, normal, material));
    }
    world(bodies, Vec::new(), 9.81)
}

/// Deepest overlap of any two bodies \[m\].
pub(crate) fn deepest_overlap(live: &LiveWorld) -> f64 {
    let states = live.states();
    let bodies: Vec<_> = (0..live.count() as u32)
        .filter_map(|id| {
            let body = live.body(BodyId(id))?;
            let radius = if let Surface::Sphere { radius } = *body.surface { radius } else { 0.0 };
            Some((radius, states[id as usize].pose))
        })
        .collect();
    let mut deepest = f64::NEG_INFINITY;
    for (k, (radius, pose)) in bodies.iter().enumerate() {
        for (other_radius, other) in &bodies[k + 1..] {
            let gap = match (*radius > 0.0, *other_radius > 0.0) {
                (true, true) => pose.position.distance(other.position) - radius - other_radius,
                (true, false) => other.body_from_world(pose.position).y - radius,
                (false, true) => pose.body_from_world(other.position).y - other_radius,
                (false, false) => continue,
            };
            deepest = deepest.max(-gap);
        }
    }
    deepest
}
