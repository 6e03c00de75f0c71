//! Checks of listeners against the bodies of a world: none inside a body, none too far away.

use std::ops::ControlFlow;

use glam::DVec3;

use super::problems::Problems;
use crate::body::{Body, Surface, World};
use crate::geometry::ball_tree::{Ball, BallTree};
use crate::scene::body_description::PlaneDescription;
use crate::scene::diagnostic::{Doubt, Problem, SHOWN};
use crate::scene::scene_description::Scene;

/// Distance from all bodies above which a listener gives a warning [m]: a click of 1 Pa at 10 cm is 60 dB
/// down.
const EARSHOT: f64 = 100.0;

/// Checks every receiver at every keyframe against the starting poses of the bodies. Once [`SHOWN`] listeners
/// are inside bodies, the others are not looked at.
pub(super) fn check(scene: &Scene, world: &World, problems: &mut Problems) {
    let bodies = Bodies::new(scene, world);
    let mut inside_count = 0;
    for listener in &scene.listeners {
        // Where listeners are near, the distance does not matter.
        let mut nearest = f64::INFINITY;
        let mut inside: Option<(&Body, f64)> = None;
        for key in listener.track.keys() {
            for receiver in listener.receivers() {
                let point = key.pose.world_from_body(receiver);
                inside = bodies.deepest(point, inside);
                if nearest > EARSHOT {
                    nearest = bodies.balls.nearest_gap(point, nearest);
                }
            }
        }
        if let Some((body, depth)) = inside {
            let problem = Problem::ListenerInside { body: body.name.clone(), depth };
            problems.error(listener.place.clone(), problem);
            inside_count += 1;
            if inside_count == SHOWN {
                return;
            }
        }
        if nearest.is_finite() && nearest > EARSHOT {
            problems.warn(listener.place.clone(), Doubt::FarListener { distance: nearest });
        }
    }
}

/// The bodies of a world: planes in a list, the others by their bounding balls.
struct Bodies<'w> {
    world: &'w World,
    /// Planes in which no listener may be.
    planes: Vec<&'w Body>,
    balls: BallTree,
}

impl<'w> Bodies<'w> {
    fn new(scene: &Scene, world: &'w World) -> Self {
        // The planes are the last bodies.
        let first_plane = world.bodies.len() - scene.planes.len();
        let is_solid = |(_, plane): &(&Body, &PlaneDescription)| !plane.thin;
        let planes = world.bodies[first_plane..].iter().zip(&scene.planes).filter(is_solid);
        let others = world.bodies.iter().enumerate().filter(|(_, body)| !body.surface.is_plane());
        let ball = |(index, body): (usize, &Body)| Ball {
            centre: body.pose.position,
            radius: body.surface.bounding_radius(),
            body: index,
        };
        let balls = BallTree::new(others.map(ball).collect());
        Bodies { world, planes: planes.map(|(body, _)| body).collect(), balls }
    }

    /// The body in which a point is deepest, if it is deeper there than in the one that is known.
    fn deepest(&self, point: DVec3, known: Option<(&'w Body, f64)>) -> Option<(&'w Body, f64)> {
        let mut deepest = known;
        let mut look = |body: &'w Body| {
            let depth = depth(body, point);
            if depth > 0.0 && deepest.is_none_or(|(_, most)| depth > most) {
                deepest = Some((body, depth));
            }
        };
        self.planes.iter().for_each(|plane| look(plane));
        self.balls.near(point, 0.0, |body| {
            look(&self.world.bodies[body]);
            ControlFlow::Continue(())
        });
        deepest
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
