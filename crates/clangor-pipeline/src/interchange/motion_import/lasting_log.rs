//! Whether the lasting contacts of a recording are logged, with one row for each point and frame.
//!
//! They are where the scene has `rolling = true`, as in a simulation, or where they are asked for. The sound
//! of force streams has steps of one length, so that all frames must have the same.

use clangor_core::body::BodyId;

use super::MotionFiles;
use crate::motion::frame_checks::{FrameChecks, common_length};
use crate::stages::load::LoadedScene;

/// Longest frame of a log \[s\], the longest step of a timeline.
const LONGEST: f64 = 1.0;

/// Whether there is a log.
#[derive(Default)]
pub(super) struct LastingLog {
    /// Length of its frames \[s\]; `None` without one.
    pub(super) step: Option<f64>,
    /// Why there is none although it is wanted.
    pub(super) remark: Option<&'static str>,
}

/// The log of bodies with these checks.
pub(super) fn lasting_log(
    loaded: &LoadedScene,
    files: &MotionFiles,
    checks: &[(BodyId, FrameChecks)],
) -> LastingLog {
    if !(loaded.scene.render.rolling || files.raw_log) {
        return LastingLog::default();
    }
    let step = common_length(checks).filter(|step| *step <= LONGEST);
    let remark = "frames are not evenly spaced, alike for all bodies: lasting contacts have no rows, and \
                  rolling and sliding are not heard";
    LastingLog { step, remark: step.is_none().then_some(remark) }
}

/// Noise of the jumps of each of so many bodies [m/s].
pub(super) fn noise_of_bodies(checks: &[(BodyId, FrameChecks)], bodies: usize) -> Vec<f64> {
    let mut noise = vec![0.0; bodies];
    for (body, checks) in checks {
        noise[body.index()] = checks.noise();
    }
    noise
}
