//! `clangor export web`: a finished run for the page.

use std::path::Path;

use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::formats::web_replay::{Replay, write_replay};
use clangor_pipeline::stages::event_schedule::EventSchedule;
use clangor_pipeline::stages::event_schedule::event_feeder::measure_peak;
use clangor_pipeline::stages::render::{Transfers, modal_sources};
use serde_json::json;

use super::super::render::{StageBars, open, prepare};
use super::super::sound_sources::own_model;
use super::super::{check_ending, is_timeline};
use crate::arguments::{Global, Quality, Render};
use crate::console::{Console, counted};
use crate::failure::Failure;

/// A scene of nothing: still air, no room.
const EMPTY_SCENE: &str = "version = 1\n";

pub(super) fn run(
    input: &Path,
    output: Option<&Path>,
    (quality, max_frequency): (Quality, Option<f64>),
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
    let asked = Render { quality, max_frequency, ..Render::of(input) };
    let bars = StageBars::new(console);
    let mut session = open(&asked, global, console, &bars)?;
    prepare(&mut session, &asked, console, &bars)?;
    let Some(models) = session.models() else { return Ok(()) };
    let (bodies, options) = (session.bodies(), session.options());
    let reader = TimelineReader::open(input).map_err(Failure::new)?;
    let timeline = reader.read_all().map_err(Failure::new)?;
    let ringing = modal_sources(bodies, &models.bodies, Transfers::Baked).map_err(Failure::new)?;
    let score =
        EventSchedule::new(bodies, &models.bodies, &ringing, &timeline, options).map_err(Failure::new)?;
    let Some(listener) = options.listeners.first() else { return Err(Failure::new("there is no listener")) };
    let settings = score.engine_settings(options, listener, options.synthesis.sample_rate);
    let (mut controller, mut engine) =
        score.engine(&models.bodies, &ringing, &settings).map_err(Failure::new)?;
    let progress = console.progress("measure_peak", options.to);
    let mut on_progress = |time| progress.reached(time);
    let both = (&mut controller, &mut engine);
    let loudest = measure_peak(&score, listener, (0.0, options.to), both, &mut on_progress)
        .ok_or(Failure::Interrupted)?;
    drop(progress);
    let bank = default_bank();
    let replay = Replay {
        bodies,
        ringing: &ringing,
        limit_energy: options.limit_energy,
        timeline: &timeline,
        clicks: options.parts.acceleration,
        models: &models.bodies,
        own_model: &|id| own_model(&bodies[id.index()], quality.into(), &options.synthesis, global),
        bank: bank.as_ref(),
        max_wavenumber: options.synthesis.max_wavenumber(),
        contact: &options.contact,
        listeners: &options.listeners,
        scene: reader.header().scene.as_deref().unwrap_or(EMPTY_SCENE),
        duration: options.to,
        full_scale: if loudest > 0.0 { 2.0 * loudest } else { 1.0 },
    };
    let summary = write_replay(&replay, &output).map_err(Failure::new)?;
    console.say(format_args!(
        "{}: {}, {}, {}, {:.1} MB",
        output.display(),
        counted(summary.bodies, "body", "bodies"),
        counted(summary.sounds, "sound", "sounds"),
        counted(summary.events, "event", "events"),
        1e-6 * summary.bytes as f64,
    ));
    console.json(&json!({
        "replay": output,
        "bodies": summary.bodies,
        "sounds": summary.sounds,
        "events": summary.events,
        "poses": summary.poses,
        "bytes": summary.bytes,
        "full_scale_pa": replay.full_scale,
    }));
    Ok(())
}
