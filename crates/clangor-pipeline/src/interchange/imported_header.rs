//! What the timeline of a motion or of contacts that another program made says about its origin, and the
//! scene that it belongs to. Frames count as steps where every lasting contact in them is logged.

use clangor_core::body::World;

use crate::formats::timeline_file::{Origin, TimelineHeader};
use crate::stages::load::LoadedScene;

/// The header for a world with the settings of a scene, for a motion that ends at a time \[s\]; `solver`
/// names the source, and `step` is the length of the frames \[s\] whose lasting contacts are all there. What
/// rings beyond the end of the motion is heard as long as the scene lasts.
pub(super) fn imported_header(
    loaded: &LoadedScene,
    world: World,
    solver: &str,
    duration: f64,
    step: Option<f64>,
) -> TimelineHeader {
    let simulation = &loaded.scene.simulation;
    TimelineHeader {
        world,
        medium: loaded.scene.acoustics.medium,
        origin: Origin {
            solver: solver.into(),
            time_step: step.unwrap_or(0.0),
            duration: simulation.duration.max(duration),
            v_min: simulation.v_min,
            pose_rate: 0.0,
            raw_log: step.is_some(),
            sleep: false,
            seed: simulation.seed,
            impact_modes: Vec::new(),
        },
        scene: Some(loaded.text.clone()),
    }
}
