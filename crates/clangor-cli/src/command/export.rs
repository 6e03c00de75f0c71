//! `clangor export`: a scene or a timeline becomes another tool's file.

use clangor_pipeline::exchange::{export_scene_gltf, export_timeline_gltf};
use serde_json::json;

use super::{check_ending, is_timeline, load};
use crate::arguments::{Export, ExportFormat, Global};
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn run(options: &Export, global: &Global, console: &Console) -> Result<(), Failure> {
    let ExportFormat::Gltf { input, output, rate } = &options.format;
    check_ending(output, "glb")?;
    let summary = if is_timeline(input) {
        export_timeline_gltf(input, output, *rate)?
    } else {
        let loaded = load(input, global, &|_| (), console)?;
        let progress = console.progress("simulate", loaded.scene.simulation.duration);
        export_scene_gltf(&loaded, output, *rate, &mut |t| progress.reached(t))?
    };
    console.say(format_args!("{}: {} nodes, {} instants", output.display(), summary.nodes, summary.frames));
    console.json(&json!({ "gltf": output, "nodes": summary.nodes, "frames": summary.frames }));
    Ok(())
}
