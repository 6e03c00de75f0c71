//! `clangor strike`: one impact to one body, heard by one listener.

use std::collections::BTreeSet;
use std::path::Path;
use std::slice;
use std::sync::Arc;

use clangor_core::acoustics::Acoustics;
use clangor_core::body::{Body, BodyId, MeshSurface, Surface};
use clangor_core::contact::force_profile::ForceProfile;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::material::Material;
use clangor_core::medium::Medium;
use clangor_core::reference::PanSource;
use clangor_core::scene::instantiate::LoadedGeometry;
use clangor_core::scene::render_description::PROXY_FREQUENCY;
use clangor_core::sound_model::acceleration::model_evaluator::ModelEvaluator;
use clangor_core::sound_model::acceleration::sphere_radiation::SphereModel;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::sound_model::{BodyModes, SoundModel};
use clangor_core::synthesis::modal::{ModalSettings, ModalSource};
use clangor_core::synthesis::source_rule::{Decision, Reason, SourceKind, source_of};
use clangor_core::synthesis::strike::{LEAD, Strike as StrikeSpec, StrikeSound, strike, struck_ringing};
use clangor_core::synthesis::{RenderSettings, SampleRate, SoundSource};
use clangor_pipeline::analysis::levels::db_spl;
use clangor_pipeline::formats::atomic_file::write_atomically;
use clangor_pipeline::formats::wav::{Meaning, SampleFormat, WavSpec, WavWriter};
use clangor_pipeline::session::strike::{SHORTEST, cut_silence, decay_time};
use clangor_pipeline::stages::load::{geometry_reference, load_geometry};
use clangor_pipeline::stages::sound_models::{
    SoundFile, SoundModelPlan, SoundModelSettings, read_sound_file,
};
use serde_json::json;

use super::audio_file::{AudioInput, audio_input};
use super::bake::preset;
use super::sound_sources::{find_models, model_settings, warn_of_other_material};
use crate::arguments::{Global, Part, Strike};
use crate::console::{Console, four_digits};
use crate::failure::Failure;

pub(crate) fn run(options: &Strike, global: &Global, console: &Console) -> Result<(), Failure> {
    let StrikeTarget { body, model, modes } = body(options, console)?;
    let wants = |part| options.parts.contains(&part);
    let impact = StrikeSpec {
        impulse: options.impulse,
        point: options.point,
        listener: options.listener,
        duration: options.duration,
        profile: ForceProfile::HalfSine,
        sample_rate: SampleRate::try_new(options.sample_rate).map_err(Failure::new)?,
        seconds: Some(options.seconds.unwrap_or(SHORTEST)),
        medium: Medium::AIR,
        sphere_model: SphereModel::Exact,
    };
    // What clicks in the place of a body whose click is not wanted: nothing that a listener could be inside
    // of.
    let point = SoundSource::Sphere { radius: 1e-6 * body.surface.bounding_radius() };
    // A mistaken impact is told before anything is baked.
    strike(&body, &point, &impact).map_err(Failure::new)?;
    let ringing = match wants(Part::Modal) {
        true => ringing(&body, model.as_ref(), modes, &impact, options, (global, console))?,
        false => None,
    };
    let impact = StrikeSpec {
        seconds: options.seconds.or(Some(ringing.as_ref().map_or(SHORTEST, |(_, seconds)| *seconds))),
        ..impact
    };
    let source = match wants(Part::Acceleration) {
        true => source(&body, model.as_ref(), &impact, options, global, console)?,
        false => point,
    };
    let mut sound = strike(&body, &source, &impact).map_err(Failure::new)?;
    if !wants(Part::Acceleration) {
        sound.pressures.fill(0.0);
    }
    let mut modes = 0;
    if let Some((source, _)) = ringing {
        modes = source.resonances().len();
        let ringing = struck_ringing(&body, source, &impact, &sound).map_err(Failure::new)?;
        sound.pressures.iter_mut().zip(ringing).for_each(|(sum, p)| *sum += p);
        if options.seconds.is_none() {
            cut_silence(&mut sound, options.sample_rate);
        }
    }
    let peak = sound.pressures.iter().fold(0.0f64, |m, p| m.max(p.abs()));
    write(options, &body.material.name, &sound)?;
    if peak == 0.0 {
        console.warn(format_args!(
            "{} is silent: sound needs {:.4} s to the listener, so raise --seconds",
            options.output.display(),
            options.listener.length() / Medium::AIR.sound_speed
        ));
    }
    console.say(format_args!(
        "{}: contact {:.2} µs, velocity change {:.4} m/s, peak {} Pa ({} dB SPL)",
        options.output.display(),
        sound.duration * 1e6,
        sound.velocity_change.length(),
        four_digits(peak),
        db_spl(peak).map_or("−∞".into(), |db| format!("{db:.1}")),
    ));
    console.json(&json!({
        "contact_duration_s": sound.duration,
        "velocity_change_m_per_s": sound.velocity_change.to_array(),
        "radius_m": sound.radius,
        "peak_pa": peak,
        "modes": modes,
        "samples": sound.pressures.len(),
    }));
    Ok(())
}

