//! Events of a real-time engine: impacts, motion of objects and receivers, and changes of what is rendered.

use std::sync::Arc;

use glam::DVec3;

use super::engine_settings::MOST_RECEIVERS;
use super::sounding_object::SoundingObject;
use crate::contact::{ForceHistory, ForceShape, ImpactPulse};
use crate::pose::Pose;

/// Bound of the components of vectors, in SI units: far beyond it, products overflow.
pub const LARGEST: f64 = 1e9;
/// Radii of spheres \[m\].
pub const RADII: std::ops::Range<f64> = 1e-6..1e3;
/// Durations of forces \[s\].
pub const DURATIONS: std::ops::Range<f64> = 1e-9..10.0;

/// An event in the world, or a change of what is rendered.
pub enum Event {
    /// An impact on a body.
    Impact(ImpactEvent),
    /// Motion of an object from a time on.
    Pose {
        /// Slot of the object.
        slot: usize,
        /// Time \[s\].
        time: f64,
        /// Pose at that time.
        pose: Pose,
        /// Velocity from then on [m/s].
        velocity: DVec3,
        /// Angular velocity from then on [rad/s].
        angular_velocity: DVec3,
    },
    /// End of an object: it fades out within a block. Sound on its path to the receivers still arrives.
    End {
        /// Slot of the object.
        slot: usize,
        /// Time \[s\].
        time: f64,
    },
    /// New positions of the receivers [m, world].
    Receivers([DVec3; MOST_RECEIVERS]),
    /// Switches a part of the sound on or off: acceleration pulses from the next impact on, modes and
    /// reflections at once. Late reverberation decays.
    Switch(Part, bool),
    /// Silences the engine within a millisecond and drops all impacts to come.
    Silence,
    /// Puts an object into a slot, or empties it, after the events sent before. The previous object ends as
    /// by `End` and is returned to the controller.
    Put {
        /// The slot.
        slot: usize,
        /// Its content from now on.
        object: Option<Box<SoundingObject>>,
    },
}

/// A part of the sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Acceleration noise.
    Acceleration,
    /// Sound of vibration modes.
    Modal,
    /// Reflections, early and late.
    Reflections,
}

/// The body that an impact acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImpactTarget {
    /// A sphere without modes.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// An object in a slot.
    Object {
        /// The slot.
        slot: usize,
    },
}

/// An impact on a body: its velocities change over a short time.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactEvent {
    /// The body.
    pub target: ImpactTarget,
    /// Onset of the force \[s\].
    pub time: f64,
    /// Duration τ of the force \[s\].
    pub duration: f64,
    /// The force over time; `None` for the engine's profile.
    pub force: Option<Arc<ForceHistory>>,
    /// Pose of the body at the onset.
    pub pose: Pose,
    /// Change of the velocity, Σj/M [m/s], world.
    pub velocity_change: DVec3,
    /// Change of the angular velocity [rad/s], world.
    pub angular_velocity_change: DVec3,
    /// Point of the impact [m, world].
    pub point: DVec3,
    /// Impulse on the body at the point [N s], world. It excites the modes.
    pub impulse: DVec3,
}

impl From<ImpactEvent> for Event {
    fn from(impact: ImpactEvent) -> Self {
        Event::Impact(impact)
    }
}

impl Event {
    /// Time of a timed event \[s\], NaN if it has numbers out of range; `None` for events that act at once.
    pub(super) fn time(&self) -> Option<f64> {
        match self {
            Event::Impact(impact) => Some(if impact.is_within_limits() { impact.time } else { f64::NAN }),
            Event::Pose { time, pose, velocity, angular_velocity, .. } => {
                let good =
                    is_pose(pose) && is_within_limits(*velocity) && is_within_limits(*angular_velocity);
                Some(if good { *time } else { f64::NAN })
            }
            Event::End { time, .. } => Some(*time),
            _ => None,
        }
    }
}

impl ImpactEvent {
    /// An impact on a body at the origin, with a force from `time` \[s\] on over `duration` \[s\], without
    /// any change of velocity or impulse yet.
    pub fn new(target: ImpactTarget, time: f64, duration: f64) -> Self {
        ImpactEvent {
            target,
            time,
            duration,
            force: None,
            pose: Pose::IDENTITY,
            velocity_change: DVec3::ZERO,
            angular_velocity_change: DVec3::ZERO,
            point: DVec3::ZERO,
            impulse: DVec3::ZERO,
        }
    }

