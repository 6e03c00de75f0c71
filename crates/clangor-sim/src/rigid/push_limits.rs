//! Whether hands and loads push bodies no farther within a time step than contacts can follow.
//!
//! ```text
//! moved in a step  x = ½ J Δt / m        angle  φ = ½ |I⁻¹ ΔH| Δt        J, ΔH: impulses within a step
//! ```
//!
//! The inertia I is that of the pose at the start.
//!
//! A body that is pushed by a good part of its size within a step is deep in what it meets before any contact
//! acts. A hand, which presses on contacts all the time, is held to the overlap that bodies may begin with.
//!
//! Not a limit of speeds: a weak force that acts for long may make a body as fast as it will.

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{Body, Guide, Link, Motion, World};
use glam::{DMat3, DVec3};

use crate::error::{FarPush, SimulationError};

/// Largest overlap allowed at the start \[m\].
pub(super) const START_OVERLAP: f64 = 1e-4;
/// Largest displacement by a load in a step, over the bounding radius.
const DISPLACEMENT: f64 = 0.25;
/// Largest angle of a load in a step \[rad\].
const ANGLE: f64 = 1.0;
/// Halvings of the range of steps.
const HALVINGS: usize = 50;

/// Refuses what pushes a body too far in a step \[s\].
///
/// # Errors
/// [`SimulationError::PushedTooFar`] with what pushes, how far, and the step that could follow it.
pub(super) fn refuse_far_pushes(world: &World, time_step: f64) -> Result<(), SimulationError> {
    for body in &world.bodies {
        if let Motion::Guided(Guide { press: Some(press), .. }) = body.motion {
            let displacement = |step: f64| 0.5 * press * step * step / body.mass;
            check(body, ("hand", press, "N"), (&displacement, START_OVERLAP), time_step)?;
        }
    }
    for link in &world.links {
        let Link::Load { body, force, torque, .. } = link else { continue };
        let Some(body) = world.bodies.get(body.index()) else { continue };
        if !body.motion.is_movable() {
            continue;
        }
        // The largest impulse within a step, as `measure` has it.
        let in_step = |curve: &LoadCurve, step: f64, measure: &dyn Fn(DVec3) -> f64| {
            let from = curve.points().iter().flat_map(|(time, _)| [*time, time - 0.5 * step, time - step]);
            from.map(|from| measure(curve.integral(from, from + step))).fold(0.0, f64::max)
        };
        let size =
            |points: &[(f64, DVec3)]| points.iter().map(|(_, value)| value.length()).fold(0.0, f64::max);
        let farthest = DISPLACEMENT * body.surface.bounding_radius();
        let displacement =
            |step: f64| 0.5 * step * in_step(force, step, &|impulse| impulse.length()) / body.mass;
        check(body, ("force", size(force.points()), "N"), (&displacement, farthest), time_step)?;
        let turn = DMat3::from_quat(body.pose.orientation);
        let answer = turn * body.inertia.inverse() * turn.transpose();
        let angle = |step: f64| 0.5 * step * in_step(torque, step, &|momentum| (answer * momentum).length());
        check(body, ("torque", size(torque.points()), "N m"), (&angle, ANGLE), time_step)?;
    }
    Ok(())
}

/// Refuses what moves a body within a step farther than `most`: `moved_in` is the displacement, or the angle,
/// in a step of a length \[s\].
fn check(
    body: &Body,
    (what, size, unit): (&'static str, f64, &'static str),
    (moved_in, most): (&dyn Fn(f64) -> f64, f64),
    time_step: f64,
) -> Result<(), SimulationError> {
    let moved = moved_in(time_step);
    // A body without a finite mass does not move.
    if moved <= most || !moved.is_finite() {
        return Ok(());
    }
    // The longest step that would do, by halving: the displacement grows with the step.
    let (mut longest, mut too_long) = (0.0, time_step);
    for _ in 0..HALVINGS {
        let step = 0.5 * (longest + too_long);
        *(if moved_in(step) <= most { &mut longest } else { &mut too_long }) = step;
    }
    let moved_unit = if unit == "N" { "m" } else { "rad" };
    let body = body.name.clone();
    Err(SimulationError::PushedTooFar(Box::new(FarPush {
        body,
        what,
        size,
        unit,
        moved,
        moved_unit,
        time_step,
        longest,
    })))
}
