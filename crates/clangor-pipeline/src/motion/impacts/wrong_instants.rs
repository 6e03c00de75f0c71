//! Whether the instant of an event is a wrong one: a body is pushed off what it does not approach.
//!
//! A body that turns on a corner until the next one lands touches the floor all the time. At an instant that
//! is wrong by part of a frame, the next corner is still too far away to touch, and the old one, which does
//! not come nearer, explains the jump.

use super::Event;

/// Least approach of an impact on a body that nothing else moves, in the change of its velocity.
const APPROACH: f64 = 0.25;

impl Event {
    /// Whether one body is pushed off others that nothing moves, which it does not approach.
    pub(super) fn is_pushed_without_approach(&self) -> bool {
        let [first, others @ ..] = &self.members[..] else { return false };
        if others.iter().any(|other| other.fit.inverse_mass > 0.0 || other.is_led) {
            return false;
        }
        let jump = first.window.map_or(0.0, |window| window.velocity.length());
        let speeds = (1..self.members.len()).map(|place| self.approach([0, place]).speed);
        speeds.fold(0.0, f64::max) < APPROACH * jump
    }
}
