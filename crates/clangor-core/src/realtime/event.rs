//! What a live engine is told.

use glam::DVec3;

use super::sounding_object::SoundingObject;
use crate::pose::Pose;

/// Receivers at most.
pub const MOST_RECEIVERS: usize = 2;

/// No number in SI units is larger: far beyond, products overflow.
const LARGEST: f64 = 1e9;
/// Radii of spheres that click \[m\].
const RADII: std::ops::Range<f64> = 1e-6..1e3;
/// Durations of forces \[s\].
const DURATIONS: std::ops::Range<f64> = 1e-9..10.0;

/// Something that happens, or that somebody wants.
pub enum Event {
    /// A body is struck.
    ImpactEvent(ImpactEvent),
    /// An object is somewhere else.
    Pose {
        /// Which object.
        slot: usize,
        /// When \[s\].
        time: f64,
        /// Where then.
        pose: Pose,
        /// How it goes on [m/s].
        velocity: DVec3,
        /// How it turns on [rad/s].
        angular_velocity: DVec3,
    },
    /// An object is no more: it falls silent within a block; what it has sent arrives as ever.
    End {
        /// Which object.
        slot: usize,
        /// When \[s\].
        time: f64,
    },
    /// The receivers are somewhere else [m, world].
    Receivers([DVec3; MOST_RECEIVERS]),
    /// A part of the sound is to be heard, or not: of clicks those that come, of ringing and reflections at
    /// once; late reverberation dies away.
    Switch(Part, bool),
    /// All that sounds or is to sound stops, within a millisecond.
    Silence,
    /// An object takes a slot, or nothing does, when what happened before has been heard; what was there ends
    /// as by `End`, and goes back to the controller.
    Put {
        /// Which slot.
        slot: usize,
        /// What is there from now on.
        object: Option<Box<SoundingObject>>,
    },
}

/// A part of the sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// What comes of sudden acceleration.
    Acceleration,
    /// What comes of vibration.
    Modal,
    /// Reflections, early and late.
    Reflections,
}

/// What is struck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImpactTarget {
    /// A sphere that clicks.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// An object that was put somewhere.
    Object {
        /// Where.
        slot: usize,
    },
}

/// A body whose velocities change over a short time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactEvent {
    /// What is struck.
    pub struck: ImpactTarget,
    /// Onset of the force \[s\].
    pub time: f64,
    /// Duration τ of the force \[s\].
    pub duration: f64,
    /// Pose at the onset.
    pub pose: Pose,
    /// Σj/M [m/s], world.
    pub velocity_change: DVec3,
    /// Change of the angular velocity [rad/s], world.
    pub angular_velocity_change: DVec3,
    /// Where it is struck [m, world].
    pub point: DVec3,
    /// Impulse on it [N s], world: what its modes feel.
    pub impulse: DVec3,
}

impl ImpactEvent {
    /// Whether all numbers are such that sound can come of them.
    pub(super) fn is_good(&self) -> bool {
        let vectors = [self.velocity_change, self.angular_velocity_change, self.point, self.impulse];
        let sized = match self.struck {
            ImpactTarget::Sphere { radius } => RADII.contains(&radius),
            ImpactTarget::Object { .. } => true,
        };
        let good = vectors.into_iter().all(is_within_limits) && is_pose(&self.pose);
        good && sized && DURATIONS.contains(&self.duration)
    }
}

/// Whether a vector is one that anything can have.
pub(super) fn is_within_limits(vector: DVec3) -> bool {
    // Written so that NaN is refused too.
    vector.abs().max_element() < LARGEST && vector.is_finite()
}

/// Whether a pose is one.
pub(super) fn is_pose(pose: &Pose) -> bool {
    is_within_limits(pose.position) && (pose.orientation.length_squared() - 1.0).abs() < 1e-6
}
