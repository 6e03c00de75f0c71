//! `clangor bake`: the sound model of a body, or those that a scene needs.

pub(super) mod modal_report;
pub(super) mod model_report;
pub(super) mod pan_report;

use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

use clangor_bake::acceleration::{BakeOptions, BakeProgress, Method};
use clangor_bake::fdtd::WaveDevice;
use clangor_bake::modal::ModalBakeOptions;
use clangor_bake::reference::PanForm;
use clangor_core::medium::Medium;
use clangor_core::scene::Scene;
use clangor_core::scene::render_description::PROXY_FREQUENCY;
use clangor_core::sound_model::files::modal_file::ModalFile;
use clangor_core::sound_model::files::model_file::ModelFile;
use clangor_core::synthesis::source_rule::SourceKind;
use clangor_core::synthesis::{RenderSettings, SampleRate};
use clangor_pipeline::formats::atomic_file::{check_folder, write_atomically};
use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::session::named_body::{GltfBody, preset};
use clangor_pipeline::stages::load::{LoadedScene, geometry_reference, load_geometry};
use clangor_pipeline::stages::sound_models::acceleration_plan::shared_fields;
use clangor_pipeline::stages::sound_models::obtain::BakedPart;
use clangor_pipeline::stages::sound_models::{
    AccelerationBake, AccelerationSettings, ModalBake, ModalPlanSettings, Obtained, ObtainedModel,
    RequestError, SoundModelPlan, SoundModelRequest, SoundModelSettings, obtain, pan_representation,
};
use serde_json::{Value, json};

use super::sound_sources::find_models;
use super::{check_ending, load};
use crate::arguments::{Bake, Device, Global, Grid, Part, Representation, Solver};
use crate::console::{Console, counted};
use crate::failure::Failure;

pub(crate) fn run(options: &Bake, global: &Global, console: &Console) -> Result<(), Failure> {
    let cache = ModelCache::find(global.cache.as_deref());
    match Path::new(&options.input).extension().is_some_and(|e| e == "toml") {
        true => scene(options, global, cache.as_ref(), console),
        false => body(options, cache.as_ref(), console),
    }
}

/// How to bake up to a wavenumber k [1/m].
fn bake_options(options: &Bake, max_wavenumber: f64) -> BakeOptions {
    BakeOptions {
        method: match options.method {
            Solver::Auto => Method::Auto,
            Solver::Bem => Method::Bem,
            Solver::Fdtd => Method::Fdtd,
        },
        device: match options.device {
            Device::Cpu => WaveDevice::Cpu,
            Device::Gpu => WaveDevice::Gpu,
        },
        near_field: !options.no_near_field,
        ..BakeOptions::new(max_wavenumber, options.accuracy)
    }
}

/// Highest frequency that is heard \[Hz\].
const AUDIBLE: f64 = 20_000.0;

