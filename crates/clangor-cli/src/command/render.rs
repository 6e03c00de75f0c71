//! `clangor render`: from a scene or a timeline to a WAV file.

use std::collections::BTreeSet;
use std::path::Path;

use clangor_core::acoustics::Acoustics;
use clangor_core::body::{Body, BodyId};
use clangor_core::contact::ContactSettings;
use clangor_core::glam::DVec3;
use clangor_core::pose::{Pose, Track};
use clangor_core::scene::Scene;
use clangor_core::scene::diagnostic::Place;
use clangor_core::scene::listener::ListenerDescription;
use clangor_core::scene::render_description as scene_render;
use clangor_core::scene::simulation_description::SolverChoice;
use clangor_core::sound_model::SoundRule;
use clangor_core::synthesis::{Listener, RenderSettings, SampleRate};
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::formats::wav::{SampleFormat, WavSpec};
use clangor_pipeline::stages::fracture_report::FractureReport;
use clangor_pipeline::stages::load::LoadedScene;
use clangor_pipeline::stages::render::{
    FullScale, RenderOptions, Transfers, check_output, read_impacts, render,
};
use clangor_pipeline::stages::simulate::{simulate_and_keep, simulate_impacts, solver};
use clangor_pipeline::stages::sound_models::{SoundModelPlan, SoundModelSettings, SoundModels};
use clangor_sim::SimulationReport;

use self::report::RenderReportView;
use super::audio_file::{is_gltf, modes_of_files};
use super::simulate::{breaking, say_simulated};
use super::sound_sources::{find_models, give_models, model_settings};
use super::{check_ending, is_timeline, load};
use crate::arguments::{Bits, Global, Render, RenderedPart, Transfer};
use crate::console::Console;
use crate::failure::Failure;

mod report;

/// What is rendered, and what the scene says about how.
struct Source {
    motion: Recorded,
    /// Those that are there from the beginning, until it is known what broke.
    bodies: Vec<Body>,
    acoustics: Acoustics,
    listeners: Vec<Listener>,
    settings: scene_render::RenderDescription,
    /// What the scene says that its bodies sound as.
    rules: Vec<SoundRule>,
    v_min: f64,
    /// Time step \[s\], if the dynamics tell all forces.
    time_step: Option<f64>,
    duration: f64,
}

/// Where the impacts come from.
enum Recorded {
    /// They are still to be simulated.
    Scene(Box<LoadedScene>),
    Timeline(Box<TimelineReader>),
}

