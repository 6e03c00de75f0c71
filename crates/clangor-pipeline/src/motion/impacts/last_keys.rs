//! Whether a body that stops with its last key has hit something.
//!
//! glTF holds the last values of its curves, so that whatever moves up to its last key seems to stop there.
//! What flies or slides does not stop; what is set down or shut does. It has hit something if
//!
//! - impulses at the points that touch explain the whole stop, or
//! - the body is led (a door on its hinges, a lid in a hand), so that its bearings take a part of the stop,
//!   and what pushes it moves into the surface, within the cone of friction:
//!
//! ```text
//! Σ J |u_t| ≤ μ Σ J (−u_n)      u: velocities of the points that push with J, before the stop
//! ```
//!
//! A body is led where its last frames before the stop are no free flight.

use super::{Event, Scene};

/// Unexplained share of a stop up to which impulses explain it.
const EXPLAINED: f64 = 0.05;
/// The same of a body that is led: a rod on a hinge that stops at its end leaves a quarter.
const EXPLAINED_OF_LED: f64 = 0.5;
/// Jump of a frame, over that of gravity, from which a body is led.
const LED: f64 = 0.3;

impl Event {
    /// Whether it is what stops the body that began it, rather than the end of its keys.
    pub(super) fn is_stop(&self, scene: &Scene<'_>) -> bool {
        let is_led = || {
            let kinematics = scene.kinematics[self.members[0].body.index()].as_ref();
            kinematics.is_some_and(|kinematics| {
                let before = kinematics.jumps[kinematics.last_key.saturating_sub(1)];
                before.velocity.length() > LED * scene.world.gravity.length() * before.span
            })
        };
        self.residual <= EXPLAINED
            || self.residual <= EXPLAINED_OF_LED && is_led() && self.moves_into_surfaces()
    }

    fn moves_into_surfaces(&self) -> bool {
        let (mut into, mut across) = (0.0, 0.0);
        for ((contact, _), impulse) in self.points.iter().zip(&self.impulses) {
            let [a, b] = contact.bodies.map(|place| self.members[place].state.velocity_at(contact.point));
            let (push, normal) = (impulse.dot(contact.normal), (a - b).dot(contact.normal));
            into -= push * contact.friction * normal;
            across += push * (a - b - contact.normal * normal).length();
        }
        across < into
    }
}
