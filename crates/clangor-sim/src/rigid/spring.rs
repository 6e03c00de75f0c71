//! Linear springs between centres of mass, as explicit forces at the middle of the step.
//!
//! `F = −(k (l − l₀) + c l̇) e` along the unit vector e from the far end. With the positions of the middle
//! this is the leapfrog rule, stable while `Δt √(k/m) < 2`.

use clangor_core::body::{BodyId, Link, SpringEnd};
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::pair::Step;
use super::state::BodyState;
use super::step_log::{Impulse, StepLog};

/// A spring of the world.
pub(super) struct Spring {
    body: usize,
    to: SpringEnd,
    rest_length: f64,
    stiffness: f64,
    damping: f64,
}

impl Spring {
    /// A spring; `Err` states what is not supported, and the body.
    pub(super) fn try_new(
        link: &Link,
        bodies: &[BodyState],
        step: f64,
    ) -> Result<Self, (&'static str, BodyId)> {
        let Link::Spring { body, to, rest_length, stiffness, damping } = link else {
            let Link::Hang { body, .. } = link else { return Err(("link of this kind", BodyId(0))) };
            return Err(("rods", *body));
        };
        let far = match to {
            SpringEnd::Body(other) => Some(*other),
            SpringEnd::Point(_) => None,
        };
        let inverse_mass: f64 = [Some(*body), far]
            .into_iter()
            .flatten()
            .filter_map(|id| bodies.get(id.index()))
            .map(BodyState::inverse_mass)
            .sum();
        if [Some(*body), far].into_iter().flatten().any(|id| id.index() >= bodies.len()) {
            return Err(("springs without a body", *body));
        }
        let finite = [rest_length, stiffness, damping].iter().all(|x| x.is_finite());
        if !finite || stiffness * inverse_mass * step * step > 1.0 || damping * inverse_mass * step > 1.0 {
            return Err(("springs so stiff at this time step", *body));
        }
        let (rest_length, stiffness, damping) = (*rest_length, *stiffness, *damping);
        Ok(Spring { body: body.index(), to: *to, rest_length, stiffness, damping })
    }

    /// Indices of the bodies at its ends.
    pub(super) fn ends(&self) -> impl Iterator<Item = usize> {
        let far = match self.to {
            SpringEnd::Body(other) => Some(other.index()),
            SpringEnd::Point(_) => None,
        };
        [Some(self.body), far].into_iter().flatten()
    }

    /// Applies and logs the impulse of one step.
    pub(super) fn pull(&self, bodies: &mut [BodyState], step: &Step, log: &mut StepLog) {
        let near = &bodies[self.body];
        let (far, far_velocity, far_id) = match self.to {
            SpringEnd::Point(point) => (point, DVec3::ZERO, BodyId::WORLD),
            SpringEnd::Body(id) => (bodies[id.index()].mid_position, bodies[id.index()].velocity, id),
        };
        let between = near.mid_position - far;
        let Some(along) = between.try_normalize() else { return };
        let velocity = near.velocity - far_velocity;
        let force =
            -(self.stiffness * (between.length() - self.rest_length) + self.damping * velocity.dot(along));
        let row = ContactRow {
            time: step.time + 0.5 * step.length,
            body_a: BodyId(self.body as u32),
            body_b: far_id,
            kind: ContactKind::Constraint,
            point: near.mid_position,
            normal: along,
            impulse_n: force * step.length,
            impulse_t: DVec3::ZERO,
            couple: DVec3::ZERO,
            velocity,
            depth: 0.0,
            impact_id: 0,
        };
        let impulse = row.impulse();
        for (i, impulse) in self.ends().zip([impulse, -impulse]) {
            let inverse_mass = bodies[i].inverse_mass();
            bodies[i].velocity += impulse * inverse_mass;
        }
        if log.skips_slower().is_none() {
            log.begin(ContactKind::Constraint);
            log.impulse(Impulse { row, arm_a: DVec3::ZERO, arm_b: DVec3::ZERO });
            log.end();
        }
    }
}
