//! `clangor render`: from a scene or a timeline to a WAV file.

use std::path::PathBuf;

use clangor_core::scene::render_description::Parts;
use clangor_pipeline::formats::wav::SampleFormat;
use clangor_pipeline::session::named_body::is_gltf;
use clangor_pipeline::session::{Session, SessionBuilder};
use clangor_pipeline::stages::fracture_report::FractureReport;
use clangor_pipeline::stages::render::{FullScale, Transfers};

use self::report::RenderReportView;
use super::audio_file::modes_of_files;
use super::session::{self, StageBars, check_simulated, open, prepare};
use super::simulate::breaking;
use super::sound_sources::give_models;
use super::{check_ending, is_timeline, refuse_overwriting};
use crate::arguments::{Bits, Global, Render, RenderedPart, Transfer};
use crate::console::{Console, counted};
use crate::failure::Failure;

mod report;

pub(crate) fn run(options: &Render, global: &Global, console: &Console) -> Result<(), Failure> {
    let output = options.output.clone().unwrap_or_else(|| options.input.with_extension("wav"));
    check_ending(&output, "wav")?;
    refuse_overwriting(&options.input, &output)?;
    if let Some(folder) = &options.timeline {
        check_ending(folder, "timeline")?;
    }
    if let Some(path) = &options.report {
        check_ending(path, "json")?;
        refuse_overwriting(&options.input, path)?;
    }
    check_saved_forces(options)?;
    let settled = [
        ("--timeline", options.timeline.is_some()),
        ("--seed", global.seed.is_some()),
        ("--duration", options.duration.is_some()),
    ];
    check_simulated(&options.input, &settled)?;
    let bars = StageBars::new(console);
    let mut session = open(&options.input, settings(options, global), console, &bars)?;
    // A long simulation is not begun for a sound that cannot be written.
    session.check_output(&output)?;
    give_known(&mut session, &options.model, console)?;
    let simulated = prepare(&mut session, console, &bars)?;
    let summary = session.render(&output)?.summary;
    if let Some(folder) = &options.save_forces {
        let count = session.save_forces(folder, options.force)? as usize;
        console.say(format_args!("{}: {}", folder.display(), counted(count, "force", "forces")));
    }
    bars.clear();
    let (Some(models), Some(timeline)) = (session.models(), session.timeline()) else { return Ok(()) };
    let bodies = session.bodies();
    let report = RenderReportView {
        bodies,
        models,
        summary: &summary,
        options: session.options(),
        simulated: simulated.as_ref(),
    };
    report.say(console);
    if !timeline.fractures.is_empty() || options.report.is_some() {
        let fractures = FractureReport::new(bodies, &timeline.fractures).with_ringing(bodies, models);
        let fractures = match &simulated {
            Some(report) => fractures.with_impacts(&report.breaking),
            None => fractures,
        };
        breaking::say_energies(console, &fractures.totals);
        if let Some(path) = &options.report {
            breaking::write(path, &fractures)?;
        }
    }
    if options.explain {
        report.explain(console);
    }
    report.print_json(console);
    Ok(())
}

/// Refuses a place for `--save-forces` before a long run.
fn check_saved_forces(options: &Render) -> Result<(), Failure> {
    let Some(folder) = &options.save_forces else { return Ok(()) };
    check_ending(folder, "timeline")?;
    if !is_timeline(&options.input) && options.timeline.is_none() {
        return Err(Failure::new("--save-forces needs a timeline: give --timeline RUN.timeline too"));
    }
    if folder.exists() && !options.force {
        return Err(Failure::new(format!("{} exists; --force replaces it", folder.display())));
    }
    Ok(())
}

/// Gives bodies the models of `--model`, by the names of the bodies.
fn give_known(
    session: &mut Session<'_>,
    given: &[(String, PathBuf)],
    console: &Console,
) -> Result<(), Failure> {
    let (files, models): (Vec<_>, Vec<_>) = given.iter().cloned().partition(|(_, path)| is_gltf(path));
    let given_modes = modes_of_files(session.bodies_mut(), &files, console)?;
    let bodies = session.bodies().to_vec();
    give_models(session.plan(), &bodies, &models, console)?;
    for (copies, modes) in &given_modes {
        session.plan().give_modes(copies, &bodies[copies[0].index()], modes);
    }
    Ok(())
}

/// The settings of the command line.
fn settings<'a>(options: &Render, global: &Global) -> SessionBuilder<'a> {
    let mut settings = session::settings(options.models.on(options.device.device), global)
        .stems(options.stems)
        .from(options.from.unwrap_or(0.0))
        .transfers(match options.transfer {
            Transfer::Baked => Transfers::Baked,
            Transfer::Frac => Transfers::Frac,
            Transfer::Unit => Transfers::Unit,
        });
    for position in &options.listener {
        settings = settings.listener(*position);
    }
    if !options.parts.is_empty() {
        let named = |part| options.parts.contains(&part);
        settings = settings.parts(Parts {
            acceleration: named(RenderedPart::Acceleration),
            modal: named(RenderedPart::Modal),
            ground: named(RenderedPart::Ground),
        });
    }
    let full_scale = options.full_scale.map(FullScale::Pascals);
    if let Some(full_scale) = full_scale.or(options.normalize.map(FullScale::Peak)) {
        settings = settings.full_scale(full_scale);
    }
    if let Some(bits) = options.bits {
        settings = settings.format(match bits {
            Bits::Float32 => SampleFormat::Float32,
            Bits::Integer24 => SampleFormat::Pcm24,
        });
    }
    if let Some(folder) = &options.timeline {
        settings = settings.keep_timeline(folder, options.force);
    }
    if let Some(rule) = options.sound {
        settings = settings.acceleration(rule.into());
    }
    let settings = match options.duration {
        Some(seconds) => settings.duration(seconds),
        None => settings,
    };
    let settings = match options.to {
        Some(end) => settings.to(end),
        None => settings,
    };
    match options.sample_rate {
        Some(hz) => settings.sample_rate(hz),
        None => settings,
    }
}
