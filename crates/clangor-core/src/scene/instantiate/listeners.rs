//! Checks of listeners against the bodies of a world: none inside a body, none too far away.

use glam::DVec3;

use super::problems::Problems;
use crate::body::{Body, Surface, World};
use crate::scene::diagnostic::{Doubt, Problem};
use crate::scene::scene_description::Scene;

/// Distance from all bodies above which a listener gives a warning [m]: a click of 1 Pa at 10 cm is 60 dB
/// down.
const EARSHOT: f64 = 100.0;

/// Checks every receiver at every keyframe against the starting poses of the bodies.
pub(super) fn check(scene: &Scene, world: &World, problems: &mut Problems) {
    // The planes are the last bodies.
    let first_plane = world.bodies.len() - scene.planes.len();
    let is_thin = |body: usize| {
        body.checked_sub(first_plane)
            .and_then(|plane| scene.planes.get(plane))
            .is_some_and(|plane| plane.thin)
    };
    for listener in &scene.listeners {
        let mut nearest = f64::INFINITY;
        let mut inside: Option<(&Body, f64)> = None;
        for key in listener.track.keys() {
            for receiver in listener.receivers() {
                let point = key.pose.world_from_body(receiver);
                for (index, body) in world.bodies.iter().enumerate() {
                    let depth = depth(body, point);
                    if depth > 0.0 && !is_thin(index) && inside.is_none_or(|(_, deepest)| depth > deepest) {
                        inside = Some((body, depth));
                    }
                    if !body.surface.is_plane() {
                        let gap = (point - body.pose.position).length() - body.surface.bounding_radius();
                        nearest = nearest.min(gap.max(0.0));
                    }
                }
            }
        }
        if let Some((body, depth)) = inside {
            let problem = Problem::ListenerInside { body: body.name.clone(), depth };
            problems.error(listener.place.clone(), problem);
        }
        if nearest.is_finite() && nearest > EARSHOT {
            problems.warn(listener.place.clone(), Doubt::FarListener { distance: nearest });
        }
    }
}

/// Depth of a point inside a body [m]; 0 or less outside.
fn depth(body: &Body, point: DVec3) -> f64 {
    let local = body.pose.body_from_world(point);
    match &*body.surface {
        Surface::Sphere { radius } => radius - local.length(),
        Surface::HalfSpace => -local.y,
        Surface::Plate { thickness } => (-local.y).min(local.y + thickness),
        Surface::Mesh(surface) => -surface.signed_distance(local),
    }
}