/// Writes the sound as WAV, or as a table of times and pressures.
fn write(options: &Strike, material: &str, sound: &StrikeSound) -> Result<(), Failure> {
    match options.output.extension().and_then(|e| e.to_str()) {
        Some("csv") => {
            let mut text = String::from("time_s,pressure_pa\n");
            for (time, pressure) in sound.times.iter().zip(&sound.pressures) {
                text.push_str(&format!("{time:.9e},{pressure:.9e}\n"));
            }
            write_atomically(&options.output, text.as_bytes()).map_err(Failure::new)?;
        }
        Some("wav") => {
            let spec = WavSpec {
                sample_rate: options.sample_rate,
                channels: 1,
                format: SampleFormat::Float32,
                full_scale: WavSpec::default_full_scale(SampleFormat::Float32),
                meaning: Meaning::Pressure,
                note: format!("{} of {}, begins {LEAD} s before the contact", options.body, material),
            };
            let samples: Vec<f32> = sound.pressures.iter().map(|p| *p as f32).collect();
            let mut file = WavWriter::create(&options.output, spec).map_err(Failure::new)?;
            file.write(&samples).map_err(Failure::new)?;
            file.finish().map_err(Failure::new)?;
        }
        _ => return Err(Failure::new("the output must end in .wav or .csv")),
    }
    Ok(())
}

/// The modes of the struck body, out of its model, or found or baked; and the time in which the longest has
/// died away \[s\].
fn ringing(
    body: &Body,
    file: Option<&SoundFile>,
    given: Option<ModalModel>,
    impact: &StrikeSpec,
    options: &Strike,
    (global, console): (&Global, &Console),
) -> Result<Option<(Arc<ModalSource>, f64)>, Failure> {
    let (part, is_file) = match file {
        Some(SoundFile::Model(file)) => (file.modal.as_ref(), true),
        Some(SoundFile::Modal(file)) => (Some(&file.modal), true),
        Some(SoundFile::Pan(_)) => (None, true),
        Some(SoundFile::Bank(_) | SoundFile::ModalSoundbank(_)) | None => (None, false),
    };
    let model = match part {
        Some(part) => {
            warn_of_other_material(&body.material, part, console);
            Arc::new(part.model.clone())
        }
        // What a model does not have is not wanted.
        None if is_file => return Ok(None),
        None => {
            let settings = settings(options, impact);
            let settings = SoundModelSettings { wants_acceleration: false, ..settings };
            match found_model(body, settings, given, options, (global, console))?.modal {
                BodyModes::Own(model) => model,
                other => {
                    console.say(format_args!("\"{}\": {other}", options.body));
                    return Ok(None);
                }
            }
        }
    };
    let source = ModalSource::new(model, &body.material.damping, &ModalSettings::default())
        .map_err(|e| Failure::new(format_args!("the modes of \"{}\" cannot be played: {e}", options.body)))?;
    let seconds = decay_time(&source, impact);
    Ok(Some((Arc::new(source), seconds)))
}

/// How the model of the struck body is baked.
fn settings(options: &Strike, impact: &StrikeSpec) -> SoundModelSettings {
    model_settings(options.quality.into(), PROXY_FREQUENCY, &render_settings(impact))
}

/// The model of the struck body, found or baked.
fn found_model(
    body: &Body,
    settings: SoundModelSettings,
    known_modes: Option<ModalModel>,
    options: &Strike,
    (global, console): (&Global, &Console),
) -> Result<SoundModel, Failure> {
    let bodies = slice::from_ref(body);
    let mut plan = SoundModelPlan::new(bodies, &[], settings).with_acceleration_rule(options.sound.into());
    if let Some(modes) = known_modes {
        plan.give_modes(&[BodyId(0)], body, &modes);
    }
    let struck = BTreeSet::from([BodyId(0)]);
    Ok(find_models(plan, bodies, &struck, global, console)?.bodies.swap_remove(0))
}

/// How the impact is rendered.
fn render_settings(impact: &StrikeSpec) -> RenderSettings {
    RenderSettings {
        sample_rate: impact.sample_rate,
        start: 0.0,
        acoustics: Acoustics { medium: impact.medium, ..Acoustics::default() },
        sphere_model: impact.sphere_model,
        ..RenderSettings::default()
    }
}

