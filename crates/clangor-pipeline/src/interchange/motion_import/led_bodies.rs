//! Bodies of a table that the scene holds or leads.
//!
//! A table of a whole scene, such as the poses of a timeline, lists these bodies too. Where it has them as
//! the scene does, their rows say nothing new and are left out; elsewhere the table contradicts the scene.

use std::path::Path;

use clangor_core::body::{Body, Motion};
use clangor_core::pose::Pose;

use super::MotionImportError;
use crate::motion::recording::Frame;

/// Largest difference of a pose from that of the scene: \[m\] and \[rad\].
const SAME: (f64, f64) = (1e-3, 1e-2);

/// Whether a frame of a body that the scene holds or leads is that of the scene. Frames of free bodies and of
/// those that a hand lets go are not.
pub(super) fn is_of_scene(body: &Body, frame: &Frame) -> bool {
    let scene: Pose = match &body.motion {
        Motion::Fixed => body.pose,
        Motion::Keyframed(track) => track.sample(frame.time).0,
        Motion::Free | Motion::Guided(_) => return false,
    };
    let Pose { position, orientation } = frame.pose;
    let orientation = orientation.normalize();
    let (away, turned) = SAME;
    scene.position.distance(position) <= away
        && scene.rotation_to(&Pose { position, orientation }).length() <= turned
}

/// Refuses a body that the scene holds or moves, and one that no impulse could move.
pub(super) fn check_movable(body: &Body, path: &Path) -> Result<(), MotionImportError> {
    let motion = match body.motion {
        Motion::Free => None,
        Motion::Fixed => Some("fixed"),
        Motion::Keyframed(_) | Motion::Guided(_) => Some("moved by keyframes"),
    };
    let name = || body.name.clone();
    if let Some(motion) = motion {
        return Err(MotionImportError::NotFree { path: path.into(), body: name(), motion });
    }
    let mass = body.mass;
    if mass > 0.0 && mass.is_finite() {
        Ok(())
    } else {
        Err(MotionImportError::NoMass { body: name(), mass })
    }
}
