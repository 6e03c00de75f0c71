//! `clangor render`: from a scene or a timeline to a WAV file.

use std::ops::ControlFlow;
use std::sync::Mutex;

use clangor_core::scene::render_description::Parts;
use clangor_pipeline::formats::wav::SampleFormat;
use clangor_pipeline::session::{Progress as SessionProgress, Session, SessionBuilder, Stage};
use clangor_pipeline::stages::fracture_report::FractureReport;
use clangor_pipeline::stages::render::{FullScale, Transfers};
use clangor_sim::SimulationReport;

use self::report::RenderReportView;
use super::audio_file::{is_gltf, modes_of_files};
use super::simulate::{breaking, say_simulated};
use super::sound_sources::give_models;
use super::{check_ending, is_timeline};
use crate::arguments::{Bits, Global, Render, RenderedPart, Transfer};
use crate::console::{Console, Progress};
use crate::diagnostics::draw_warning;
use crate::failure::Failure;

mod report;

pub(crate) fn run(options: &Render, global: &Global, console: &Console) -> Result<(), Failure> {
    let output = options.output.clone().unwrap_or_else(|| options.input.with_extension("wav"));
    check_ending(&output, "wav")?;
    if let Some(folder) = &options.timeline {
        check_ending(folder, "timeline")?;
    }
    if let Some(path) = &options.report {
        check_ending(path, "json")?;
    }
    let bars = StageBars::new(console);
    let mut session = open(options, global, console, &bars)?;
    // A long simulation is not begun for a sound that cannot be written.
    session.check_output(&output)?;
    let simulated = prepare(&mut session, options, console, &bars)?;
    let summary = session.render(&output)?.summary;
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

/// One progress bar at a time: that of the stage that a session is in.
pub(super) struct StageBars<'a> {
    console: &'a Console,
    bar: Mutex<Option<(Stage, Progress<'a>)>>,
}

impl<'a> StageBars<'a> {
    pub(super) fn new(console: &'a Console) -> Self {
        StageBars { console, bar: Mutex::new(None) }
    }

    /// Shows the progress; breaks once the person has pressed Ctrl-C.
    fn show(&self, progress: &SessionProgress<'_>) -> ControlFlow<()> {
        let Ok(mut bar) = self.bar.lock() else { return self.console.flow() };
        if bar.as_ref().is_none_or(|(stage, _)| *stage != progress.stage) {
            let what = match progress.stage {
                Stage::Simulation => "simulate",
                Stage::Acceleration => "bake",
                Stage::Modal => "modes",
                Stage::Render => "render",
            };
            *bar = None;
            *bar = Some((progress.stage, self.console.progress(what, 1.0)));
        }
        let Some((_, bar)) = &*bar else { return self.console.flow() };
        if matches!(progress.stage, Stage::Acceleration | Stage::Modal) {
            bar.stage(progress.step);
        }
        bar.reached(progress.done)
    }

    /// Removes the bar, before something is printed.
    pub(super) fn clear(&self) {
        if let Ok(mut bar) = self.bar.lock() {
            *bar = None;
        }
    }
}

/// Opens the scene or timeline with the settings of the command line, and prints its warnings.
pub(super) fn open<'a>(
    options: &Render,
    global: &Global,
    console: &Console,
    bars: &'a StageBars<'_>,
) -> Result<Session<'a>, Failure> {
    check_simulated(options, global)?;
    let session =
        settings(options, global).on_progress(|progress| bars.show(progress)).open(&options.input)?;
    if let Some(loaded) = session.scene() {
        for warning in &loaded.warnings {
            console.note(draw_warning(&options.input, &loaded.text, warning));
        }
    }
    if session.lacks_rolling() {
        console.warn(
            "nothing is known of gentle forces, and only impacts are heard: rolling needs the time-stepped \
             solver, and of a timeline its --raw-log",
        );
    }
    Ok(session)
}

/// Gives bodies the models of the command line, simulates or reads, and obtains the sound models.
pub(super) fn prepare(
    session: &mut Session<'_>,
    options: &Render,
    console: &Console,
    bars: &StageBars<'_>,
) -> Result<Option<SimulationReport>, Failure> {
    let (files, models): (Vec<_>, Vec<_>) =
        options.model.iter().cloned().partition(|(_, path)| is_gltf(path));
    let given_modes = modes_of_files(session.bodies_mut(), &files, console)?;
    let bodies = session.bodies().to_vec();
    give_models(session.plan(), &bodies, &models, console)?;
    for (copies, modes) in &given_modes {
        session.plan().give_modes(copies, &bodies[copies[0].index()], modes);
    }
    let simulated = session.simulate()?.cloned();
    bars.clear();
    if let Some(report) = &simulated {
        say_simulated(console, report);
    }
    let models = session.obtain_models()?;
    bars.clear();
    models.remarks.iter().for_each(|remark| console.warn(remark));
    Ok(simulated)
}

/// Rejects settings of the simulation of a timeline.
fn check_simulated(options: &Render, global: &Global) -> Result<(), Failure> {
    if !is_timeline(&options.input) {
        return Ok(());
    }
    let path = options.input.display();
    let settled = [
        ("--timeline", options.timeline.is_some()),
        ("--seed", global.seed.is_some()),
        ("--duration", options.duration.is_some()),
    ];
    match settled.into_iter().find(|(_, given)| *given) {
        Some((option, _)) => {
            let remedy =
                if option == "--duration" { "use --to for an earlier end" } else { "give the scene instead" };
            Err(Failure::new(format_args!(
                "{path} is simulated already, so {option} has no meaning; {remedy}"
            )))
        }
        None => Ok(()),
    }
}

/// The settings of the command line.
fn settings<'a>(options: &Render, global: &Global) -> SessionBuilder<'a> {
    let mut settings = Session::builder()
        .quality(options.quality.into())
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
    if let Some(folder) = &global.cache {
        settings = settings.cache(folder);
    }
    if let Some(rule) = options.sound {
        settings = settings.acceleration(rule.into());
    }
    let settings = match global.seed {
        Some(seed) => settings.seed(seed),
        None => settings,
    };
    let settings = match options.duration {
        Some(seconds) => settings.duration(seconds),
        None => settings,
    };
    let settings = match options.to {
        Some(end) => settings.to(end),
        None => settings,
    };
    let settings = match options.sample_rate {
        Some(hz) => settings.sample_rate(hz),
        None => settings,
    };
    match options.max_frequency {
        Some(hz) => settings.max_frequency(hz),
        None => settings,
    }
}