/// What the struck body sounds as: the model that was given, or what is found or baked for it.
fn source(
    body: &Body,
    model: Option<&SoundFile>,
    impact: &StrikeSpec,
    options: &Strike,
    global: &Global,
    console: &Console,
) -> Result<SoundSource, Failure> {
    let band = render_settings(impact).band().0;
    let (kind, source) = match model {
        Some(SoundFile::Pan(file)) => {
            let model = Arc::new(file.model.clone());
            let source = PanSource::new(model, Arc::clone(&body.surface));
            return Ok(SoundSource::Reference(Arc::new(source)));
        }
        Some(SoundFile::Model(file)) => {
            let own = ModelEvaluator::try_new(&file.acceleration)
                .map_err(|e| Failure::new(format_args!("{}: {e}", options.body)))?;
            let decision = Decision { kind: SourceKind::Own, reason: Reason::Asked };
            let (source, kind) = source_of(body, &decision, None, Some(&own));
            (kind, source)
        }
        Some(SoundFile::Modal(_) | SoundFile::Bank(_) | SoundFile::ModalSoundbank(_)) | None => {
            let settings = SoundModelSettings { modal: None, ..settings(options, impact) };
            let found = found_model(body, settings, None, options, (global, console))?.acceleration;
            (found.kind, found.source)
        }
    };
    if let SoundSource::Field(field) = &source {
        let end = field.max_frequency(impact.medium.sound_speed);
        // The rounding of a wavenumber that was stored.
        if end < band * (1.0 - 1e-9) {
            console.warn(format_args!(
                "the field of \"{}\" ends at {end:.0} Hz, and the file's band at {band:.0} Hz",
                options.body
            ));
        }
    }
    if !matches!(*body.surface, Surface::Sphere { .. }) {
        console.say(format_args!("\"{}\" sounds as: {kind}", options.body));
    }
    Ok(source)
}

/// What is struck.
struct StrikeTarget {
    body: Body,
    /// The model that it was baked into, if that was given.
    model: Option<SoundFile>,
    /// Its modes without their sound, if a glTF file has them.
    modes: Option<ModalModel>,
}

/// The struck body, at rest at the origin: a shape, a mesh file, or what a sound model was baked from.
fn body(options: &Strike, console: &Console) -> Result<StrikeTarget, Failure> {
    let asked = options.material.as_deref().map(preset).transpose()?;
    if let Some(AudioInput { geometry, material, modal }) =
        audio_input(&options.body, options.scale, asked.as_ref(), console)?
    {
        let body = at_rest(options, geometry.surface, geometry.mass, material);
        return Ok(StrikeTarget { body, model: None, modes: modal });
    }
    let material = asked.ok_or_else(|| {
        Failure::new(format_args!("what is \"{}\" made of? add --material NAME", options.body))
    })?;
    let path = Path::new(&options.body);
    let (surface, mass, model) = match path.extension().is_some_and(|e| e == "safetensors") {
        true => {
            let file = read_sound_file(path).map_err(Failure::new)?;
            let (solid, radius) = match &file {
                SoundFile::Model(file) => (&file.solid, file.acceleration.radius),
                SoundFile::Modal(file) => (&file.solid, file.modal.model.radius),
                SoundFile::Pan(file) => (&file.solid, file.model.radius()),
                SoundFile::Bank(_) | SoundFile::ModalSoundbank(_) => {
                    let path = path.display();
                    return Err(Failure::new(format_args!(
                        "{path} is a soundbank, not the model of one body"
                    )));
                }
            };
            let surface = match &solid.surface {
                None => Surface::Sphere { radius },
                // Nothing collides with it.
                Some(mesh) => Surface::Mesh(
                    MeshSurface::try_new(mesh.clone(), Vec::new())
                        .map_err(|e| Failure::new(format_args!("{}: {e}", options.body)))?
                        .0,
                ),
            };
            (Arc::new(surface), solid.mass, Some(file))
        }
        false => {
            let reference = geometry_reference(&options.body, options.scale);
            let LoadedGeometry { surface, mass, .. } = load_geometry(Path::new(""), &reference)
                .map_err(|e| Failure::new(format_args!("\"{}\" cannot be used: {e}", options.body)))?;
            (surface, mass, None)
        }
    };
    let body = at_rest(options, surface, mass, material);
    Ok(StrikeTarget { body, model, modes: None })
}

/// A body at the origin.
fn at_rest(options: &Strike, surface: Arc<Surface>, mass: MassProperties, material: Material) -> Body {
    Body::solid(&options.body, material, surface, &mass)
}
