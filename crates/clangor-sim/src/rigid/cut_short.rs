//! Impacts that end early, because a body breaks under them.
//!
//! ```text
//! f_i = ∫_{t_c}^{end} F_i dt / ∫ F_i dt        j_i → (1 − f_i) j_i
//! ```
//!
//! The dynamics has applied the whole impulse j_i of every contact point. Forces that act after the instant
//! t_c at which the body falls apart are taken back, from both bodies and from the log, so that momentum and
//! angular momentum stay in balance. What both bodies lose of their motion by that is the energy that the
//! contacts and the broken body stored at t_c, and had not yet returned.
//!
//! Differs: the bodies have flown with the whole impulse since the impact, for at most a step.

use std::collections::BTreeMap;

use clangor_core::body::BodyId;
use glam::DVec3;

use super::step_log::StepLog;
use super::world::RigidWorld;

/// Shares of the impulses of a step that do not act after all, with their places in
/// [`StepLog::impulses`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutShort {
    /// Place and share.
    pub shares: Vec<(usize, f64)>,
}

/// Changes of a momentum \[N s\] and an angular momentum about the centre of mass \[N m s\].
type Change = (DVec3, DVec3);

impl CutShort {
    /// What taking the shares back changes, by free body.
    fn changes(&self, rigid: &RigidWorld, log: &StepLog) -> BTreeMap<BodyId, Change> {
        let mut all: BTreeMap<BodyId, Change> = BTreeMap::new();
        for (place, share) in &self.shares {
            let Some(impulse) = log.impulses().get(*place) else { continue };
            let row = &impulse.row;
            let sides = [(row.body_a, impulse.arm_a, -share), (row.body_b, impulse.arm_b, *share)];
            for (body, arm, factor) in sides {
                if rigid.bodies.get(body.index()).is_some_and(|state| state.is_free()) {
                    let (momentum, angular) = all.entry(body).or_default();
                    *momentum += factor * row.impulse();
                    *angular += factor * (arm.cross(row.impulse()) + row.couple);
                }
            }
        }
        all
    }

    /// Kinetic energy \[J\] that the bodies lose.
    pub fn lost_motion(&self, rigid: &RigidWorld, log: &StepLog) -> f64 {
        let gain = |(body, (momentum, angular)): (&BodyId, &Change)| {
            rigid.bodies[body.index()].energy_gain(*momentum, *angular)
        };
        -self.changes(rigid, log).iter().map(gain).sum::<f64>()
    }

    /// Takes the shares back from the bodies and from the log.
    pub fn apply(&self, rigid: &mut RigidWorld, log: &mut StepLog) {
        for (body, (momentum, angular)) in self.changes(rigid, log) {
            rigid.bodies[body.index()].push(momentum, angular);
        }
        for (place, share) in &self.shares {
            log.scale(*place, 1.0 - share);
        }
    }
}
