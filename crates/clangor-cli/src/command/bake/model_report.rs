//! A sound model in words and as JSON.

use std::path::Path;

use clangor_core::medium::Medium;
use clangor_core::sound_model::files::model_file::ModelFile;
use serde_json::{Value, json};

use crate::console::{Console, counted};

/// A few lines about a model.
pub(crate) fn say(console: &Console, path: &Path, file: &ModelFile, bytes: u64) {
    let (model, field) = (&file.acceleration, &file.acceleration.field);
    console.say(format_args!(
        "{}: acceleration noise of \"{}\" to {:.0} Hz in air (kR = {:.3}), {:.1} kB",
        path.display(),
        file.solid.name,
        model.max_frequency(Medium::AIR.sound_speed),
        field.max_wavenumber,
        bytes as f64 * 1e-3
    ));
    console.say(format_args!(
        "bounding radius {:.6} m, volume {:.6e} m³; multipoles to order {}, {} at {}, {}",
        model.radius,
        file.solid.mass.volume,
        field.order(),
        counted(field.terms.len(), "coefficient", "coefficients"),
        counted(field.nodes.len(), "node in frequency", "nodes in frequency"),
        match &model.near {
            Some(near) => format!(
                "near field from {}",
                counted(near.surface.vertices.len(), "point", "points of the surface")
            ),
            None => "no near field".into(),
        }
    ));
    console.say(evidence(file));
}

/// How a model was computed, and how good it is.
pub(crate) fn evidence(file: &ModelFile) -> String {
    let origin = &file.origin;
    format!(
        "{}, {}, {} solved; error between them {:.1e}, asked for {:.1e}",
        if origin.method.is_empty() { "solver not named" } else { &origin.method },
        counted(origin.unknowns as usize, "unknown", "unknowns"),
        counted(origin.solves as usize, "frequency", "frequencies"),
        origin.held_out_error,
        origin.asked_accuracy
    )
}

/// All of it.
pub(crate) fn json(path: &Path, file: &ModelFile, bytes: u64) -> Value {
    let (model, field, origin) = (&file.acceleration, &file.acceleration.field, &file.origin);
    json!({
        "model": path.display().to_string(),
        "name": file.solid.name,
        "bytes": bytes,
        "radius_m": model.radius,
        "volume_m3": file.solid.mass.volume,
        "max_kr": field.max_wavenumber,
        "max_frequency_hz_in_air": model.max_frequency(Medium::AIR.sound_speed),
        "order": field.order(),
        "coefficients": field.terms.len(),
        "nodes": field.nodes.len(),
        "near_field_points": model.near.as_ref().map(|near| near.surface.vertices.len()),
        "method": origin.method,
        "unknowns": origin.unknowns,
        "solves": origin.solves,
        "held_out_error": origin.held_out_error,
        "asked_accuracy": origin.asked_accuracy,
        "inputs": origin.inputs,
        "program": origin.program,
        "warnings": origin.warnings,
    })
}
