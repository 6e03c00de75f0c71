//! Which approaches of a pair are impacts, and which are left to the contact phase.

use super::pair::Step;
use super::state::BodyState;

/// Impacts of one pair in one step after which the contact phase takes over, so that a step ends.
pub(super) const MAX_HITS: u32 = 60;
/// Approach below which contact is resting contact \[m/s\].
const REST_SPEED: f64 = 0.02;
/// The same, where restitution is 1 and nothing ever rests.
const REST_SPEED_ELASTIC: f64 = 1e-6;
/// It is never below this many times the speed that gravity gives in a step.
const REST_STEPS: f64 = 4.0;

/// Approach speed \[m/s\] below which a pair has no impacts.
pub(super) fn rest_speed(restitution: f64, step: &Step) -> f64 {
    if restitution >= 1.0 {
        return REST_SPEED_ELASTIC;
    }
    REST_SPEED.max(REST_STEPS * step.gravity.length() * step.length)
}

/// Bound on the relative acceleration of two contact points due to rotation \[m/s²\], and a bit more.
pub(super) fn bend(a: &BodyState, b: &BodyState) -> f64 {
    let one = |body: &BodyState| body.spin_speed() * body.angular_velocity.length();
    2.0 * (one(a) + one(b))
}
