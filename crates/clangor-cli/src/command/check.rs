//! `clangor check`: every mistake of a scene at once.

use serde_json::json;

use super::load;
use crate::arguments::{Check, Global};
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn run(options: &Check, global: &Global, console: &Console) -> Result<(), Failure> {
    let loaded = load(&options.scene, global, &|_| (), console)?;
    let (bodies, listeners) = (loaded.world.bodies.len(), loaded.scene.listeners.len());
    console.say(format_args!(
        "{}: no errors; {bodies} bodies, {listeners} listeners, {} s",
        options.scene.display(),
        loaded.scene.simulation.duration
    ));
    console.json(&json!({
        "bodies": bodies,
        "listeners": listeners,
        "duration_s": loaded.scene.simulation.duration,
        "warnings": loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
    }));
    Ok(())
}
