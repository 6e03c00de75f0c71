//! Loads: forces and torques that act on bodies over time.
//!
//! `m Δv = ∫ F dt`, `ΔL = r × ∫ F dt + ∫ T dt` over each step, the integrals exact, r the arm at its middle.

use clangor_core::body::Link;
use clangor_core::body::link::LoadCurve;
use glam::DVec3;

use super::pair::Step;
use super::state::BodyState;
use super::step_log::StepLog;

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

    /// Whether it acts after a time \[s\].
    pub(super) fn acts_after(&self, time: f64) -> bool {
        [&self.force, &self.torque]
            .iter()
            .any(|curve| curve.points().last().is_some_and(|last| last.0 > time))
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
        let (point, velocity) = (state.mid_position + arm, state.velocity);
        state.push_for_step(impulse, arm.cross(impulse) + couple);
        if log.skips_slower().is_none() {
            let ends = [(Some(self.body), arm), (None, DVec3::ZERO)];
            log.link(step.time + 0.5 * step.length, ends, (point, velocity), (impulse, couple));
        }
    }
}
