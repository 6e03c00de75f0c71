//! The convex parts with which mesh files collide, found before a scene moves.

use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::stages::collision_parts::ObtainedParts;
use clangor_pipeline::stages::find_collision_parts::find_collision_parts;
use clangor_pipeline::stages::load::LoadedScene;
use serde_json::{Value, json};

use crate::arguments::Global;
use crate::console::{Console, counted};
use crate::diagnostics::draw_warnings;
use crate::failure::Failure;

/// Finds them in the cache or by a decomposition, and says what came of it.
pub(super) fn collision_parts(
    loaded: &mut LoadedScene,
    global: &Global,
    console: &Console,
) -> Result<(), Failure> {
    find_collision_parts(loaded, ModelCache::find(global.cache.as_deref()).as_ref())?;
    say(loaded, console);
    Ok(())
}

/// How many there are, and what is doubtful about them.
pub(super) fn say(loaded: &LoadedScene, console: &Console) {
    for found in &loaded.collisions.obtained {
        console.say(format_args!(
            "\"{}\" collides by {} within {:.2e} m of its surface, {} in {:.2} s",
            loaded.world.bodies[found.body.index()].name,
            counted(found.parts, "convex part", "convex parts"),
            found.surface_error,
            if found.cached { "from the cache" } else { "found" },
            found.time.as_secs_f64()
        ));
    }
    for drawn in draw_warnings(&loaded.path, &loaded.text, loaded.collisions.warnings.iter()) {
        console.drawn(drawn);
    }
    loaded.collisions.remarks.iter().for_each(|remark| console.warn(remark));
}

/// One row for each mesh.
pub(super) fn json(loaded: &LoadedScene) -> Value {
    let row = |found: &ObtainedParts| {
        json!({
            "body": loaded.world.bodies[found.body.index()].name,
            "parts": found.parts,
            "surface_error_m": found.surface_error,
            "from_cache": found.cached,
        })
    };
    loaded.collisions.obtained.iter().map(row).collect()
}
