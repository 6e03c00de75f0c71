//! Which approaches of a pair are impacts, and which are left to the contact phase.
//!
//! A body that gravity, springs, loads or hands press against another one approaches it anew in every step,
//! as fast as these accelerate it in one: that is rest, and no impact.

use super::pair::{ContactPoint, Pair, Step};
use super::state::BodyState;

/// Impacts of one pair in one step after which the contact phase takes over, so that a step ends.
pub(super) const MAX_HITS: u32 = 60;
/// Approach below which contact is resting contact \[m/s\].
const REST_SPEED: f64 = 0.02;
/// The same for a restitution of 1, where bodies never come to rest \[m/s\].
const REST_SPEED_ELASTIC: f64 = 1e-6;
/// Least ratio of the rest speed to the speed that gravity and pushes add in a step.
const REST_STEPS: f64 = 4.0;

/// Approach speed \[m/s\] below which a pair has no impacts.
pub(super) fn rest_speed(pair: &Pair, step: &Step, (a, b): (&BodyState, &BodyState)) -> f64 {
    if pair.coefficients.restitution.is_lossless() {
        return REST_SPEED_ELASTIC;
    }
    let pressed =
        |point: &ContactPoint| (b.pushed_at(point.arm_b) - a.pushed_at(point.arm_a)).dot(pair.normal);
    let pressed = pair.points.iter().map(pressed).fold(0.0, f64::max);
    REST_SPEED.max(REST_STEPS * (step.gravity.length() * step.length + pressed))
}

/// Upper bound on the relative acceleration of two contact points due to rotation \[m/s²\].
pub(super) fn bend(a: &BodyState, b: &BodyState) -> f64 {
    let one = |body: &BodyState| body.spin_speed() * body.angular_velocity.length();
    2.0 * (one(a) + one(b))
}