    /// The events of an impact on one of its sides: A is 0 and B is 1.
    ///
    /// There is one event for each contact point, with the force on the modes there. The first one also has
    /// the changes of the velocities. A sphere has only the first; a body that contacts neither move nor set
    /// into vibration has none.
    /// All have the history of the pulse; a closed profile of the pulse is left to the engine.
    pub fn of_side(
        target: ImpactTarget,
        pulse: &ImpactPulse,
        side: usize,
    ) -> impl Iterator<Item = ImpactEvent> {
        let share = pulse.bodies.get(side).copied().flatten();
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let most = match target {
            ImpactTarget::Sphere { .. } => 1,
            ImpactTarget::Object { .. } => usize::MAX,
        };
        share.into_iter().flat_map(move |share| {
            let still = ImpactEvent::new(target, pulse.onset, pulse.duration)
                .with_pose(share.pose)
                .with_shape(&pulse.shape);
            pulse.points.iter().take(most).enumerate().map(move |(index, (point, impulse))| {
                let event = still.clone().with_impulse(*point, sign * share.modal_gain * *impulse);
                match index {
                    0 => event.with_velocity_changes(share.velocity_change, share.angular_velocity_change),
                    _ => event,
                }
            })
        })
    }

    /// Replaces the pose of the body by a position of its centre of mass [m, world] without rotation.
    #[must_use]
    pub fn at(self, centre: DVec3) -> Self {
        self.with_pose(Pose::at(centre))
    }

    /// Replaces the pose of the body at the onset.
    #[must_use]
    pub fn with_pose(self, pose: Pose) -> Self {
        ImpactEvent { pose, ..self }
    }

    /// Replaces the force over time: a history, or the engine's profile for any closed profile.
    #[must_use]
    pub fn with_shape(self, shape: &ForceShape) -> Self {
        let force = match shape {
            ForceShape::History(history) => Some(Arc::clone(history)),
            ForceShape::Profile(_) => None,
        };
        ImpactEvent { force, ..self }
    }

    /// Replaces the change of the velocity [m/s, world].
    #[must_use]
    pub fn with_velocity_change(self, velocity_change: DVec3) -> Self {
        ImpactEvent { velocity_change, ..self }
    }

    /// Replaces the changes of the velocity [m/s, world] and of the angular velocity [rad/s, world].
    #[must_use]
    pub fn with_velocity_changes(self, velocity_change: DVec3, angular_velocity_change: DVec3) -> Self {
        ImpactEvent { velocity_change, angular_velocity_change, ..self }
    }

    /// Replaces the point of the impact [m, world] and the impulse there [N s, world], which excites modes.
    #[must_use]
    pub fn with_impulse(self, point: DVec3, impulse: DVec3) -> Self {
        ImpactEvent { point, impulse, ..self }
    }

    /// Whether all numbers are finite and in range.
    pub(super) fn is_within_limits(&self) -> bool {
        let vectors = [self.velocity_change, self.angular_velocity_change, self.point, self.impulse];
        let sized = match self.target {
            ImpactTarget::Sphere { radius } => RADII.contains(&radius),
            ImpactTarget::Object { .. } => true,
        };
        let good = vectors.into_iter().all(is_within_limits) && is_pose(&self.pose);
        let lasting = self.force.as_deref().is_none_or(is_lasting);
        good && sized && lasting && DURATIONS.contains(&self.duration)
    }
}

/// Whether a history begins near its onset, and has a duration within limits.
fn is_lasting(history: &ForceHistory) -> bool {
    let (begin, end) = history.extent();
    begin.abs() < DURATIONS.end && DURATIONS.contains(&(end - begin))
}

/// Whether a vector is finite and its components are below 1e9.
pub(super) fn is_within_limits(vector: DVec3) -> bool {
    // Written so that NaN is rejected too.
    vector.abs().max_element() < LARGEST && vector.is_finite()
}

/// Whether a pose has a position within limits and a unit quaternion.
fn is_pose(pose: &Pose) -> bool {
    is_within_limits(pose.position) && (pose.orientation.length_squared() - 1.0).abs() < 1e-6
}