/// One model, into a file.
fn body(options: &Bake, cache: Option<&ModelCache>, console: &Console) -> Result<(), Failure> {
    let Some(output) = &options.output else {
        return Err(Failure::new(format_args!(
            "where should the model of \"{}\" go? add -o MODEL.safetensors",
            options.input
        )));
    };
    check_ending(output, "safetensors")?;
    // A long computation is not begun for a file that cannot be written.
    check_folder(output).map_err(Failure::new)?;
    let mut material = options.material.as_deref().map(preset).transpose()?;
    let audio = GltfBody::read(&options.input, options.scale, material.as_ref())?;
    if let Some(audio) = &audio {
        audio.remarks.iter().for_each(|remark| console.warn(remark));
        material = Some(audio.material.clone());
    }
    let wants = |part| options.parts.contains(&part);
    let (click, ringing) = match options.parts.is_empty() {
        true => (true, material.is_some()),
        false => (wants(Part::Acceleration), wants(Part::Modal)),
    };
    let of = match (ringing, material) {
        (true, None) => {
            return Err(Failure::new("ringing depends on the material: add --material NAME"));
        }
        (true, of) => of,
        (false, _) => None,
    };
    let (loaded, given) = match audio {
        Some(audio) => (audio.geometry, audio.modal),
        None => {
            let reference = geometry_reference(&options.input, options.scale);
            let loaded = load_geometry(Path::new(""), &reference)
                .map_err(|e| Failure::new(format_args!("\"{}\" cannot be baked: {e}", options.input)))?;
            (loaded, None)
        }
    };
    let refused = |e: RequestError| Failure::new(format_args!("\"{}\" cannot be baked: {e}", options.input));
    let started = Instant::now();
    let modes = match of {
        Some(material) => {
            let bake = modal_options(options, Medium::AIR);
            let (name, surface, mass) = (&options.input, &loaded.surface, loaded.mass);
            let part = match given {
                Some(modes) => ModalBake::of_known_modes(&material, modes, bake),
                None => ModalBake::new(&material, bake),
            };
            let request = SoundModelRequest::new(name, surface, mass, part).map_err(refused)?;
            Some(with_progress(&request, "modes", cache, console)?)
        }
        None => None,
    };
    if !click {
        return modes.map_or(Ok(()), |modes| ringing_alone(modes, options, started, console));
    }
    let highest = TAU * options.max_frequency.unwrap_or(AUDIBLE) / Medium::AIR.sound_speed;
    let part = AccelerationBake(bake_options(options, highest));
    let request =
        SoundModelRequest::new(&options.input, &loaded.surface, loaded.mass, part).map_err(refused)?;
    let obtained = with_progress(&request, "bake", cache, console)?;
    if options.representation == Representation::Pan {
        warn(&obtained, &options.input, console);
        return published(&obtained.file, options, output, console);
    }
    write_model(obtained, modes, (options, output), started, console)
}

/// Writes both parts of a model into one file, and reports it.
fn write_model(
    mut obtained: Obtained<ModelFile>,
    modes: Option<Obtained<ModalFile>>,
    (options, output): (&Bake, &Path),
    started: Instant,
    console: &Console,
) -> Result<(), Failure> {
    let cached = obtained.cached && modes.as_ref().is_none_or(|modes| modes.cached);
    if let Some(modes) = &modes {
        warn_of_modes(modes, &options.input, console);
    }
    obtained.file.modal = modes.map(|modes| modes.file.modal);
    let seconds = started.elapsed().as_secs_f64();
    let bytes = obtained.file.encode().map_err(Failure::new)?;
    write_atomically(output, &bytes).map_err(Failure::new)?;

    warn(&obtained, &options.input, console);
    let file = &obtained.file;
    model_report::say(console, output, file, bytes.len() as u64);
    let mut result = model_report::json(output, file, bytes.len() as u64);
    if let Some(part) = &file.modal {
        modal_report::say(console, part, false);
        result["modal"] = modal_report::json(part);
    }
    let from = if cached { "from the cache" } else { "baked" };
    console.say(format_args!("{from} in {seconds:.2} s"));
    result["seconds"] = json!(seconds);
    result["cached"] = json!(cached);
    console.json(&result);
    Ok(())
}

/// How to bake modes.
fn modal_options(options: &Bake, medium: Medium) -> ModalBakeOptions {
    ModalBakeOptions {
        max_frequency: options.max_frequency.unwrap_or(AUDIBLE).min(AUDIBLE),
        mesh_error: options.accuracy,
        accuracy: options.accuracy,
        ..ModalBakeOptions::new(medium)
    }
}

