//! Bodies that a recording moves away from the joints that hold them in the scene.
//!
//! A joint of the scene is taken for that of the motion, as long as its ends stay together and its axis stays
//! where it is. A body that leaves it was free in the program that moved it, or had its joint elsewhere.
//!
//! Looks at some instants of each part of a recording.

use std::collections::BTreeMap;
use std::fmt;

use clangor_core::body::{Body, BodyId, World};
use clangor_core::pose::Pose;
use clangor_sim::rigid::JoinedBodies;

use super::impacts::state_of_unrecorded;
use super::recording::{Frame, RecordedBody};

/// Largest part of the radius of a body by which its joints may be off \[m\], and largest tilt of an axis
/// \[rad\].
const OPEN: f64 = 0.05;
/// Instants of a part.
const INSTANTS: usize = 32;

/// How far the joints of a body may be off \[m, or rad\].
fn most_open(world: &World, body: BodyId) -> f64 {
    OPEN * world.bodies[body.index()].surface.bounding_radius().min(1.0)
}

/// Whether the joints of these bodies are closed in these poses, as far as recordings go.
pub(crate) fn are_closed(
    (world, joined): (&World, &JoinedBodies<'_>),
    bodies: [BodyId; 2],
    poses: &dyn Fn(BodyId) -> Pose,
) -> bool {
    bodies.into_iter().all(|body| joined.gap(body, poses) <= most_open(world, body))
}

/// The bodies that leave their joints: how far at most \[m, or rad\], and in which frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct OpenJoints(BTreeMap<BodyId, (f64, Frame)>);

/// A body off its joints, for people.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OpenJointNotice {
    body: String,
    gap: f64,
    time: f64,
    row: u64,
}

impl OpenJoints {
    /// Looks at some frames; of each body the one farthest from its joints is kept.
    pub(crate) fn look(&mut self, world: &World, recorded: &[RecordedBody]) {
        let Some(joined) = JoinedBodies::of(world) else { return };
        let frames: BTreeMap<BodyId, &[Frame]> =
            recorded.iter().map(|body| (body.body, body.frames.as_slice())).collect();
        for (body, of_body) in frames.iter().filter(|(body, _)| joined.hold(**body)) {
            for frame in of_body.iter().step_by(of_body.len().div_ceil(INSTANTS).max(1)) {
                let poses = |other: BodyId| {
                    let recorded = frames.get(&other).copied().unwrap_or_default();
                    pose_between(&world.bodies[other.index()], recorded, frame.time)
                };
                let gap = joined.gap(*body, &poses);
                if gap > most_open(world, *body) && self.0.get(body).is_none_or(|(most, _)| gap > *most) {
                    self.0.insert(*body, (gap, *frame));
                }
            }
        }
    }

    /// What should be known, body by body.
    pub(crate) fn notices(&self, world: &World) -> Vec<OpenJointNotice> {
        let notice = |(body, (gap, frame)): (&BodyId, &(f64, Frame))| OpenJointNotice {
            body: world.bodies[body.index()].name.clone(),
            gap: *gap,
            time: frame.time,
            row: frame.row,
        };
        self.0.iter().map(notice).collect()
    }
}

impl fmt::Display for OpenJointNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let OpenJointNotice { body, gap, time, row } = self;
        write!(
            f,
            "{body} leaves the joints of the scene by up to {:.1} mm or mrad (row {row}, t = {time:.4} s); \
             impacts there are those of free bodies: check the point and the axis of its joint, or leave the \
             joint out",
            1e3 * gap
        )
    }
}

/// The pose of a body at a time: between two of its frames, or that of the scene where it has none.
pub(super) fn pose_between(body: &Body, frames: &[Frame], time: f64) -> Pose {
    let next = frames.partition_point(|frame| frame.time <= time);
    let before = next.checked_sub(1).map(|last| &frames[last]);
    match (before, frames.get(next)) {
        (Some(before), Some(after)) => {
            before.pose.between(&after.pose, (time - before.time) / (after.time - before.time))
        }
        (Some(end), None) | (None, Some(end)) => end.pose,
        (None, None) => state_of_unrecorded(body, time).pose,
    }
}
