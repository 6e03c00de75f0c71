//! What the timeline of a motion or of contacts that another program made says about its origin: no steps
//! and no log of them, and the scene that it belongs to.

use clangor_core::body::World;

use crate::formats::timeline_file::{Origin, TimelineHeader};
use crate::stages::load::LoadedScene;

/// The header for a world with the settings of a scene, up to a time \[s\]; `solver` names the source.
pub(super) fn imported_header(
    loaded: &LoadedScene,
    world: World,
    solver: &str,
    duration: f64,
) -> TimelineHeader {
    let simulation = &loaded.scene.simulation;
    TimelineHeader {
        world,
        medium: loaded.scene.acoustics.medium,
        origin: Origin {
            solver: solver.into(),
            time_step: 0.0,
            duration,
            v_min: simulation.v_min,
            pose_rate: 0.0,
            raw_log: false,
            sleep: false,
            seed: simulation.seed,
            impact_modes: Vec::new(),
        },
        scene: Some(loaded.text.clone()),
    }
}