pub(crate) fn run(options: &Render, global: &Global, console: &Console) -> Result<(), Failure> {
    let output = options.output.clone().unwrap_or_else(|| options.input.with_extension("wav"));
    check_ending(&output, "wav")?;
    if let Some(folder) = &options.timeline {
        check_ending(folder, "timeline")?;
    }
    if let Some(path) = &options.report {
        check_ending(path, "json")?;
    }
    let prepared = prepare(options, Some(&output), global, console)?;
    let Prepared { bodies, options: render_options, models, timeline, simulated, .. } = &prepared;
    let progress = console.progress("render", 1.0);
    let mut on_progress = |part| progress.reached(part);
    let summary = render(bodies, &models.bodies, timeline, render_options, &output, &mut on_progress)?;
    drop(progress);
    let report = RenderReportView {
        bodies,
        models,
        summary: &summary,
        options: render_options,
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

/// What is to be heard, and everything that sounds in it.
pub(super) struct Prepared {
    /// All that ever were.
    pub(super) bodies: Vec<Body>,
    pub(super) options: RenderOptions,
    pub(super) models: SoundModels,
    pub(super) timeline: Timeline,
    pub(super) simulated: Option<SimulationReport>,
}

/// Simulates or reads, and finds or bakes what sounds; files are to be written to `output`, if any.
pub(super) fn prepare(
    options: &Render,
    output: Option<&Path>,
    global: &Global,
    console: &Console,
) -> Result<Prepared, Failure> {
    let mut source = if is_timeline(&options.input) {
        from_timeline(options, global)?
    } else {
        from_scene(options, global, console)?
    };
    let render_options = render_options(options, &source)?;
    if source.settings.rolling && render_options.rolling.is_none() {
        console.warn(
            "nothing is known of gentle forces, and only impacts are heard: rolling needs the time-stepped solver, and of a timeline \
             its --raw-log",
        );
    }
    // A long simulation is not begun for a sound that cannot be written.
    match output {
        Some(output) => check_output(&render_options, &source.bodies, output)?,
        None => render_options.check_sound()?,
    }
    let (files, models): (Vec<_>, Vec<_>) =
        options.model.iter().cloned().partition(|(_, path)| is_gltf(path));
    let given_modes = modes_of_files(&mut source.bodies, &files, console)?;
    let parts = render_options.parts;
    let both =
        model_settings(options.quality.into(), source.settings.proxy_frequency, &render_options.synthesis);
    let settings = SoundModelSettings {
        wants_acceleration: parts.acceleration,
        modal: both.modal.filter(|_| parts.modal),
        ..both
    };
    let mut plan = SoundModelPlan::new(&source.bodies, &source.rules, settings);
    if let Some(sound) = options.sound {
        plan = plan.with_acceleration_rule(sound.into());
    }
    give_models(&mut plan, &source.bodies, &models, console)?;
    for (copies, modes) in &given_modes {
        plan.give_modes(copies, &source.bodies[copies[0].index()], modes);
    }
    let followed = plan.followed();
    let (timeline, simulated) =
        impacts(&source.motion, &followed, render_options.rolling.is_some(), options, console)?;
    source.bodies = timeline.all_bodies(&source.bodies);
    let struck: BTreeSet<BodyId> = timeline.contacts.iter().flat_map(|r| [r.body_a, r.body_b]).collect();
    let models = find_models(plan, &source.bodies, &struck, global, console)?;
    Ok(Prepared { bodies: source.bodies, options: render_options, models, timeline, simulated })
}

/// Loads a scene; nothing moves yet.
fn from_scene(options: &Render, global: &Global, console: &Console) -> Result<Source, Failure> {
    let asked = asked_listeners(options);
    let adjust = |scene: &mut Scene| {
        scene.simulation.duration = options.duration.unwrap_or(scene.simulation.duration);
        if !asked.is_empty() {
            scene.listeners.clone_from(&asked);
        }
    };
    let loaded = load(&options.input, global, &adjust, console)?;
    let scene = &loaded.scene;
    Ok(Source {
        bodies: loaded.world.bodies.clone(),
        acoustics: scene.acoustics,
        listeners: scene.listeners.iter().map(receivers).collect(),
        v_min: scene.simulation.v_min,
        time_step: Some(scene.simulation.time_step).filter(|_| solver(&loaded) == SolverChoice::Rigid),
        duration: scene.simulation.duration,
        settings: scene.render.clone(),
        rules: scene.sound_rules(),
        motion: Recorded::Scene(Box::new(loaded)),
    })
}

/// Opens a timeline; the scene in it says who listens and how.
fn from_timeline(options: &Render, global: &Global) -> Result<Source, Failure> {
    let path = options.input.display();
    let settled = [
        ("--timeline", options.timeline.is_some()),
        ("--seed", global.seed.is_some()),
        ("--duration", options.duration.is_some()),
    ];
    if let Some((option, _)) = settled.into_iter().find(|(_, given)| *given) {
        let remedy =
            if option == "--duration" { "use --to for an earlier end" } else { "give the scene instead" };
        return Err(Failure::new(format_args!(
            "{path} is simulated already, so {option} has no meaning; {remedy}"
        )));
    }
    let reader = TimelineReader::open(&options.input).map_err(Failure::new)?;
    let header = reader.header();
    let scene = match header.scene.as_deref().map(Scene::from_toml) {
        Some(Ok(scene)) => Some(scene),
        Some(Err(errors)) => {
            return Err(Failure::new(format_args!("{path}: the scene in timeline.json is wrong:\n{errors}")));
        }
        None => None,
    };
    let asked = asked_listeners(options);
    let listeners = match &scene {
        Some(scene) if asked.is_empty() => &scene.listeners,
        _ => &asked,
    };
    Ok(Source {
        bodies: header.world.bodies.clone(),
        acoustics: Acoustics {
            medium: header.medium,
            ..scene.as_ref().map(|s| s.acoustics).unwrap_or_default()
        },
        listeners: listeners.iter().map(receivers).collect(),
        v_min: header.origin.v_min,
        time_step: Some(header.origin.time_step).filter(|step| *step > 0.0 && header.origin.raw_log),
        duration: header.origin.duration,
        rules: scene.as_ref().map(Scene::sound_rules).unwrap_or_default(),
        settings: scene.map(|s| s.render).unwrap_or_default(),
        motion: Recorded::Timeline(Box::new(reader)),
    })
}

/// The impacts and the poses at them, and all poses of those that are `followed`; of a scene also how its
/// simulation went.
fn impacts(
    motion: &Recorded,
    followed: &BTreeSet<BodyId>,
    rolling: bool,
    options: &Render,
    console: &Console,
) -> Result<(Timeline, Option<SimulationReport>), Failure> {
    let loaded = match motion {
        Recorded::Scene(loaded) => loaded,
        Recorded::Timeline(reader) => {
            let timeline = read_impacts(reader, followed, rolling).map_err(Failure::new)?;
            return Ok((timeline, None));
        }
    };
    let progress = console.progress("simulate", loaded.scene.simulation.duration);
    let reached = &mut |t| progress.reached(t);
    let (timeline, report) = match &options.timeline {
        Some(folder) => simulate_and_keep(loaded, followed, folder, options.force, reached)?,
        None => simulate_impacts(loaded, followed, reached)?,
    };
    drop(progress);
    say_simulated(console, &report);
    Ok((timeline, Some(report)))
}

/// The listeners of the command line.
fn asked_listeners(options: &Render) -> Vec<ListenerDescription> {
    let listener = |(index, position): (usize, &DVec3)| ListenerDescription {
        name: format!("listener-{}", index + 1),
        track: Track::fixed(Pose::at(*position)),
        spacing: None,
        place: Place {
            field: format!("--listener {},{},{}", position.x, position.y, position.z),
            ..Place::default()
        },
    };
    options.listener.iter().enumerate().map(listener).collect()
}

fn receivers(listener: &ListenerDescription) -> Listener {
    Listener { name: listener.name.clone(), track: listener.track.clone(), receivers: listener.receivers() }
}

/// Least `--max-frequency`, as in a scene \[Hz\].
const LOWEST_BAND_LIMIT: f64 = 100.0;

/// The scene's settings under those of the command line.
fn render_options(options: &Render, source: &Source) -> Result<RenderOptions, Failure> {
    let settings = &source.settings;
    let format = match (options.bits, settings.bits) {
        (Some(Bits::Float32), _) | (None, scene_render::SampleFormat::Float32) => SampleFormat::Float32,
        (Some(Bits::Integer24), _) | (None, scene_render::SampleFormat::Int24) => SampleFormat::Pcm24,
    };
    let full_scale = match (options.full_scale, options.normalize, settings.level) {
        (Some(pressure), _, _) => FullScale::Pascals(pressure),
        (_, Some(level), _) => FullScale::Peak(level),
        (_, _, scene_render::Level::Default) => FullScale::Pascals(WavSpec::default_full_scale(format)),
        (_, _, scene_render::Level::FullScale(pressure)) => FullScale::Pascals(pressure),
        (_, _, scene_render::Level::Normalize(level)) => FullScale::Peak(level),
    };
    let sample_rate =
        SampleRate::try_new(options.sample_rate.unwrap_or(settings.sample_rate)).map_err(Failure::new)?;
    let nyquist = 0.5 * sample_rate.as_f64();
    if let Some(hz) = options.max_frequency.filter(|hz| !(LOWEST_BAND_LIMIT..=nyquist).contains(hz)) {
        return Err(Failure::new(format_args!(
            "--max-frequency {hz} is outside {LOWEST_BAND_LIMIT} Hz to half the sample rate, {nyquist} Hz"
        )));
    }
    Ok(RenderOptions {
        listeners: source.listeners.clone(),
        contact: ContactSettings {
            v_min: source.v_min,
            profile: settings.pulse,
            chain_onset: settings.chain_onset,
        },
        synthesis: RenderSettings {
            sample_rate,
            start: options.from.unwrap_or(0.0),
            acoustics: Acoustics {
                max_frequency: options.max_frequency.or(source.acoustics.max_frequency),
                ..source.acoustics
            },
            sphere_model: settings.radiation,
            ..RenderSettings::default()
        },
        parts: match options.parts.is_empty() {
            true => settings.parts,
            false => {
                let named = |part| options.parts.contains(&part);
                scene_render::Parts {
                    acceleration: named(RenderedPart::Acceleration),
                    modal: named(RenderedPart::Modal),
                    ground: named(RenderedPart::Ground),
                }
            }
        },
        transfers: match options.transfer {
            Transfer::Baked => Transfers::Baked,
            Transfer::Frac => Transfers::Frac,
            Transfer::Unit => Transfers::Unit,
        },
        ground: settings.ground,
        limit_energy: settings.limit_energy,
        inherit_vibration: settings.inherit_vibration,
        rolling: source.time_step.filter(|_| settings.rolling),
        to: options.to.unwrap_or(source.duration),
        format,
        full_scale,
        compressor: settings.compressor,
        stems: options.stems,
        note: options.input.display().to_string(),
    })
}
