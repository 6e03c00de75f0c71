//! The convex parts with which meshes collide and the modes with which thin bodies meet impacts, found before
//! a scene moves.

use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::stages::find_impact_modes::find_impact_modes;
use clangor_pipeline::stages::load::LoadedScene;
use clangor_pipeline::stages::simulate::check_motion;
use clangor_pipeline::stages::sound_models::SoundModelProgress;

use super::collision_parts::collision_parts;
use crate::arguments::Global;
use crate::console::Console;
use crate::failure::Failure;

/// Finds them in the cache or by a bake, and says what that took.
pub(super) fn impact_modes(
    loaded: &mut LoadedScene,
    global: &Global,
    console: &Console,
) -> Result<(), Failure> {
    collision_parts(loaded, global, console)?;
    // No long search for a scene that cannot move.
    check_motion(loaded)?;
    let cache = ModelCache::find(global.cache.as_deref());
    let progress = console.progress("modes", 1.0);
    let mut reached = |p: &SoundModelProgress<'_>| {
        progress.stage(p.step);
        progress.reached(p.done)
    };
    loaded.give_modes(find_impact_modes(loaded, cache.as_ref(), &mut reached)?);
    drop(progress);
    for (body, cached, time) in &loaded.modes.obtained {
        let (name, seconds) = (&loaded.world.bodies[body.index()].name, time.as_secs_f64());
        let from = if *cached { "from the cache" } else { "found" };
        console.say(format_args!("modes of \"{name}\" for its impacts: {from} in {seconds:.2} s"));
    }
    loaded.modes.remarks.iter().for_each(|remark| console.say(format_args!("{remark}")));
    Ok(())
}
