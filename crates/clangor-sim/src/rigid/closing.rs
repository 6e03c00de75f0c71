//! Closes joints at the middle of the next step.
//!
//! Impulses along the present rows, by Newton's method, such that the joints are exact where bodies will be
//! after a step. This is SHAKE (Ryckaert, Ciccotti and Berendsen 1977) on the midpoints, which is symplectic:
//! the energy of a pendulum oscillates by (ω Δt)² and does not drift. Ropes that would be too long join the
//! rows, and leave them when they would push.

use clangor_core::pose::Pose;

use super::joint::Blocked;
use super::linkage::Linkages;
use super::mover::Mover;
use super::reactions::Reactions;

/// Joints that are closer than this are closed \[m, or rad\].
const CLOSED: f64 = 1e-13;
/// Joints that are farther off cannot be closed: bodies too unequal for the step, or keyframes that pull them
/// apart \[m, or rad\].
const OPEN: f64 = 1e-5;
/// Rounds of Newton's method at most. Seen: 3 for single joints, 20 for chains of ropes that become taut.
const MOST_ROUNDS: u32 = 60;

/// The pose of a body a step later with the velocities of a mover.
pub(super) type Next<'a> = dyn Fn(usize, &Mover) -> Pose + 'a;

impl Reactions {
    /// Closes the joints of a linkage at the poses that `next` gives, `duration` \[s\] later; the movers are
    /// the bodies. `Err` has a joint that cannot be closed, and by how much it is open \[m, or rad\].
    pub(super) fn settle(
        &mut self,
        linkages: &Linkages,
        movers: &mut [Mover],
        slot: usize,
        (duration, next): (f64, &Next<'_>),
    ) -> Result<(), (usize, f64)> {
        let (mut open, mut least) = ((0, f64::INFINITY), (0, f64::INFINITY));
        for round in 0..MOST_ROUNDS {
            let errors = self.errors(linkages, movers, slot, next);
            let changed = self.choose_ropes(slot, (&errors, duration), movers);
            if changed || round == 0 {
                self.factorize(slot, movers);
            }
            open = self.most_open(slot, &errors);
            if open.1 < least.1 {
                least = open;
            }
            if open.1 < CLOSED && !changed {
                break;
            }
            let wanted: Vec<f64> = errors.iter().map(|error| -error / duration).collect();
            let impulses = self.solve(slot, &wanted);
            for (row, impulse) in self.rows_of(slot).iter_mut().zip(impulses) {
                row.push(movers, impulse);
            }
        }
        if open.1 >= OPEN || open.1.is_nan() {
            return Err(least);
        }
        Ok(())
    }

    /// Which ropes pull: those that would be too long, and those that pull already. What pushes is taken
    /// back. Returns whether others pull than before.
    fn choose_ropes(&mut self, slot: usize, (errors, duration): (&[f64], f64), movers: &mut [Mover]) -> bool {
        let mut changed = false;
        for (row, error) in self.rows_of(slot).iter_mut().zip(errors) {
            let Some(mut rope) = row.rope else { continue };
            if row.impulse > 0.0 {
                row.push(movers, -row.impulse);
            }
            rope.limit = row.rate(movers) - error / duration;
            let pulls = *error > 0.0 || row.impulse < 0.0;
            changed |= pulls != rope.pulls;
            rope.pulls = pulls;
            row.rope = Some(rope);
        }
        changed
    }

    /// The joint of the largest error among the rows that react.
    fn most_open(&mut self, slot: usize, errors: &[f64]) -> (usize, f64) {
        let mut open = (0, 0.0);
        for (row, error) in self.rows_of(slot).iter().zip(errors) {
            if row.reacts() && (error.abs() > open.1 || error.is_nan()) {
                open = (row.joint, error.abs());
            }
        }
        open
    }

    /// How far the joints of a linkage are off at the poses that `next` gives, row by row, and its springs
    /// off their law.
    fn errors(&mut self, linkages: &Linkages, movers: &[Mover], slot: usize, next: &Next<'_>) -> Vec<f64> {
        let rows = self.rows_of(slot);
        let mut errors = Vec::with_capacity(rows.len());
        for same in rows.chunk_by(|a, b| a.joint == b.joint) {
            let joint = &linkages.joints[same[0].joint];
            let blocked: Vec<Blocked> = same.iter().map(|row| row.blocked).collect();
            let placed = joint.placed(&|body| next(body, &movers[body]));
            let off = joint.errors(&placed, &blocked).into_iter().zip(same);
            errors.extend(off.map(|(error, row)| match row.give {
                Some(give) => give.residual(error, row.impulse),
                None => error,
            }));
        }
        errors
    }
}
