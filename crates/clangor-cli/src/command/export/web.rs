//! `clangor export web`: a finished run for the page.

use std::path::Path;

use clangor_pipeline::stages::sound_models::ModelOptions;
use serde_json::json;

use super::super::session::{StageBars, check_simulated, open, prepare, settings, warn_of_plates};
use super::super::{check_ending, is_timeline};
use crate::arguments::Global;
use crate::console::{Console, counted};
use crate::failure::Failure;

pub(super) fn run(
    input: &Path,
    output: Option<&Path>,
    models: ModelOptions,
    global: &Global,
    console: &Console,
) -> Result<(), Failure> {
    let output = output.map_or_else(|| input.with_extension("replay"), Path::to_path_buf);
    check_ending(&output, "replay")?;
    if !is_timeline(input) {
        return Err(Failure::new(format_args!(
            "{} is no timeline; clangor simulate {0} -o RUN.timeline makes one",
            input.display()
        )));
    }
    check_simulated(input, &[("--seed", global.seed.is_some())])?;
    let bars = StageBars::new(console);
    let mut session = open(input, settings(models, global), console, &bars)?;
    prepare(&mut session, console, &bars)?;
    warn_of_plates(&session, console);
    let exported = session.export_web(&output)?;
    bars.clear();
    let summary = exported.summary;
    console.say(format_args!(
        "{}: {}, {}, {}, {:.1} MB",
        output.display(),
        counted(summary.bodies, "body", "bodies"),
        counted(summary.sounds, "sound", "sounds"),
        counted(summary.events, "event", "events"),
        1e-6 * summary.bytes as f64,
    ));
    console.json(&json!({
        "replay": output.display().to_string(),
        "bodies": summary.bodies,
        "sounds": summary.sounds,
        "events": summary.events,
        "poses": summary.poses,
        "bytes": summary.bytes,
        "full_scale_pa": exported.full_scale,
    }));
    Ok(())
}
