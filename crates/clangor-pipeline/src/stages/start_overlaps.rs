//! Heaps of bodies that overlap at the start, found before a solver lists all pairs that touch.
//!
//! The solvers refuse overlaps too, with the exact depth. They list every pair first, which takes memory
//! with the square of the number of bodies that lie at one place. Here every body stands for the ball about
//! its centre of mass that it contains: where two such balls overlap, the bodies do.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

use clangor_core::body::{Body, Motion, Surface, World};
use clangor_core::geometry::ball_tree::{Ball, BallTree};
use clangor_core::glam::DVec3;
use clangor_sim::SimulationError;

/// Bodies of a world that the solvers can look at pair by pair.
const FEW_BODIES: usize = 500;
/// Overlap that every solver refuses \[m\].
const REFUSED: f64 = 1e-4;
/// Share of the smaller ball that overlaps too: convex parts of meshes may lie inside of their surface.
const REFUSED_SHARE: f64 = 0.1;

/// Refuses the first pair of bodies whose inner balls overlap, of which one is free, in a world of many
/// bodies. Bodies with links are left to the solver, which may let them overlap.
pub(super) fn refuse_heaps(world: &World) -> Result<(), SimulationError> {
    if world.bodies.len() < FEW_BODIES {
        return Ok(());
    }
    let balls = inner_balls(&world.bodies);
    let radii: BTreeMap<usize, f64> = balls.iter().map(|ball| (ball.body, ball.radius)).collect();
    let linked: BTreeSet<usize> =
        world.links.iter().flat_map(|link| link.bodies()).map(|id| id.index()).collect();
    let tree = BallTree::new(balls.clone());
    for ball in balls {
        if !matches!(world.bodies[ball.body].motion, Motion::Free) || linked.contains(&ball.body) {
            continue;
        }
        let mut found = None;
        tree.near(ball.centre, ball.radius - REFUSED, |other| {
            let radius = radii.get(&other).copied().unwrap_or(0.0);
            let depth = ball.radius + radius - ball.centre.distance(world.bodies[other].pose.position);
            let is_refused = depth > REFUSED.max(REFUSED_SHARE * ball.radius.min(radius));
            if other == ball.body || linked.contains(&other) || !is_refused {
                return ControlFlow::Continue(());
            }
            found = Some((other, depth));
            ControlFlow::Break(())
        });
        if let Some((other, depth)) = found {
            let name = |index: usize| world.bodies[index].name.clone();
            let (a, b) = (name(ball.body.min(other)), name(ball.body.max(other)));
            return Err(SimulationError::StartOverlap { a, b, depth, time: 0.0 });
        }
    }
    Ok(())
}

/// The balls about the centres of mass that lie within bodies; none for a bowl, whose centre lies outside.
fn inner_balls(bodies: &[Body]) -> Vec<Ball> {
    // Copies share a surface.
    let mut known: BTreeMap<*const Surface, f64> = BTreeMap::new();
    let mut ball = |(index, body): (usize, &Body)| {
        let inner = || match &*body.surface {
            Surface::Sphere { radius } => *radius,
            Surface::Mesh(mesh) => -mesh.signed_distance(DVec3::ZERO),
            Surface::HalfSpace | Surface::Plate { .. } => 0.0,
        };
        let radius = *known.entry(std::sync::Arc::as_ptr(&body.surface)).or_insert_with(inner);
        (radius > REFUSED).then_some(Ball { centre: body.pose.position, radius, body: index })
    };
    bodies.iter().enumerate().filter_map(&mut ball).collect()
}
