//! `clangor compare`: the tones of a recording beside the modes of a body, and what they say of its material.

use std::ops::ControlFlow;

use clangor_core::material::{Damping, Material};
use clangor_pipeline::session::named_body::preset;
use clangor_pipeline::session::{self, Comparison};
use serde_json::{Value, json};

use super::session::StageBars;
use crate::arguments::{Compare, Global};
use crate::console::{Console, counted, four_digits};
use crate::failure::Failure;

pub(crate) fn run(options: &Compare, global: &Global, console: &Console) -> Result<(), Failure> {
    let mut compare = session::Compare::new(&options.model)
        .scale(options.scale)
        .max_frequency(options.max_frequency)
        .accuracy(options.accuracy);
    if let Some(material) = material(options)? {
        compare = compare.material(material);
    }
    if let Some(channel) = options.channel {
        compare = compare.channel(channel);
    }
    if let Some(folder) = &global.cache {
        compare = compare.cache(folder);
    }
    let bars = StageBars::new(console);
    let mut on_progress = |p: &session::Progress<'_>| -> ControlFlow<()> { bars.show(p) };
    let found = compare.sound_with_progress(&options.sound, &mut on_progress)?;
    bars.clear();
    found.warnings.iter().for_each(|warning| console.warn(warning));
    say_tones(&found, console);
    say_fits(&found, console);
    console.json(&json(&found));
    Ok(())
}

/// The preset with the constants that replace its own.
fn material(options: &Compare) -> Result<Option<Material>, Failure> {
    let constants = [options.density, options.youngs_modulus, options.poisson_ratio];
    let Some(name) = &options.material else {
        return match constants.iter().any(Option::is_some) {
            true => Err(Failure::new("constants of a material replace those of a preset: give --material")),
            false => Ok(None),
        };
    };
    let preset = preset(name)?;
    Ok(Some(Material {
        density: options.density.unwrap_or(preset.density),
        youngs_modulus: options.youngs_modulus.unwrap_or(preset.youngs_modulus),
        poisson_ratio: options.poisson_ratio.unwrap_or(preset.poisson_ratio),
        ..preset
    }))
}

/// One line for each tone, with its mode.
fn say_tones(found: &Comparison, console: &Console) {
    console.say(format_args!(
        "{:>11} {:>8} {:>9}   {:>4} {:>11} {:>8} {:>9}",
        "tone", "level", "T60", "mode", "model", "off", "T60"
    ));
    for (index, tone) in found.tones.iter().enumerate() {
        let own = format!("{:>8.2} Hz {:>5.1} dB {:>7} s", tone.frequency, tone.level, four_digits(tone.t60));
        let (Some(mode), Some(matched)) = (found.mode_of(index), &found.matched) else {
            console.say(own);
            continue;
        };
        let model = &found.modes[mode];
        console.say(format_args!(
            "{own}   {:>4} {:>8.2} Hz {:>6.2} % {:>9}",
            mode + 1,
            model.frequency,
            100.0 * (tone.frequency / (matched.ratio * model.frequency) - 1.0),
            model.t60.map_or("–".into(), |t60| format!("{} s", four_digits(t60)))
        ));
    }
}

/// Young's modulus, and the damping laws.
fn say_fits(found: &Comparison, console: &Console) {
    let Some(matched) = &found.matched else {
        console.say("no tone is a mode of the model, whatever its stiffness");
        return;
    };
    console.say(format_args!(
        "{} of {} matched, of {}; frequencies {:.5} times those of the model, each within {:.2} %",
        counted(matched.pairs.len(), "tone", "tones"),
        found.tones.len(),
        counted(found.modes.len(), "mode", "modes"),
        matched.ratio,
        100.0 * matched.spread
    ));
    if let Some((modulus, error)) = found.youngs_modulus().filter(|(modulus, _)| modulus.is_finite()) {
        // The error is that of the match, and says nothing where another match is nearly as good.
        let error = match matched.rival {
            Some(rival) => format!(" or {:.4e} Pa", modulus * (rival / matched.ratio).powi(2)),
            None if error.is_finite() => format!(" ± {:.2} %", 100.0 * error / modulus),
            None => String::new(),
        };
        console.say(format_args!(
            "Young's modulus {:.4e} Pa{error}, {:.4} times that of the model",
            modulus,
            matched.ratio.powi(2)
        ));
    }
    for (place, fit) in found.damping.iter().enumerate() {
        let best = if place == 0 { "damping:" } else { "     or:" };
        console.say(format_args!("{best} {}, within {:.1} %", law(&fit.damping), 100.0 * fit.spread));
    }
}

/// A law as a scene writes it.
fn law(damping: &Damping) -> String {
    match damping {
        Damping::LossFactor(eta) => format!("loss_factor = {eta:.4e}"),
        Damping::T60(t60) => format!("t60 = {}", four_digits(*t60)),
        Damping::Rayleigh { alpha, beta, g } => {
            format!("rayleigh = {{ alpha = {alpha:.4e}, beta = {beta:.4e}, g = {g:.4e} }}")
        }
        // Tables are measured, not fitted.
        Damping::LossFactorTable(rows) | Damping::T60Table(rows) | Damping::Modes { t60: rows, .. } => {
            format!("a table of {} rows", rows.len())
        }
    }
}

fn json(found: &Comparison) -> Value {
    let tones = found.tones.iter().enumerate().map(|(index, tone)| {
        let mode = found.mode_of(index);
        json!({
            "frequency_hz": tone.frequency,
            "t60_s": tone.t60,
            "level_db": tone.level,
            "clarity_db": tone.clarity,
            "mode": mode.map(|mode| mode + 1),
        })
    });
    let modes = found.modes.iter().map(
        |mode| json!({ "frequency_hz": mode.frequency, "mesh_error": mode.mesh_error, "t60_s": mode.t60 }),
    );
    let damping = found.damping.iter().map(|fit| {
        let (law, values) = match &fit.damping {
            Damping::LossFactor(eta) => ("loss_factor", json!(eta)),
            Damping::T60(t60) => ("t60", json!(t60)),
            Damping::Rayleigh { alpha, beta, g } => {
                ("rayleigh", json!({ "alpha": alpha, "beta": beta, "g": g }))
            }
            _ => ("table", Value::Null),
        };
        json!({ "law": law, "value": values, "spread": fit.spread })
    });
    let modulus = found.youngs_modulus();
    json!({
        "tones": tones.collect::<Vec<_>>(),
        "modes": modes.collect::<Vec<_>>(),
        "frequency_ratio": found.matched.as_ref().map(|matched| matched.ratio),
        "spread": found.matched.as_ref().map(|matched| matched.spread),
        "rival_ratio": found.matched.as_ref().and_then(|matched| matched.rival),
        "youngs_modulus_pa": modulus.map(|(modulus, _)| modulus),
        "youngs_modulus_error_pa": modulus.map(|(_, error)| error),
        "damping": damping.collect::<Vec<_>>(),
        "warnings": found.warnings,
    })
}
