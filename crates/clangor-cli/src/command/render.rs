//! `clangor render`: from a scene or a timeline to a WAV file.

use clangor::body::{Body, Surface};
use clangor::contact::ContactSettings;
use clangor::medium::Medium;
use clangor::scene::Scene;
use clangor::scene::render_settings as scene_render;
use clangor::synthesis::{Listener, RenderSettings, SampleRate};
use clangor::timeline::Timeline;
use clangor_pipeline::render::{FullScale, RenderOptions, read_impacts, render};
use clangor_pipeline::simulate::{simulate_impacts, simulate_to_folder};
use clangor_pipeline::timeline_file::TimelineReader;
use clangor_pipeline::wav::{SampleFormat, WavSpec};

use super::simulate::say_simulated;
use super::{is_timeline, load};
use crate::arguments::{Bits, Global, Render};
use crate::console::Console;
use crate::failure::Failure;

mod report;

/// What is rendered, and what the scene says about how.
struct Source {
    bodies: Vec<Body>,
    timeline: Timeline,
    medium: Medium,
    listeners: Vec<Listener>,
    settings: scene_render::RenderSettings,
    v_min: f64,
    duration: f64,
}

pub(crate) fn run(options: &Render, global: &Global, console: &Console) -> Result<(), Failure> {
    let source = if is_timeline(&options.input) {
        from_timeline(options)?
    } else {
        from_scene(options, global, console)?
    };
    let output = options.output.clone().unwrap_or_else(|| options.input.with_extension("wav"));
    if output.extension().is_none_or(|e| e != "wav") {
        return Err(Failure::new(format_args!("{}: the output must end in .wav", output.display())));
    }
    let render_options = render_options(options, &source)?;
    for body in source.bodies.iter().filter(|b| sounds_as_sphere(b)).take(1) {
        console.warn(format_args!(
            "bodies that are not spheres (\"{}\" …) sound as the sphere of equal volume, and do not ring",
            body.name
        ));
    }
    let passes = render_options.listeners.len() as f64;
    let progress = console.progress("render", passes * (render_options.to - render_options.synthesis.start));
    let summary =
        render(&source.bodies, &source.timeline, &render_options, &output, &mut |t| progress.reached(t))?;
    drop(progress);
    report::say(console, &source.bodies, &summary);
    if options.explain {
        report::explain(console, &source.bodies, &summary);
    }
    report::print_json(console, &source.bodies, &summary);
    Ok(())
}

/// A body whose own field is not known.
fn sounds_as_sphere(body: &Body) -> bool {
    matches!(&*body.surface, Surface::Mesh(_)) && body.motion == clangor::body::Motion::Free
}

/// Simulates a scene.
fn from_scene(options: &Render, global: &Global, console: &Console) -> Result<Source, Failure> {
    let adjust = |scene: &mut Scene| {
        scene.simulation.duration = options.duration.unwrap_or(scene.simulation.duration);
    };
    let loaded = load(&options.input, global, &adjust, console)?;
    let progress = console.progress("simulate", loaded.scene.simulation.duration);
    let (timeline, report) = match &options.timeline {
        Some(folder) => {
            let (timeline, report, _) =
                simulate_to_folder(&loaded, false, folder, options.force, &mut |t| progress.reached(t))?;
            (timeline, report)
        }
        None => simulate_impacts(&loaded, &mut |t| progress.reached(t))?,
    };
    drop(progress);
    say_simulated(console, &report);
    let scene = loaded.scene;
    Ok(Source {
        bodies: loaded.world.bodies,
        timeline,
        medium: scene.medium,
        listeners: scene_listeners(&scene),
        v_min: scene.simulation.v_min,
        duration: scene.simulation.duration,
        settings: scene.render,
    })
}

/// Reads a timeline; the scene in it says who listens and how.
fn from_timeline(options: &Render) -> Result<Source, Failure> {
    let reader = TimelineReader::open(&options.input).map_err(Failure::new)?;
    let header = reader.header();
    let scene = header.scene.as_deref().and_then(|text| Scene::from_toml(text).ok());
    Ok(Source {
        bodies: header.world.bodies.clone(),
        timeline: read_impacts(&reader).map_err(Failure::new)?,
        medium: header.medium,
        listeners: scene.as_ref().map(scene_listeners).unwrap_or_default(),
        v_min: header.origin.v_min,
        duration: options.duration.unwrap_or(header.origin.duration),
        settings: scene.map(|s| s.render).unwrap_or_default(),
    })
}

fn scene_listeners(scene: &Scene) -> Vec<Listener> {
    let listener = |l: &clangor::scene::listener::Listener| Listener {
        name: l.name.clone(),
        track: l.track.clone(),
        receivers: l.receivers(),
    };
    scene.listeners.iter().map(listener).collect()
}

/// The scene's settings under those of the command line.
fn render_options(options: &Render, source: &Source) -> Result<RenderOptions, Failure> {
    let settings = &source.settings;
    let named = |(i, position)| Listener::fixed(format!("listener-{}", i + 1), position);
    let listeners = if options.listener.is_empty() {
        source.listeners.clone()
    } else {
        options.listener.iter().copied().enumerate().map(named).collect()
    };
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
    let sample_rate = options.sample_rate.unwrap_or(settings.sample_rate);
    Ok(RenderOptions {
        listeners,
        contact: ContactSettings {
            v_min: source.v_min,
            profile: settings.pulse,
            chain_onset: settings.chain_onset,
        },
        synthesis: RenderSettings {
            sample_rate: SampleRate::try_new(sample_rate).map_err(Failure::new)?,
            start: options.from.unwrap_or(0.0),
            medium: source.medium,
            floor: settings.floor,
            max_frequency: settings.max_frequency,
            sphere_model: settings.radiation,
        },
        to: options.to.unwrap_or(source.duration),
        format,
        full_scale,
        compressor: settings.compressor,
        stems: options.stems,
        note: options.input.display().to_string(),
    })
}
