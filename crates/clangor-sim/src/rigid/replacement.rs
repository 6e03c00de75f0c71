//! A body that breaks leaves the world, and its pieces enter it where they are.
//!
//! What decides that a body breaks, and into what, is not here: a run asks a [`Breaker`] after each step. The
//! parent has by then the velocity that the impacts of the step gave it, so that pieces that move as it did
//! keep its momentum and kinetic energy; what cracks add is in the velocities of the pieces too.
//!
//! No impulse is exchanged at the birth itself. Pieces touch, and the convex parts that stand for them may
//! even overlap: `pair` says how that is forgotten as they part.

use clangor_core::body::{Body, BodyId, Motion};
use clangor_core::timeline::FractureRow;
use glam::DVec3;

use super::pair::{Pair, Step};
use super::shape::Shape;
use super::sleep;
use super::state::BodyState;
use super::step_log::StepLog;
use super::world::RigidWorld;
use crate::SimulationError;

/// A body that breaks, and what becomes of it.
#[derive(Clone, Debug)]
pub struct Replacement {
    /// What is known of the fracture. `parent` breaks; time and pieces are filled in.
    pub row: FractureRow,
    /// The pieces at the end of the step, with the velocities that cracks gave them; their lives are filled
    /// in.
    pub pieces: Vec<Body>,
    /// The impulses of the cracks, which the velocities contain already.
    pub cracks: Vec<CrackImpulse>,
}

/// What the release of a crack does to the pieces at its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackImpulse {
    /// Place in [`Replacement::pieces`] of the piece on which the impulse acts as written.
    pub piece_a: usize,
    /// And of that on which the opposite acts.
    pub piece_b: usize,
    /// Where \[m\], world.
    pub point: DVec3,
    /// Unit normal of the crack, from B to A.
    pub normal: DVec3,
    /// Impulse on A \[N s\], world.
    pub impulse: DVec3,
    /// Couple impulse on A \[N m s\], world.
    pub couple: DVec3,
}

/// Looks at a step that has been taken, and says which bodies break. The log has the impacts of the step;
/// contacts slower than `v_min` are in it only if all rows are recorded.
pub type Breaker<'a> = &'a mut dyn FnMut(&RigidWorld, &StepLog) -> Result<Vec<Replacement>, SimulationError>;

impl RigidWorld {
    /// Lets `parent` die and its pieces be born, now. Whatever it touched wakes.
    ///
    /// # Errors
    /// [`SimulationError::CannotBreak`] for a body that is not free or not there, has a spring, or has no
    /// pieces; [`SimulationError::BadBody`] for a piece that cannot be simulated. Nothing has changed then.
    pub fn replace(&mut self, parent: BodyId, pieces: &[Body]) -> Result<Vec<BodyId>, SimulationError> {
        let broken = parent.index();
        let cannot = |reason| {
            let body = self.names.get(broken).map_or_else(|| format!("number {}", parent.0), String::clone);
            SimulationError::CannotBreak { body, reason, time: self.time() }
        };
        match self.bodies.get(broken) {
            None => return Err(cannot("is not there")),
            Some(body) if body.is_gone() => return Err(cannot("is broken already")),
            Some(body) if !body.is_free() => return Err(cannot("is not free")),
            Some(_) if pieces.is_empty() => return Err(cannot("has no pieces")),
            Some(_) if self.springs.iter().any(|spring| spring.ends().any(|end| end == broken)) => {
                return Err(cannot("is held by a spring"));
            }
            Some(_) => {}
        }
        let mut born = Vec::new();
        for (at, piece) in pieces.iter().enumerate() {
            let bad = |reason| SimulationError::BadBody { body: piece.name.clone(), reason };
            let earlier = pieces[..at].iter().map(|other| &other.name);
            if self.names.iter().chain(earlier).any(|name| *name == piece.name) {
                return Err(bad("has a name that another body has"));
            }
            if piece.motion != Motion::Free {
                return Err(bad("is a piece, but not free"));
            }
            if !(piece.velocity.is_finite() && piece.angular_velocity.is_finite()) {
                return Err(bad("has no finite velocity"));
            }
            let shape = Shape::try_new(&piece.surface).map_err(bad)?;
            let state = BodyState::try_new(piece, self.shapes.len() + at, shape.radius).map_err(bad)?;
            born.push((shape, state));
        }
        self.wake_around(broken);
        self.bodies[broken].vanish();
        let first = self.bodies.len() as u32;
        for (piece, (shape, state)) in pieces.iter().zip(born) {
            self.shapes.push(shape);
            self.bodies.push(state);
            self.names.push(piece.name.clone());
            self.materials.push(piece.material.clone());
            self.restless.push(false);
        }
        Ok((first..self.bodies.len() as u32).map(BodyId).collect())
    }

    /// Wakes a body and those that it touches.
    fn wake_around(&mut self, body: usize) {
        let now = Step { time: self.time(), length: self.time_step, gravity: self.gravity };
        let touches = |pair: &&Pair| pair.live && pair.ends().contains(&body);
        let touched: Vec<usize> = self.pairs.iter().filter(touches).flat_map(Pair::ends).collect();
        for other in touched.into_iter().chain([body]) {
            if self.bodies[other].asleep {
                sleep::wake(&mut self.bodies, other, &mut self.pairs, &self.neighbours, &now);
            }
        }
    }
}
