//! Which approaches of a pair are impacts, and which are left to the contact phase.

use clangor_core::material::PairRestitution;

use super::pair::Step;
use super::state::BodyState;

/// Impacts of one pair in one step after which the contact phase takes over, so that a step ends.
pub(super) const MAX_HITS: u32 = 60;
/// Approach below which contact is resting contact \[m/s\].
const REST_SPEED: f64 = 0.02;
/// The same for a restitution of 1, where bodies never come to rest \[m/s\].
const REST_SPEED_ELASTIC: f64 = 1e-6;
/// Least ratio of the rest speed to the speed that gravity adds in a step.
const REST_STEPS: f64 = 4.0;

/// Approach speed \[m/s\] below which a pair has no impacts.
pub(super) fn rest_speed(restitution: &PairRestitution, step: &Step) -> f64 {
    if restitution.is_lossless() {
        return REST_SPEED_ELASTIC;
    }
    REST_SPEED.max(REST_STEPS * step.gravity.length() * step.length)
}

/// Upper bound on the relative acceleration of two contact points due to rotation \[m/s²\].
pub(super) fn bend(a: &BodyState, b: &BodyState) -> f64 {
    let one = |body: &BodyState| body.spin_speed() * body.angular_velocity.length();
    2.0 * (one(a) + one(b))
}
