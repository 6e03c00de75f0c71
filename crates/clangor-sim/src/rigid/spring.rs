//! Linear springs between points of bodies that a step follows, as explicit forces at its middle; others are
//! solved implicitly (`stiff_spring`).
//!
//! `F = −(k (l − l₀) + c l̇) e` along the unit vector e from the far end. With the positions of the middle
//! this is the leapfrog rule, stable while `Δt √(k/m) < 2`, m the effective mass at the ends; it is used
//! up to 1.

use clangor_core::body::{BodyId, Link, LinkEnd};
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::pair::Step;
use super::state::BodyState;
use super::step_log::{Impulse, StepLog};
use super::stiff_spring::StiffSpring;

/// A spring of the world.
pub(super) struct Spring {
    body: usize,
    at: DVec3,
    to: LinkEnd,
    rest_length: f64,
    stiffness: f64,
    damping: f64,
}

impl Spring {
    /// The spring of a link, if it is one that steps of `step` \[s\] follow; `Err` has the body of one with a
    /// coefficient that is negative or not finite.
    pub(super) fn of_link(link: &Link, bodies: &[BodyState], step: f64) -> Result<Option<Self>, BodyId> {
        let &Link::Spring { body, at, to, rest_length, stiffness, damping } = link else { return Ok(None) };
        if ![rest_length, stiffness, damping].iter().all(|x| *x >= 0.0 && x.is_finite()) {
            return Err(body);
        }
        let stiff = StiffSpring::of_link(link, bodies, step).is_some();
        Ok((!stiff).then_some(Spring { body: body.index(), at, to, rest_length, stiffness, damping }))
    }

    /// Indices of the bodies at its ends.
    pub(super) fn ends(&self) -> impl Iterator<Item = usize> {
        [Some(self.body), self.to.body().map(BodyId::index)].into_iter().flatten()
    }

    /// Applies and logs the impulse of one step.
    pub(super) fn pull(&self, bodies: &mut [BodyState], step: &Step, log: &mut StepLog) {
        let point_of = |body: usize, at: DVec3| {
            let state = &bodies[body];
            let arm = state.mid_orientation * at;
            (state.mid_position + arm, state.velocity + state.angular_velocity.cross(arm), arm)
        };
        let (near, near_velocity, arm_a) = point_of(self.body, self.at);
        let (far, far_velocity, arm_b, far_id) = match self.to {
            LinkEnd::Point(point) => (point, DVec3::ZERO, DVec3::ZERO, BodyId::WORLD),
            LinkEnd::Body { body, at } => {
                let (point, velocity, arm) = point_of(body.index(), at);
                (point, velocity, arm, body)
            }
        };
        let between = near - far;
        let Some(along) = between.try_normalize() else { return };
        let velocity = near_velocity - far_velocity;
        let force =
            -(self.stiffness * (between.length() - self.rest_length) + self.damping * velocity.dot(along));
        let row = ContactRow {
            time: step.time + 0.5 * step.length,
            body_a: BodyId(self.body as u32),
            body_b: far_id,
            kind: ContactKind::Constraint,
            point: near,
            normal: along,
            impulse_n: force * step.length,
            impulse_t: DVec3::ZERO,
            couple: DVec3::ZERO,
            velocity,
            depth: 0.0,
            impact_id: 0,
        };
        let impulse = row.impulse();
        for (end, (impulse, arm)) in self.ends().zip([(impulse, arm_a), (-impulse, arm_b)]) {
            bodies[end].kick(impulse, arm.cross(impulse));
        }
        if log.skips_slower().is_none() {
            log.begin(ContactKind::Constraint);
            log.impulse(Impulse { row, arm_a, arm_b });
            log.end();
        }
    }
}
