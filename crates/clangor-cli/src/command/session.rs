//! A session of the library on the command line: settings common to commands, warnings, progress bars.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Mutex;

use clangor_core::body::{Body, Surface};
use clangor_pipeline::session::{Progress as SessionProgress, Session, SessionBuilder, Stage};
use clangor_pipeline::stages::sound_models::ModelOptions;
use clangor_sim::SimulationReport;

use super::simulate::say_simulated;
use super::{collision_parts, drafts, is_timeline};
use crate::arguments::Global;
use crate::console::{Console, Progress};
use crate::diagnostics::draw_warnings;
use crate::failure::Failure;

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
    pub(super) fn show(&self, progress: &SessionProgress<'_>) -> ControlFlow<()> {
        let Ok(mut bar) = self.bar.lock() else { return self.console.flow() };
        if bar.as_ref().is_none_or(|(stage, _)| *stage != progress.stage) {
            let what = match progress.stage {
                Stage::Simulation => "simulate",
                Stage::Acceleration => "bake",
                Stage::Modal => "modes",
                Stage::Render => "render",
                Stage::Level => "measure_peak",
                Stage::Playback => "play",
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

/// The settings that every command with a session has.
pub(super) fn settings<'a>(models: ModelOptions, global: &Global) -> SessionBuilder<'a> {
    let mut settings = Session::builder().models(models);
    if let Some(folder) = &global.cache {
        settings = settings.cache(folder);
    }
    match global.seed {
        Some(seed) => settings.seed(seed),
        None => settings,
    }
}

/// Opens the scene or timeline, and prints its warnings.
pub(super) fn open<'a>(
    input: &Path,
    settings: SessionBuilder<'a>,
    console: &Console,
    bars: &'a StageBars<'_>,
) -> Result<Session<'a>, Failure> {
    let session = settings.on_progress(|progress| bars.show(progress)).open(input)?;
    if let Some(loaded) = session.scene() {
        for drawn in draw_warnings(input, &loaded.text, loaded.warnings.iter()) {
            console.drawn(drawn);
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

/// Warns of endless plates, whose sound real time leaves out.
pub(super) fn warn_of_plates(session: &Session<'_>, console: &Console) {
    let is_plate = |body: &&Body| matches!(*body.surface, Surface::Plate { .. });
    if let Some(plate) = session.bodies().iter().find(is_plate) {
        console.warn(format_args!(
            "the sound of \"{}\", a plane with a thickness, is left out in real time; clangor render has it",
            plate.name
        ));
    }
}

/// Simulates or reads the motion, obtains the sound models, and prints what is to be known about both.
pub(super) fn prepare(
    session: &mut Session<'_>,
    console: &Console,
    bars: &StageBars<'_>,
) -> Result<Option<SimulationReport>, Failure> {
    let simulated = session.simulate()?.cloned();
    bars.clear();
    if let Some(loaded) = session.scene() {
        collision_parts::say(loaded, console);
    }
    if let Some(report) = &simulated {
        say_simulated(console, report);
    }
    let models = session.obtain_models()?;
    bars.clear();
    models.remarks.iter().for_each(|remark| console.warn(remark));
    drafts::say(session, console);
    Ok(simulated)
}

/// Rejects options of the simulation, with whether they are given, for a timeline.
pub(super) fn check_simulated(input: &Path, options: &[(&str, bool)]) -> Result<(), Failure> {
    if !is_timeline(input) {
        return Ok(());
    }
    let path = input.display();
    match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => {
            let remedy = if *option == "--duration" {
                "use --to for an earlier end"
            } else {
                "give the scene instead"
            };
            Err(Failure::new(format_args!(
                "{path} is simulated already, so {option} has no meaning; {remedy}"
            )))
        }
        None => Ok(()),
    }
}