/// A file with nothing but modes.
fn ringing_alone(
    modes: Obtained<ModalFile>,
    options: &Bake,
    started: Instant,
    console: &Console,
) -> Result<(), Failure> {
    let Some(output) = &options.output else { return Ok(()) };
    warn_of_modes(&modes, &options.input, console);
    let Obtained { file, cached, .. } = modes;
    let origin = &file.modal.origin;
    if let Some(first) = origin.first_frequency {
        let why = modal_report::no_modes(first, file.modal.model.max_frequency);
        return Err(Failure::new(format_args!("\"{}\" has {why}", options.input)));
    }
    let bytes = file.encode().map_err(Failure::new)?;
    write_atomically(output, &bytes).map_err(Failure::new)?;
    let seconds = started.elapsed().as_secs_f64();
    console.say(format_args!(
        "{}: ringing of \"{}\", {:.1} kB",
        output.display(),
        options.input,
        1e-3 * bytes.len() as f64
    ));
    modal_report::say(console, &file.modal, false);
    let from = if cached { "from the cache" } else { "baked" };
    console.say(format_args!("{from} in {seconds:.2} s"));
    console.json(&json!({
        "model": output,
        "name": options.input,
        "bytes": bytes.len(),
        "modal": modal_report::json(&file.modal),
        "seconds": seconds,
        "cached": cached,
    }));
    Ok(())
}

/// What a person should know of modes and of the cache.
fn warn_of_modes(modes: &Obtained<ModalFile>, name: &str, console: &Console) {
    let warnings = modes.file.modal.origin.warnings.iter().map(|w| format!("\"{name}\": {w}"));
    modes.remarks.iter().cloned().chain(warnings).for_each(|remark| console.warn(remark));
}

/// A model in the published representation, into a file.
fn published(file: &ModelFile, options: &Bake, output: &Path, console: &Console) -> Result<(), Failure> {
    let form = match options.grid {
        Grid::Coarse => PanForm::Angles { rows: 5, columns: 10 },
        Grid::Fine => PanForm::Angles { rows: 40, columns: 80 },
        Grid::Octant => PanForm::Octant { tolerance: 0.01 },
    };
    let file = pan_representation(file, form).map_err(Failure::new)?;
    let bytes = file.encode().map_err(Failure::new)?;
    write_atomically(output, &bytes).map_err(Failure::new)?;
    pan_report::say(console, output, &file, bytes.len() as u64);
    Ok(())
}

/// Every model that a scene needs, into the cache.
fn scene(
    options: &Bake,
    global: &Global,
    cache: Option<&ModelCache>,
    console: &Console,
) -> Result<(), Failure> {
    if options.representation == Representation::Pan {
        return Err(Failure::new(
            "the published representation is baked for one shape or mesh, and played with render --model",
        ));
    }
    if options.output.is_some() {
        return Err(Failure::new("the models of a scene go to the cache: leave -o out, and see --cache"));
    }
    let Some(cache) = cache else {
        return Err(Failure::new("this system has no folder for caches; name one with --cache DIR"));
    };
    let loaded = load(Path::new(&options.input), global, &|_| (), console)?;
    let (scene, bodies) = (&loaded.scene, &loaded.world.bodies);
    let highest = match options.max_frequency {
        Some(hz) => TAU * hz / scene.acoustics.medium.sound_speed,
        None => synthesis_settings(scene)?.max_wavenumber(),
    };
    let bank = default_bank();
    let rules = scene.sound_rules();
    let settings = AccelerationSettings::new(highest, options.accuracy, true);
    let decisions = settings.decide(bodies, &rules, bank.as_ref());
    let requests = shared_fields(bodies, bake_options(options, highest), &|id| {
        decisions[id.index()].kind == SourceKind::Own
    });
    let wants = |part| options.parts.is_empty() || options.parts.contains(&part);
    let requests = if wants(Part::Acceleration) { requests } else { Vec::new() };
    let mut models = Vec::new();
    for shared in &requests {
        let name = &bodies[shared.bodies[0].index()].name;
        let started = Instant::now();
        let obtained = with_progress(&shared.request, "bake", Some(cache), console)?;
        let seconds = started.elapsed().as_secs_f64();
        warn(&obtained, name, console);
        let path = cache.path::<ModelFile>(shared.request.key());
        let file = &obtained.file;
        console.say(format_args!(
            "\"{name}\"{}: {}",
            match shared.bodies.len() {
                1 => String::new(),
                more => format!(" and {} like it", more - 1),
            },
            if obtained.cached {
                "in the cache".into()
            } else {
                format!("baked in {seconds:.2} s, {}", model_report::evidence(file))
            }
        ));
        let mut result = model_report::json(&path, file, std::fs::metadata(&path).map_or(0, |m| m.len()));
        result["bodies"] = json!(shared.bodies.len());
        result["seconds"] = json!(seconds);
        result["cached"] = json!(obtained.cached);
        models.push(result);
    }
    console.say(format_args!(
        "{}: {} in {}; {} without a field of their own",
        options.input,
        counted(requests.len(), "model", "models"),
        cache.folder().display(),
        counted(bodies.len() - requests.iter().map(|r| r.bodies.len()).sum::<usize>(), "body", "bodies"),
    ));
    let ringing = match wants(Part::Modal) && scene.render.parts.modal {
        true => scene_modes(options, &loaded, global, console)?,
        false => Vec::new(),
    };
    console.json(&json!({ "cache": cache.folder(), "models": models, "modes": ringing }));
    Ok(())
}

