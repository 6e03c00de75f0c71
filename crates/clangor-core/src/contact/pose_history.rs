//! Pose history of bodies: the pose rows of a timeline, by body and time.

use glam::DVec3;

use super::ContactError;
use super::row_checks::check_body;
use crate::body::{Body, BodyId, Life, Motion};
use crate::pose::{Pose, Track};
use crate::timeline::PoseRow;

/// Poses of all bodies over a stretch of time.
#[derive(Clone, Debug)]
pub struct PoseHistory {
    bodies: Vec<BodyPoses>,
    lives: Vec<Life>,
}

#[derive(Clone, Debug)]
enum BodyPoses {
    Prescribed(Track),
    /// In order of time, at least one.
    Recorded(Vec<State>),
}

/// State of a body at an instant.
#[derive(Clone, Copy, Debug)]
struct State {
    time: f64,
    pose: Pose,
    velocity: DVec3,
    angular_velocity: DVec3,
}

impl PoseHistory {
    /// Sorts rows by body and time. The starting pose counts as a row at the birth of the body.
    ///
    /// # Errors
    /// Rows of bodies that are unknown or not alive, or with numbers that are not finite.
    pub fn try_new(bodies: &[Body], rows: &[PoseRow]) -> Result<Self, ContactError> {
        let start = |body: &Body| State {
            time: body.life.birth,
            pose: body.pose,
            velocity: body.velocity,
            angular_velocity: body.angular_velocity,
        };
        let mut recorded: Vec<Vec<State>> = bodies.iter().map(|body| vec![start(body)]).collect();
        for row in rows {
            check_body(bodies, row.body, "pose", row.time)?;
            let states = &mut recorded[row.body.index()];
            if !(row.time.is_finite() && row.position.is_finite() && row.orientation.is_finite()) {
                return Err(ContactError::NotFinite { what: "pose", body: row.body.0, time: row.time });
            }
            states.push(State {
                time: row.time,
                pose: Pose { position: row.position, orientation: row.orientation },
                velocity: row.velocity,
                angular_velocity: row.angular_velocity,
            });
        }
        let order = |(body, mut states): (&Body, Vec<State>)| match &body.motion {
            Motion::Keyframed(track) => BodyPoses::Prescribed(track.clone()),
            _ => {
                states.sort_by(|a, b| a.time.total_cmp(&b.time));
                BodyPoses::Recorded(states)
            }
        };
        let lives = bodies.iter().map(|body| body.life).collect();
        Ok(PoseHistory { bodies: bodies.iter().zip(recorded).map(order).collect(), lives })
    }

    /// Span of existence of a body.
    pub fn life(&self, body: BodyId) -> Life {
        self.lives[body.index()]
    }

    /// Pose of a body at a time \[s\]. A row at exactly that time is returned (the last of several). Between
    /// rows, position is linear and rotation takes the shortest arc; between equal poses it is theirs. Before
    /// its birth a body has its starting pose, after its death its last pose.
    ///
    /// Interpolation is linear because recorded velocities at an impact are those before it. At a pose rate
    /// of 1 kHz the error in free fall is 1 µm.
    pub fn at(&self, body: BodyId, time: f64) -> Pose {
        let states = match &self.bodies[body.index()] {
            BodyPoses::Prescribed(track) => return track.sample(time).0,
            BodyPoses::Recorded(states) => states,
        };
        let next = states.partition_point(|state| state.time <= time);
        if next == 0 || next == states.len() || states[next - 1].time == time {
            return states[next.max(1) - 1].pose;
        }
        let (before, after) = (states[next - 1], states[next]);
        if before.pose == after.pose {
            return before.pose;
        }
        before.pose.between(&after.pose, (time - before.time) / (after.time - before.time))
    }

    /// Velocity [m/s] of the point of a body at `point` [m, world] at a time \[s\]; `None` without a row at
    /// exactly that time. Rows at an impact hold the state before all impacts of that instant.
    pub fn velocity_at(&self, body: BodyId, point: DVec3, time: f64) -> Option<DVec3> {
        let (pose, velocity, angular_velocity) = match &self.bodies[body.index()] {
            BodyPoses::Prescribed(track) => track.sample(time),
            BodyPoses::Recorded(states) => {
                let next = states.partition_point(|state| state.time <= time);
                let state = states.get(next.checked_sub(1)?)?;
                if state.time != time {
                    return None;
                }
                (state.pose, state.velocity, state.angular_velocity)
            }
        };
        Some(velocity + angular_velocity.cross(point - pose.position))
    }
}
