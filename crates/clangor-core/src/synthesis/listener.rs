//! Listeners: places of the receivers over time, arrival of wavefronts, and reflection in the floor.

use glam::{DQuat, DVec3};

use super::SynthesisError;
use crate::pose::{Keyframe, Pose, Track};
pub use crate::propagation::Floor;
use crate::propagation::ImageSource;

/// A group of receivers that move together. Each receiver is a channel and measures pressure, with equal
/// sensitivity in all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Listener {
    /// Name, for messages and files.
    pub name: String,
    /// Motion of the group over time.
    pub track: Track,
    /// Receivers \[m\] in the frame of the track.
    pub receivers: Vec<DVec3>,
}

impl Listener {
    /// One receiver.
    pub fn mono(name: impl Into<String>, track: Track) -> Self {
        Listener { name: name.into(), track, receivers: vec![DVec3::ZERO] }
    }

    /// Two receivers `spacing` \[m\] apart along the track's x axis; the first, left, is on the negative
    /// side.
    pub fn spaced_pair(name: impl Into<String>, track: Track, spacing: f64) -> Self {
        let half = DVec3::X * (0.5 * spacing);
        Listener { name: name.into(), track, receivers: vec![-half, half] }
    }

    /// A receiver that never moves.
    pub fn fixed(name: impl Into<String>, position: DVec3) -> Self {
        Listener::mono(name, Track::fixed(Pose::at(position)))
    }

    /// The listener mirrored by an image source: the source itself makes there what its image makes here.
    pub fn mirrored(&self, image: &ImageSource) -> Self {
        let mirrored_keys = self.track.keys().iter().map(|key| {
            let turn = key.pose.orientation;
            // A rotation between two mirrors is a rotation about the mirrored axis, the other way around.
            let axis = image.turned(DVec3::new(turn.x, turn.y, turn.z)) * image.handedness();
            let orientation = DQuat::from_xyzw(axis.x, axis.y, axis.z, turn.w);
            Keyframe {
                time: key.time,
                pose: Pose { position: image.unfolded(key.pose.position), orientation },
            }
        });
        Listener {
            name: self.name.clone(),
            track: Track::try_new(mirrored_keys.collect()).unwrap_or_else(|| self.track.clone()),
            receivers: self.receivers.iter().map(|receiver| image.turned(*receiver)).collect(),
        }
    }

    /// Position of a receiver [m, world] at a time \[s\].
    pub fn receiver_position(&self, receiver: usize, time: f64) -> DVec3 {
        self.track.sample(time).0.world_from_body(self.receivers[receiver])
    }

    /// When and where the wavefront that leaves a sphere's surface at `time` \[s\] reaches a receiver.
    ///
    /// The sphere has its `centre` [m, world] and `radius` \[m\]. Solves t = time + (|x(t) − centre| −
    /// radius)/c for the moving receiver x(t) and returns (t, x(t)).
    pub(super) fn arrival(
        &self,
        receiver: usize,
        (centre, radius): (DVec3, f64),
        time: f64,
        sound_speed: f64,
    ) -> (f64, DVec3) {
        let heard_at = |t: f64| {
            let position = self.receiver_position(receiver, t);
            (time + ((position - centre).length() - radius) / sound_speed, position)
        };
        let (first, position) = heard_at(time);
        if self.track.is_fixed() {
            return (first, position);
        }
        // A fixed point, a contraction while the receiver is slower than sound.
        let mut t = first;
        for _ in 0..60 {
            let (next, position) = heard_at(t);
            if (next - t).abs() <= 1e-15 * next.abs().max(1e-3) {
                return (next, position);
            }
            t = next;
        }
        // If the receiver moves faster than sound, the front catches it at the latest after the end of the
        // track.
        let (mut early, mut late) = (time.min(first), first.max(time) + 1e-3);
        while heard_at(late).0 > late {
            late += late - early;
        }
        for _ in 0..200 {
            let middle = 0.5 * (early + late);
            if heard_at(middle).0 > middle {
                early = middle;
            } else {
                late = middle;
            }
        }
        (late, heard_at(late).1)
    }
}

impl Floor {
    /// Rejects a receiver \[m\] that is below the floor at a time \[s\].
    pub(super) fn check(self, listener: &Listener, position: DVec3, time: f64) -> Result<(), SynthesisError> {
        match self {
            Floor::Rigid { height } if position.y < height => Err(SynthesisError::BelowFloor {
                listener: listener.name.clone(),
                y: position.y,
                floor: height,
                time,
            }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Medium;
    use crate::propagation::{Room, WallAbsorption, image_sources};

    #[test]
    fn a_mirrored_listener_is_where_its_receivers_are_mirrored() {
        let key = |time, x, turn| Keyframe {
            time,
            pose: Pose { position: DVec3::new(x, 1.0, 0.5), orientation: DQuat::from_scaled_axis(turn) },
        };
        let keys = vec![key(0.0, 0.2, DVec3::new(0.3, -1.0, 0.4)), key(1.0, 0.9, DVec3::new(-0.7, 0.2, 2.0))];
        let listener = Listener::spaced_pair("ears", Track::try_new(keys).unwrap(), 0.17);
        let walls = [WallAbsorption::even(0.1); 6];
        let room = Room {
            lowest: DVec3::ZERO,
            highest: DVec3::new(2.0, 3.0, 4.0),
            walls,
            image_order: 3,
            late: false,
        };
        for image in image_sources(&room) {
            let mirrored = listener.mirrored(&image);
            for (receiver, time) in [(0, -1.0), (1, 0.3), (0, 0.8), (1, 2.0)] {
                let wanted = image.unfolded(listener.receiver_position(receiver, time));
                let seen = mirrored.receiver_position(receiver, time);
                // Residual seen: 2e-15 m.
                assert!(seen.distance(wanted) < 1e-12, "{image:?} {seen} {wanted}");
            }
        }
    }

    #[test]
    fn wavefront_and_moving_receiver_meet() {
        let key = |time, x| Keyframe { time, pose: Pose::at(DVec3::X * x) };
        let slow = Track::try_new(vec![key(0.0, 10.0), key(1.0, 60.0)]).unwrap();
        let supersonic = Track::try_new(vec![key(0.0, 10.0), key(1.0, 900.0)]).unwrap();
        for track in [slow, supersonic, Track::fixed(Pose::at(DVec3::X * 10.0))] {
            let listener = Listener::mono("microphone", track);
            let speed = Medium::AIR.sound_speed;
            let (t, position) = listener.arrival(0, (DVec3::ZERO, 0.1), 0.02, speed);
            let travelled = 0.1 + (t - 0.02) * speed;
            // Residual seen: 2e-13 m (supersonic).
            assert!((position.length() - travelled).abs() < 1e-11, "{position} against {travelled}");
        }
    }
}
