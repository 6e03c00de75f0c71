//! `clangor check`: every mistake of a scene at once.

use clangor_pipeline::stages::simulate::check_motion;
use serde_json::json;

use super::collision_parts::collision_parts;
use super::cost::SceneCost;
use super::load;
use crate::arguments::{Check, Global};
use crate::console::{Console, counted};
use crate::failure::Failure;

pub(crate) fn run(options: &Check, global: &Global, console: &Console) -> Result<(), Failure> {
    let mut loaded = load(&options.scene, global, &|_| (), console)?;
    collision_parts(&mut loaded, global, console)?;
    check_motion(&loaded)?;
    let (bodies, listeners) = (loaded.world.bodies.len(), loaded.scene.listeners.len());
    console.say(format_args!(
        "{}: no errors; {}, {}, {} s",
        options.scene.display(),
        counted(bodies, "body", "bodies"),
        counted(listeners, "listener", "listeners"),
        loaded.scene.simulation.duration
    ));
    let cost = options.cost.then(|| SceneCost::of(&loaded));
    if let Some(cost) = &cost {
        cost.say(console);
    }
    let warnings = loaded.warnings.iter().chain(&loaded.collisions.warnings);
    console.json(&json!({
        "bodies": bodies,
        "listeners": listeners,
        "duration_s": loaded.scene.simulation.duration,
        "errors": [],
        "cost": cost.as_ref().map(SceneCost::json),
        "warnings": warnings.map(ToString::to_string).collect::<Vec<_>>(),
    }));
    Ok(())
}
