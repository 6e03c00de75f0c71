//! Checks of the numbers that a caller gives to a live world.

use glam::DVec3;

use super::error::LiveError;
use super::limits::{FARTHEST, FASTEST};

pub(super) fn check(
    what: &'static str,
    value: f64,
    within: [f64; 2],
    range: &'static str,
) -> Result<(), LiveError> {
    // This form also rejects NaN.
    if value >= within[0] && value <= within[1] {
        return Ok(());
    }
    Err(LiveError::BadNumber { what, value, range })
}

pub(super) fn check_placed(position: DVec3, velocity: DVec3) -> Result<(), LiveError> {
    check("the distance from the origin", position.length(), [0.0, FARTHEST], "at most 1e5 m")?;
    check("the speed", velocity.length(), [0.0, FASTEST], "at most 200 m/s")
}

pub(super) fn check_gravity(gravity: DVec3) -> Result<(), LiveError> {
    check("gravity", gravity.length(), [0.0, 1000.0], "at most 1000 m/s²")
}
