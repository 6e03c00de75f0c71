//! Whether hands and loads push bodies no farther within a time step than contacts can follow.
//!
//! ```text
//! way in a step  x = ½ J Δt / m        angle  φ = ½ ΔH Δt / I_min        J, ΔH: impulses within a step
//! ```
//!
//! A body that is pushed by a good part of its size within a step is deep in what it meets before any contact
//! acts. A hand, which presses on contacts all the time, is held to the overlap that bodies may begin with.
//!
//! Not a limit of speeds: a weak force that acts for long may make a body as fast as it will.

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{Body, Guide, Link, Motion, World};
use glam::DVec3;

use crate::error::{FarPush, SimulationError};

/// Largest overlap allowed at the start \[m\].
pub(super) const START_OVERLAP: f64 = 1e-4;
/// Farthest way of a load in a step, over the bounding radius.
const WAY: f64 = 0.25;
/// Largest angle of a load in a step \[rad\].
const ANGLE: f64 = 1.0;

/// Refuses what pushes a body too far in a step \[s\].
///
/// # Errors
/// [`SimulationError::PushedTooFar`] with what pushes, how far, and the step that could follow it.
pub(super) fn refuse_far_pushes(world: &World, time_step: f64) -> Result<(), SimulationError> {
    for body in &world.bodies {
        if let Motion::Guided(Guide { press: Some(press), .. }) = body.motion {
            check(body, "hand", (press, "N"), (press * time_step, body.mass, START_OVERLAP), time_step)?;
        }
    }
    for link in &world.links {
        let Link::Load { body, force, torque, .. } = link else { continue };
        let Some(body) = world.bodies.get(body.index()) else { continue };
        if !body.motion.is_movable() {
            continue;
        }
        let in_step = |curve: &LoadCurve| {
            let from = curve.points().iter().flat_map(|(time, _)| [*time, time - time_step]);
            from.map(|from| curve.integral(from, from + time_step).length()).fold(0.0, f64::max)
        };
        let size =
            |points: &[(f64, DVec3)]| points.iter().map(|(_, value)| value.length()).fold(0.0, f64::max);
        let way = WAY * body.surface.bounding_radius();
        check(body, "force", (size(force.points()), "N"), (in_step(force), body.mass, way), time_step)?;
        let diagonal = body.inertia.to_cols_array_2d();
        let least = (0..3).map(|k| diagonal[k][k]).fold(f64::INFINITY, f64::min);
        check(body, "torque", (size(torque.points()), "N m"), (in_step(torque), least, ANGLE), time_step)?;
    }
    Ok(())
}

/// Refuses an impulse in a step on a mass that moves it beyond a way.
fn check(
    body: &Body,
    what: &'static str,
    (size, unit): (f64, &'static str),
    (impulse, mass, most): (f64, f64, f64),
    time_step: f64,
) -> Result<(), SimulationError> {
    let way = 0.5 * impulse * time_step / mass;
    if way <= most {
        return Ok(());
    }
    // The impulse of a step shrinks with the step.
    let longest = time_step * (most / way).sqrt();
    let way_unit = if unit == "N" { "m" } else { "rad" };
    let body = body.name.clone();
    Err(SimulationError::PushedTooFar(Box::new(FarPush {
        body,
        what,
        size,
        unit,
        way,
        way_unit,
        time_step,
        longest,
    })))
}
