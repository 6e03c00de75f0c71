//! Listeners: places of the receivers over time, arrival of wavefronts, and reflection in the floor.

use glam::DVec3;

use super::SynthesisError;
use crate::pose::{Pose, Track};
pub use crate::propagation::Floor;

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
    use crate::pose::Keyframe;

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
