//! Changes of a live world at its present instant: velocities, added and removed balls, gravity.

use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::material::Material;
use glam::{DMat3, DVec3};

use super::check::{check, check_gravity, check_placed};
use super::error::LiveError;
use super::limits::{MOST_BODIES, RADII};
use super::world::{ActiveSolver, LiveWorld, is_there};

/// Overlap of a new ball, relative to the smaller radius, that counts as rounding error.
const TOLERATED_OVERLAP: f64 = 1e-6;

impl LiveWorld {
    /// Sets the velocity of a ball's centre \[m/s\]; its spin stays.
    ///
    /// # Errors
    /// [`LiveError`] for a body that is not a free ball, or a velocity that is not finite or beyond
    /// [`FASTEST`](super::FASTEST).
    pub fn set_velocity(&mut self, body: BodyId, velocity: DVec3) -> Result<(), LiveError> {
        check_placed(DVec3::ZERO, velocity)?;
        let known = self.body(body).ok_or(LiveError::UnknownBody { body: body.0 })?;
        if known.motion != Motion::Free {
            return Err(LiveError::NotFree { body: known.name.clone() });
        }
        if let ActiveSolver::Stepped(stepped) = &mut self.motion {
            stepped.set_velocity(body, velocity);
            return Ok(());
        }
        self.release_state(self.solver())?;
        self.world.bodies[body.index()].velocity = velocity;
        Ok(())
    }

    /// Adds a free ball. Returns its index, which may be that of a removed ball.
    ///
    /// # Errors
    /// [`LiveError`] for numbers out of range, an overlap with another body, or too many bodies.
    pub fn add(
        &mut self,
        material: &Material,
        radius: f64,
        position: DVec3,
        velocity: DVec3,
    ) -> Result<BodyId, LiveError> {
        check("the radius", radius, RADII, "from 1e-4 m to 100 m")?;
        check_placed(position, velocity)?;
        let states = self.states();
        for (other, state) in self.world.bodies.iter().zip(&states).filter(|(other, _)| is_there(other)) {
            let (gap, smaller) = match *other.surface {
                Surface::Sphere { radius: theirs } => {
                    (position.distance(state.pose.position) - radius - theirs, radius.min(theirs))
                }
                Surface::HalfSpace | Surface::Plate { .. } => {
                    (state.pose.body_from_world(position).y - radius, radius)
                }
                Surface::Mesh(_) => continue,
            };
            if gap < -TOLERATED_OVERLAP * smaller {
                return Err(LiveError::Overlap { body: other.name.clone(), depth: -gap });
            }
        }
        let place = self.world.bodies.iter().position(|body| !is_there(body));
        let place = place.unwrap_or(self.world.bodies.len());
        if place >= MOST_BODIES {
            return Err(LiveError::Full);
        }
        if !matches!(self.motion, ActiveSolver::Stepped(_)) {
            self.release_state(self.solver())?;
        }
        let mass = material.density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let inertia = DMat3::from_diagonal(DVec3::splat(0.4 * mass * radius * radius));
        let surface = Surface::Sphere { radius };
        let name = format!("{} ball {}", material.name, place + 1);
        let body =
            Body::new(name, material.clone(), surface, mass, inertia).at(position).with_velocity(velocity);
        match self.world.bodies.get_mut(place) {
            Some(slot) => *slot = body,
            None => self.world.bodies.push(body),
        }
        let id = BodyId(place as u32);
        if let ActiveSolver::Stepped(stepped) = &mut self.motion {
            stepped.add(&self.world, id);
        }
        Ok(id)
    }

    /// Removes a ball and its rods and springs.
    ///
    /// # Errors
    /// [`LiveError`] for a body that is not a free ball.
    pub fn remove(&mut self, body: BodyId) -> Result<(), LiveError> {
        let known = self.body(body).ok_or(LiveError::UnknownBody { body: body.0 })?;
        if known.motion != Motion::Free {
            return Err(LiveError::NotFree { body: known.name.clone() });
        }
        match &mut self.motion {
            ActiveSolver::Stepped(stepped) => {
                self.impacts.close(&self.world.bodies, f64::INFINITY, self.origin)?;
                stepped.remove(body);
            }
            _ => self.release_state(self.solver())?,
        }
        self.world.bodies[body.index()].life.death = f64::NEG_INFINITY;
        self.world.links.retain(|link| link.bodies().all(|end| end != body));
        Ok(())
    }

    /// Changes gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LiveError`] for an acceleration that is not finite or beyond 1000 m/s².
    pub fn set_gravity(&mut self, gravity: DVec3) -> Result<(), LiveError> {
        check_gravity(gravity)?;
        match &mut self.motion {
            ActiveSolver::Stepped(stepped) => stepped.set_gravity(gravity),
            _ => self.release_state(self.solver())?,
        }
        self.world.gravity = gravity;
        Ok(())
    }
}
