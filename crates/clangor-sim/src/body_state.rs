//! Pose and velocities of a body at one instant.

use clangor_core::pose::Pose;
use glam::DVec3;

/// State of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Position of the centre of mass and orientation.
    pub pose: Pose,
    /// Velocity of the centre of mass \[m/s\].
    pub velocity: DVec3,
    /// Angular velocity \[rad/s\], world.
    pub angular_velocity: DVec3,
}
