//! A model in the published representation, in words and as JSON.

use std::path::Path;

use clangor_core::medium::Medium;
use clangor_core::reference::pan_file::PanFile;
use serde_json::json;

use crate::console::{Console, counted};

/// A few lines about it.
pub(crate) fn say(console: &Console, path: &Path, file: &PanFile, bytes: u64) {
    let (model, fields) = (&file.model, file.model.fields());
    let shortest = fields.first().map_or(0.0, |f| f.pulse * model.radius() / Medium::AIR.sound_speed);
    let directions = fields.first().map_or(0, |f| f.directions.count());
    console.say(format_args!(
        "{}: PAN representation of \"{}\", {}, {} from {:.1} µs in air, {:.1} kB",
        path.display(),
        file.solid.name,
        counted(directions, "direction", "directions"),
        counted(fields.len(), "pulse", "pulses"),
        1e6 * shortest,
        bytes as f64 * 1e-3
    ));
    for warning in &file.origin.warnings {
        console.say(warning);
    }
    console.json(&json!({
        "model": path.display().to_string(),
        "representation": "pan",
        "name": file.solid.name,
        "bytes": bytes,
        "radius_m": model.radius(),
        "directions": directions,
        "shortest_pulse_s_in_air": shortest,
        "pulses": fields.len(),
        "inputs": file.origin.inputs,
        "program": file.origin.program,
        "warnings": file.origin.warnings,
    }));
}
