//! Frames of several bodies as pose rows in order of time, made one at a time.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

use clangor_core::pose::Pose;
use clangor_core::timeline::PoseRow;
use glam::DVec3;

use crate::motion::recording::{Frame, RecordedBody};

/// Velocity [m/s] and angular velocity [rad/s] at a frame: the means of the intervals beside it.
pub(super) fn velocities(frames: &[Frame], at: usize) -> (DVec3, DVec3) {
    let low = at.saturating_sub(1);
    let high = (at + 1).min(frames.len() - 1);
    let (from, to) = (&frames[low], &frames[high]);
    let span = to.time - from.time;
    if span <= 0.0 {
        return (DVec3::ZERO, DVec3::ZERO);
    }
    let velocity = (to.pose.position - from.pose.position) / span;
    // What rests does not turn, which need not be computed.
    let turns = from.pose.orientation != to.pose.orientation;
    (velocity, if turns { from.pose.rotation_to(&to.pose) / span } else { DVec3::ZERO })
}

/// The frames from one instant until before another in order of time, those of one time in the order of the
/// bodies; `states`, which are in order too and lie in that time, come last at their times.
pub(super) fn pose_rows<'a>(
    recorded: &'a [RecordedBody],
    states: &'a [PoseRow],
    from: f64,
    to: f64,
) -> PoseRows<'a> {
    let first = |(place, body): (usize, &RecordedBody)| {
        let at = body.frames.partition_point(|frame| frame.time < from);
        let frame = body.frames.get(at).filter(|frame| frame.time < to)?;
        Some(Reverse((key(frame), place, at)))
    };
    PoseRows { recorded, states, next: recorded.iter().enumerate().filter_map(first).collect(), to }
}

/// The iterator of [`pose_rows`].
pub(super) struct PoseRows<'a> {
    recorded: &'a [RecordedBody],
    states: &'a [PoseRow],
    /// Next frame of each body: its time, the place of the body, and that of the frame.
    next: BinaryHeap<Reverse<(u64, usize, usize)>>,
    to: f64,
}

impl PoseRows<'_> {
    /// Time of the next frame \[s\].
    fn next_time(&self) -> Option<f64> {
        self.next.peek().map(|Reverse((_, place, at))| self.recorded[*place].frames[*at].time)
    }
}

/// The time of a frame as an integer of the same order; times are not negative.
fn key(frame: &Frame) -> u64 {
    // Adding 0 makes −0 positive.
    (frame.time + 0.0).to_bits()
}

impl Iterator for PoseRows<'_> {
    type Item = PoseRow;

    fn next(&mut self) -> Option<PoseRow> {
        if let Some((state, rest)) = self.states.split_first()
            && self.next_time().is_none_or(|time| state.time < time)
        {
            self.states = rest;
            return Some(*state);
        }
        let mut first = self.next.peek_mut()?;
        let Reverse((_, place, at)) = *first;
        let RecordedBody { body, frames, .. } = &self.recorded[place];
        match frames.get(at + 1).filter(|frame| frame.time < self.to) {
            Some(frame) => *first = Reverse((key(frame), place, at + 1)),
            None => drop(PeekMut::pop(first)),
        }
        let Frame { time, pose, .. } = frames[at];
        let (velocity, angular_velocity) = velocities(frames, at);
        let Pose { position, orientation } = pose;
        Some(PoseRow { time, body: *body, position, orientation, velocity, angular_velocity })
    }
}
