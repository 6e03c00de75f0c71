//! Bodies of a table that the scene holds or leads.
//!
//! A body that a hand leads in the scene moves as recorded, and freely, since forces may move it too.
//! A table of a whole scene, such as the poses of a timeline, lists these bodies too. Where it has them as
//! the scene does, their rows say nothing new and are left out; elsewhere the table contradicts the scene.

use std::path::Path;

use clangor_core::body::{Body, Motion};
use clangor_core::pose::Pose;

use super::MotionImportError;
use crate::motion::frame_checks::check_numbers;
use crate::motion::recording::Frame;

/// Largest difference of a pose from that of the scene: \[m\] and \[rad\].
const SAME: (f64, f64) = (1e-3, 1e-2);

/// Whether a frame of a body that the scene holds or leads is that of the scene. Frames of free bodies and of
/// those that a hand leads are not.
///
/// # Errors
/// [`MotionImportError::Recording`] for numbers that no pose has.
pub(super) fn is_of_scene(body: &Body, frame: &Frame, path: &Path) -> Result<bool, MotionImportError> {
    let mut frame = *frame;
    let scene: Pose = match &body.motion {
        Motion::Fixed => body.pose,
        Motion::Keyframed(track) => track.sample(frame.time).0,
        Motion::Free | Motion::Guided(_) => return Ok(false),
    };
    check_numbers(&body.name, &mut frame)
        .map_err(|error| MotionImportError::Recording { path: path.into(), error })?;
    let (away, turned) = SAME;
    let is_near = scene.position.distance(frame.pose.position) <= away;
    Ok(is_near && scene.rotation_to(&frame.pose).length() <= turned)
}

/// Refuses a body that the scene holds or moves, and one that no impulse could move.
pub(super) fn check_movable(body: &Body, path: &Path) -> Result<(), MotionImportError> {
    let motion = match body.motion {
        Motion::Free | Motion::Guided(_) => None,
        Motion::Fixed => Some("fixed"),
        Motion::Keyframed(_) => Some("moved by keyframes"),
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
