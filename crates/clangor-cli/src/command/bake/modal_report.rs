//! Modes in words and as JSON.

use std::f64::consts::{LN_10, TAU};

use clangor_core::material::{Damping, presets};
use clangor_core::sound_model::files::modal_file::ModalPart;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use serde_json::{Value, json};

use crate::console::{Console, counted, four_digits};

/// A few lines about modes, and a table of `each` of them.
pub(crate) fn say(console: &Console, part: &ModalPart, each: bool) {
    let ModalPart { model, origin } = part;
    if let Some(first) = origin.first_frequency {
        console.say(no_modes(first, model.max_frequency));
        return;
    }
    let nodes = model.surface.nodes.len();
    console.say(format_args!(
        "{} of {} to {:.0} Hz; shapes at {} of the surface",
        counted(model.known_modes().len(), "mode", "modes"),
        origin.material,
        model.statistical_above.unwrap_or(model.max_frequency),
        counted(nodes, "node", "nodes"),
    ));
    if model.statistical_above.is_some() {
        let synthetic = model.modes.len() - model.known_modes().len();
        console.say(format_args!(
            "statistical from there to {:.0} Hz: {}",
            model.max_frequency,
            counted(synthetic, "synthetic mode", "synthetic modes")
        ));
    }
    console.say(evidence(part));
    if !each {
        return;
    }
    let damping = damping(part);
    console.say(format_args!(
        "{:>5} {:>12} {:>8} {:>10} {:>6} {:>12} {:>10}",
        "mode", "Hz", "mesh %", "T60 s", "order", "power", "T60 air s"
    ));
    let words = |number: Option<f64>| number.map_or("–".into(), four_digits);
    for (at, mode) in model.known_modes().iter().enumerate() {
        let row = Row::of(mode, model, damping.as_ref());
        console.say(format_args!(
            "{:>5} {:>12.2} {:>8} {:>10} {:>6} {:>12} {:>10}",
            at + 1,
            mode.frequency,
            words(row.mesh_error.map(|e| 100.0 * e)),
            words(row.t60),
            mode.transfer.as_ref().map_or("–".into(), |t| t.order.to_string()),
            words(row.power),
            words(row.air_t60),
        ));
    }
    console.say(
        "power: radiated by a modal acceleration of amplitude 1, W/(m²/s⁴ kg); T60 air: by radiation alone",
    );
}

/// What to say of a body that does not ring.
pub(crate) fn no_modes(first: f64, limit: f64) -> String {
    format!("no audible modes: first at {:.2} kHz, above the limit of {:.2} kHz", 1e-3 * first, 1e-3 * limit)
}

/// How modes were computed.
pub(crate) fn evidence(part: &ModalPart) -> String {
    let origin = &part.origin;
    format!(
        "{}, {}, residual {:.1e}; {}",
        origin.mesh,
        counted(origin.nodes as usize, "node", "nodes"),
        origin.residual,
        if origin.method.is_empty() { "no transfers" } else { &origin.method },
    )
}

/// All of it.
pub(crate) fn json(part: &ModalPart) -> Value {
    let ModalPart { model, origin } = part;
    let damping = damping(part);
    let known = model.known_modes();
    let rows: Vec<Row> = known.iter().map(|m| Row::of(m, model, damping.as_ref())).collect();
    let of = |number: fn(&Row) -> Option<f64>| rows.iter().map(number).collect::<Vec<_>>();
    json!({
        "radius_m": model.radius,
        "max_frequency_hz": model.max_frequency,
        "statistical_above_hz": model.statistical_above,
        "material": origin.material,
        "youngs_modulus_pa": origin.youngs_modulus,
        "poisson_ratio": origin.poisson_ratio,
        "density_kg_per_m3": model.density,
        "first_frequency_hz": origin.first_frequency,
        "frequencies_hz": known.iter().map(|m| m.frequency).collect::<Vec<_>>(),
        "mesh_errors": of(|r| r.mesh_error),
        "t60_s": of(|r| r.t60),
        "orders": known.iter().map(|m| m.transfer.as_ref().map(|t| t.order)).collect::<Vec<_>>(),
        "powers_w_s4_kg_per_m2": of(|r| r.power),
        "radiation_t60_s": of(|r| r.air_t60),
        "surface_nodes": model.surface.nodes.len(),
        "mesh": origin.mesh,
        "mesh_nodes": origin.nodes,
        "residual": origin.residual,
        "method": origin.method,
        "asked_mesh_error": origin.asked_mesh_error,
        "asked_accuracy": origin.asked_accuracy,
        "inputs": origin.inputs,
        "program": origin.program,
        "warnings": origin.warnings,
    })
}

/// The damping of the preset that the modes were baked of, if its name is one.
fn damping(part: &ModalPart) -> Option<Damping> {
    presets::preset(&part.origin.material).map(|material| material.damping)
}

/// What there is to say of a mode.
struct Row {
    mesh_error: Option<f64>,
    /// By the damping of the material \[s\].
    t60: Option<f64>,
    /// Radiated by q̈ of amplitude 1 [W s⁴/(kg m²)].
    power: Option<f64>,
    /// By radiation alone \[s\].
    air_t60: Option<f64>,
}

impl Row {
    fn of(mode: &ModalMode, model: &ModalModel, damping: Option<&Damping>) -> Self {
        let omega = TAU * mode.frequency;
        let speed = model.medium.sound_speed;
        let wavenumber = omega * model.radius / speed;
        let unit = model.medium.density * model.radius.powi(4) / speed;
        let power = mode.transfer.as_ref().map(|transfer| unit * transfer.power(wavenumber));
        // Of unit modal mass, q̈ of amplitude 1 has the energy 1/(2 ω²).
        let air_t60 = power.map(|power| 6.0 * LN_10 / (2.0 * omega * omega * power));
        Row {
            mesh_error: Some(mode.mesh_error).filter(|e| !e.is_nan()),
            t60: damping.map(|d| d.t60(mode.frequency)),
            power,
            air_t60,
        }
    }
}
