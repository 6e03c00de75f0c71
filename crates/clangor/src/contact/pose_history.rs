//! Where bodies were: the pose rows of a timeline, looked up by body and time.

use super::ContactError;
use crate::body::{Body, BodyId, Motion};
use crate::pose::{Pose, Track};
use crate::timeline::PoseRow;

/// Poses of all bodies over a stretch of time.
#[derive(Clone, Debug)]
pub struct PoseHistory {
    bodies: Vec<BodyPoses>,
}

#[derive(Clone, Debug)]
enum BodyPoses {
    Prescribed(Track),
    /// In order of time, at least one.
    Recorded(Vec<(f64, Pose)>),
}

impl PoseHistory {
    /// Sorts rows by body and time. A body without rows is where it started; the start counts as a row at t = 0.
    ///
    /// # Errors
    /// Rows of unknown bodies or with numbers that are not finite.
    pub fn try_new(bodies: &[Body], rows: &[PoseRow]) -> Result<Self, ContactError> {
        let mut recorded: Vec<Vec<(f64, Pose)>> = bodies.iter().map(|b| vec![(0.0, b.pose)]).collect();
        for row in rows {
            let poses = recorded.get_mut(row.body.index()).ok_or(ContactError::UnknownBody {
                what: "pose",
                body: row.body.0,
                bodies: bodies.len(),
                time: row.time,
            })?;
            if !(row.time.is_finite() && row.position.is_finite() && row.orientation.is_finite()) {
                return Err(ContactError::NotFinite { what: "pose", body: row.body.0, time: row.time });
            }
            poses.push((row.time, Pose { position: row.position, orientation: row.orientation }));
        }
        let order = |(body, mut poses): (&Body, Vec<(f64, Pose)>)| match &body.motion {
            Motion::Keyframed(track) => BodyPoses::Prescribed(track.clone()),
            _ => {
                poses.sort_by(|a, b| a.0.total_cmp(&b.0));
                BodyPoses::Recorded(poses)
            }
        };
        Ok(PoseHistory { bodies: bodies.iter().zip(recorded).map(order).collect() })
    }

    /// Pose of a body at a time [s]: a row of that very time if there is one (of several, the last given), else
    /// between its neighbours on a straight line and the shortest rotation, else the nearest.
    ///
    /// Straight, because the recorded velocities are those before an impact and say nothing about after it; at a pose
    /// rate of 1 kHz free fall is 1 µm off.
    pub fn at(&self, body: BodyId, time: f64) -> Pose {
        let poses = match &self.bodies[body.index()] {
            BodyPoses::Prescribed(track) => return track.sample(time).0,
            BodyPoses::Recorded(poses) => poses,
        };
        let next = poses.partition_point(|(t, _)| *t <= time);
        if next == 0 || next == poses.len() || poses[next - 1].0 == time {
            return poses[next.max(1) - 1].1;
        }
        let ((t0, p0), (t1, p1)) = (poses[next - 1], poses[next]);
        let s = (time - t0) / (t1 - t0);
        Pose {
            position: p0.position.lerp(p1.position, s),
            orientation: p0.orientation.slerp(p1.orientation, s).normalize(),
        }
    }
}