/// The modes of all bodies that may ring, into the cache.
fn scene_modes(
    options: &Bake,
    loaded: &LoadedScene,
    global: &Global,
    console: &Console,
) -> Result<Vec<Value>, Failure> {
    let (scene, bodies) = (&loaded.scene, &loaded.world.bodies);
    let band = synthesis_settings(scene)?.band().0;
    let mut bake = modal_options(options, scene.acoustics.medium);
    bake.max_frequency = options.max_frequency.unwrap_or(band).min(AUDIBLE);
    let settings = SoundModelSettings {
        // The fields are baked with options of their own.
        acceleration: AccelerationSettings::new(1.0, options.accuracy, false),
        wants_acceleration: false,
        modal: Some(ModalPlanSettings { options: bake, proxy_frequency: PROXY_FREQUENCY }),
    };
    let plan = SoundModelPlan::new(bodies, &scene.sound_rules(), settings);
    let all = plan.followed();
    let found = find_models(plan, bodies, &all, global, console)?;
    let mut modes = Vec::new();
    for ObtainedModel { body, bodies: count, cached, time, .. } in &found.obtained {
        let name = &bodies[body.index()].name;
        let ringing = &found.bodies[body.index()].modal;
        let like = match count {
            1 => String::new(),
            more => format!(" and {} like it", more - 1),
        };
        let from = match cached {
            true => "in the cache".into(),
            false => format!("baked in {:.2} s", time.as_secs_f64()),
        };
        console.say(format_args!("\"{name}\"{like}: {ringing}, {from}"));
        modes.push(json!({
            "name": name,
            "bodies": count,
            "modes": ringing.own().map_or(0, |model| model.modes.len()),
            "modal": ringing.to_string(),
            "cached": cached,
            "seconds": time.as_secs_f64(),
        }));
    }
    Ok(modes)
}

/// How a scene is rendered if nothing else is asked for.
fn synthesis_settings(scene: &Scene) -> Result<RenderSettings, Failure> {
    Ok(RenderSettings {
        sample_rate: SampleRate::try_new(scene.render.sample_rate).map_err(Failure::new)?,
        start: 0.0,
        acoustics: scene.acoustics,
        sphere_model: scene.render.radiation,
        ..RenderSettings::default()
    })
}

/// Obtains a part of a model under a progress bar.
fn with_progress<P: BakedPart>(
    request: &SoundModelRequest<P>,
    what: &'static str,
    cache: Option<&ModelCache>,
    console: &Console,
) -> Result<Obtained<P::File>, Failure> {
    let progress = console.progress(what, 1.0);
    let mut on_progress = |p: &BakeProgress| {
        progress.stage(p.stage);
        progress.reached(p.done)
    };
    Ok(obtain(request, cache, &mut on_progress)?)
}

/// What a person should know of a model and of the cache.
fn warn(obtained: &Obtained<ModelFile>, name: &str, console: &Console) {
    for remark in &obtained.remarks {
        console.warn(remark);
    }
    for warning in &obtained.file.origin.warnings {
        console.warn(format_args!("\"{name}\": {warning}"));
    }
}
