//! Replaces a body that breaks by its pieces.
//!
//! A [`Breaker`], called after each step, decides which bodies break and into which pieces. The parent then
//! already has the velocity after the impacts of the step. Pieces that move as the parent did keep its
//! momentum and kinetic energy; impulses of cracks are included in the velocities of the pieces.
//!
//! The replacement itself exchanges no impulse. Pieces touch, and their convex parts may overlap: `pair`
//! describes how that overlap is tolerated until the pieces part.

use clangor_core::body::{Body, BodyId, Motion};
use clangor_core::timeline::FractureRow;
use glam::DVec3;

use super::compliance::BodySide;
use super::pair::{Pair, Step};
use super::shape::Shape;
use super::sleep;
use super::state::BodyState;
use super::step_log::StepLog;
use super::world::RigidWorld;
use crate::SimulationError;

/// A body that breaks, and its pieces.
#[derive(Clone, Debug)]
pub struct Replacement {
    /// The fracture. `parent` breaks; the run fills in the time and the ids of the pieces.
    pub row: FractureRow,
    /// The pieces at the end of the step, with their velocities after the cracks; the run fills in their
    /// lives.
    pub pieces: Vec<Body>,
    /// The impulses of the cracks, already included in the velocities.
    pub cracks: Vec<CrackImpulse>,
}

/// Impulse of a released crack on the pieces at its two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackImpulse {
    /// Piece A: index in [`Replacement::pieces`].
    pub piece_a: usize,
    /// Piece B, on which the opposite impulse acts: index in [`Replacement::pieces`].
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

/// Inspects a completed step and returns the bodies that break. The log contains the impacts of the step, and
/// contacts slower than `v_min` only if all rows are recorded.
pub type Breaker<'a> =
    &'a mut dyn FnMut(&mut RigidWorld, &mut StepLog) -> Result<Vec<Replacement>, SimulationError>;

impl RigidWorld {
    /// Replaces `parent` by its pieces at the present time and wakes the bodies that it touched.
    ///
    /// # Errors
    /// [`SimulationError::CannotBreak`] for a body that is not free or does not exist, has a spring, a joint
    /// or a force, or has no pieces; [`SimulationError::BadBody`] for a piece that cannot be simulated. The
    /// world is unchanged after an error.
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
            Some(_) if self.linkages.of(broken).is_some() => {
                return Err(cannot("is held by a joint or a stiff spring"));
            }
            Some(_) if self.loads.iter().any(|load| load.body == broken && load.acts_after(self.time())) => {
                return Err(cannot("is moved by a force"));
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
        self.compliant.remove(parent);
        let first = self.bodies.len() as u32;
        for (piece, (shape, state)) in pieces.iter().zip(born) {
            self.sides.push(BodySide::new(BodyId(self.bodies.len() as u32), piece));
            self.shapes.push(shape);
            self.bodies.push(state);
            self.names.push(piece.name.clone());
            self.materials.push(piece.material.clone());
            self.restless.push(false);
        }
        Ok((first..self.bodies.len() as u32).map(BodyId).collect())
    }

    /// Wakes a body and the bodies that it touches.
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
