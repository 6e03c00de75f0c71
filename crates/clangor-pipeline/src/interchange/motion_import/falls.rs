//! What the falls and the sizes of recorded bodies say about the units of their files.

use std::path::Path;

use clangor_core::body::{BodyId, World};
use clangor_core::quantity::readable_length;

use super::{MotionFiles, name_of};
use crate::motion::fall_units::{FallingBody, any_agrees, fall_warnings};
use crate::motion::frame_checks::FrameChecks;

/// Diameter of the smallest moved body above which a file is probably not in metres \[m\].
const LARGE: f64 = 1.0;

/// What should be known about units.
pub(super) struct FallRemarks {
    /// Files that fall in another way than the scene.
    pub(super) warnings: Vec<String>,
    /// Bodies that are all large, where falls do not show the unit.
    pub(super) size: Option<String>,
}

/// The remarks about checked bodies, each with its file; `smallest` is the diameter of the smallest body that
/// has its size from a file \[m\].
pub(super) fn fall_remarks(
    world: &World,
    files: &MotionFiles,
    (checks, paths): (&[(BodyId, FrameChecks)], &[&Path]),
    smallest: Option<f64>,
) -> FallRemarks {
    let names: Vec<String> = checks.iter().map(|(body, _)| name_of(world, *body)).collect();
    let bodies = checks.iter().zip(paths).zip(&names);
    let bodies: Vec<FallingBody<'_>> = bodies
        .map(|(((_, checks), file), name)| FallingBody { file, name, falls: checks.free_falls() })
        .collect();
    let gravity = world.gravity.length();
    let warnings: Vec<String> = fall_warnings(&bodies, gravity, files.units(), files.axes.z_up)
        .iter()
        .map(ToString::to_string)
        .collect();
    let large = smallest.filter(|size| *size > LARGE && size.is_finite() && warnings.is_empty());
    let size = large.map(|size| match any_agrees(&bodies, gravity) {
        true => format!(
            "the smallest body that moves is {} across, and bodies fall as in metres; a model that was made \
             larger than life needs --scale and the gravity of that scale",
            readable_length(size)
        ),
        false => format!(
            "the smallest body that moves is {size:.1} m across; a file in centimetres needs --scale 0.01"
        ),
    });
    FallRemarks { warnings, size }
}
