//! The motion of a body between two poses: constant velocity, for a limited time.

use glam::{DQuat, DVec3};

use crate::pose::Pose;

/// Time for which the last velocity is extrapolated \[s\].
const LONGEST_MOTION: f64 = 0.1;

/// Pose of a body at a time, and its velocities from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LivePose {
    /// The time \[samples\].
    pub sample: f64,
    /// The pose at that time.
    pub pose: Pose,
    /// Velocity [m/s].
    pub velocity: DVec3,
    /// Angular velocity [rad/s].
    pub angular_velocity: DVec3,
}

impl LivePose {
    /// A body at rest in a pose.
    pub fn at_rest(sample: f64, pose: Pose) -> Self {
        LivePose { sample, pose, velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO }
    }

    /// The pose at a sample, at this sample rate \[Hz\].
    pub(super) fn at(&self, sample: f64, rate: f64) -> Pose {
        let time = ((sample - self.sample) / rate).clamp(-LONGEST_MOTION, LONGEST_MOTION);
        Pose {
            position: self.pose.position + self.velocity * time,
            orientation: DQuat::from_scaled_axis(self.angular_velocity * time) * self.pose.orientation,
        }
    }
}
