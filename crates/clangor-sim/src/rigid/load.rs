//! Loads: forces and torques that act on bodies over time.
//!
//! `m Δv = ∫ F dt`, `ΔL = r × ∫ F dt + ∫ T dt` over each step, the integrals exact, r the arm at its middle.

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{BodyId, Link};
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::pair::Step;
use super::state::BodyState;
use super::step_log::{Impulse, StepLog};

/// A load of the world.
pub(super) struct Load {
    pub(super) body: usize,
    at: DVec3,
    force: LoadCurve,
    torque: LoadCurve,
}

impl Load {
    /// The load of a link, if it is one.
    pub(super) fn of_link(link: &Link) -> Option<Self> {
        let Link::Load { body, at, force, torque } = link else { return None };
        Some(Load { body: body.index(), at: *at, force: force.clone(), torque: torque.clone() })
    }

    /// Applies and logs the impulse of one step.
    pub(super) fn act(&self, bodies: &mut [BodyState], step: &Step, log: &mut StepLog) {
        let state = &mut bodies[self.body];
        let (start, end) = (step.time, step.time + step.length);
        let (impulse, couple) = (self.force.integral(start, end), self.torque.integral(start, end));
        if !state.is_awake() || (impulse == DVec3::ZERO && couple == DVec3::ZERO) {
            return;
        }
        let arm = state.mid_orientation * self.at;
        let row = ContactRow {
            time: step.time + 0.5 * step.length,
            body_a: BodyId(self.body as u32),
            body_b: BodyId::WORLD,
            kind: ContactKind::Constraint,
            point: state.mid_position + arm,
            normal: impulse.normalize_or_zero(),
            impulse_n: impulse.length(),
            impulse_t: DVec3::ZERO,
            couple,
            velocity: state.velocity,
            depth: 0.0,
            impact_id: 0,
        };
        state.kick(impulse, arm.cross(impulse) + couple);
        if log.skips_slower().is_none() {
            log.begin(ContactKind::Constraint);
            log.impulse(Impulse { row, arm_a: arm, arm_b: DVec3::ZERO });
            log.end();
        }
    }
}
