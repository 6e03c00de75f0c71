//! `clangor bake`: the sound model of a body, or those that a scene needs.

pub(super) mod modal_report;
pub(super) mod model_report;
pub(super) mod pan_report;

use std::borrow::Cow;
use std::path::Path;

use clangor_bake::reference::PanForm;
use clangor_core::body::Body;
use clangor_core::scene::render_description::Parts;
use clangor_core::sound_model::files::modal_file::ModalFile;
use clangor_core::sound_model::files::model_file::ModelFile;
use clangor_pipeline::formats::atomic_file::check_folder;
use clangor_pipeline::session::bake::write_pan;
use clangor_pipeline::session::named_body::preset;
use clangor_pipeline::session::{Bake as ModelBake, BakedBody, BakedField, BakedFile, NamedSolid};
use clangor_pipeline::stages::sound_models::{ObtainedModel, SoundModels};
use serde_json::{Value, json};

use super::session::StageBars;
use super::{check_ending, load};
use crate::arguments::{Bake, Global, Grid, Part, Representation};
use crate::console::{Console, counted};
use crate::failure::Failure;

pub(crate) fn run(options: &Bake, global: &Global, console: &Console) -> Result<(), Failure> {
    match Path::new(&options.input).extension().is_some_and(|e| e == "toml") {
        true => scene(options, global, console),
        false => body(options, global, console),
    }
}

/// The body or scene as text.
fn name(options: &Bake) -> Cow<'_, str> {
    options.input.to_string_lossy()
}

/// How the command line asks to bake.
fn settings(options: &Bake, global: &Global) -> ModelBake {
    let models = options.models.on(options.device.device);
    let mut bake = ModelBake::new().models(models).near_field(!options.no_near_field);
    if !options.parts.is_empty() {
        let wants = |part| options.parts.contains(&part);
        let (acceleration, modal) = (wants(Part::Acceleration), wants(Part::Modal));
        bake = bake.parts(Parts { acceleration, modal, ground: false });
    }
    match &global.cache {
        Some(folder) => bake.cache(folder),
        None => bake,
    }
}

/// One model, into a file.
fn body(options: &Bake, global: &Global, console: &Console) -> Result<(), Failure> {
    let Some(output) = &options.output else {
        return Err(Failure::new(format_args!(
            "where should the model of \"{}\" go? add -o MODEL.safetensors",
            name(options)
        )));
    };
    check_ending(output, "safetensors")?;
    // A long computation is not begun for a file that cannot be written.
    check_folder(output).map_err(Failure::new)?;
    let material = options.material.as_deref().map(preset).transpose()?;
    let solid = NamedSolid::open(&options.input, options.scale, material)?;
    solid.remarks.iter().for_each(|remark| console.warn(remark));
    let bars = StageBars::new(console);
    let baked = settings(options, global).body(&solid, &mut |progress| bars.show(progress))?;
    bars.clear();
    match &baked.file {
        BakedFile::Model(file) if options.representation == Representation::Pan => {
            baked.acceleration_remarks.iter().for_each(|remark| console.warn(remark));
            published(file, options, output, console)
        }
        BakedFile::Model(file) => write_model(&baked, file, output, console),
        BakedFile::Modal(file) => write_modes(&baked, file, (options, output), console),
    }
}

/// Writes a model with an acceleration part, and reports it.
fn write_model(baked: &BakedBody, file: &ModelFile, output: &Path, console: &Console) -> Result<(), Failure> {
    baked.modal_remarks.iter().for_each(|remark| console.warn(remark));
    let bytes = baked.file.write(output)?;
    baked.acceleration_remarks.iter().for_each(|remark| console.warn(remark));
    model_report::say(console, output, file, bytes);
    let mut result = model_report::json(output, file, bytes);
    if let Some(part) = &file.modal {
        modal_report::say(console, part, false);
        result["modal"] = modal_report::json(part);
    }
    let seconds = baked.time.as_secs_f64();
    console.say(format_args!("{} in {seconds:.2} s", origin(baked.cached)));
    result["seconds"] = json!(seconds);
    result["cached"] = json!(baked.cached);
    console.json(&result);
    Ok(())
}

/// Where a model came from.
fn origin(cached: bool) -> &'static str {
    if cached { "from the cache" } else { "baked" }
}

/// Writes a file with nothing but modes, and reports it.
fn write_modes(
    baked: &BakedBody,
    file: &ModalFile,
    (options, output): (&Bake, &Path),
    console: &Console,
) -> Result<(), Failure> {
    baked.modal_remarks.iter().for_each(|remark| console.warn(remark));
    if let Some(first) = file.modal.origin.first_frequency {
        let why = modal_report::no_modes(first, file.modal.model.max_frequency);
        return Err(Failure::new(format_args!("\"{}\" has {why}", name(options))));
    }
    let bytes = baked.file.write(output)?;
    let seconds = baked.time.as_secs_f64();
    console.say(format_args!(
        "{}: ringing of \"{}\", {:.1} kB",
        output.display(),
        name(options),
        1e-3 * bytes as f64
    ));
    modal_report::say(console, &file.modal, false);
    console.say(format_args!("{} in {seconds:.2} s", origin(baked.cached)));
    console.json(&json!({
        "model": output.display().to_string(),
        "name": name(options),
        "bytes": bytes,
        "modal": modal_report::json(&file.modal),
        "seconds": seconds,
        "cached": baked.cached,
    }));
    Ok(())
}

/// Writes a model in the published representation, and reports it.
fn published(file: &ModelFile, options: &Bake, output: &Path, console: &Console) -> Result<(), Failure> {
    let form = match options.grid {
        Grid::Coarse => PanForm::Angles { rows: 5, columns: 10 },
        Grid::Fine => PanForm::Angles { rows: 40, columns: 80 },
        Grid::Octant => PanForm::Octant { tolerance: 0.01 },
    };
    let (file, bytes) = write_pan(file, form, output)?;
    pan_report::say(console, output, &file, bytes);
    Ok(())
}

/// Every model that a scene needs, into the cache.
fn scene(options: &Bake, global: &Global, console: &Console) -> Result<(), Failure> {
    if options.representation == Representation::Pan {
        return Err(Failure::new(
            "the published representation is baked for one shape or mesh, and played with render --model",
        ));
    }
    if options.output.is_some() {
        return Err(Failure::new("the models of a scene go to the cache: leave -o out, and see --cache"));
    }
    let settings = settings(options, global);
    let loaded = load(Path::new(&options.input), global, &|_| (), console)?;
    let bake = settings.scene(&loaded)?;
    let mut models = Vec::new();
    for field in bake.fields() {
        let bars = StageBars::new(console);
        let field = bake.bake_field(field, &mut |progress| bars.show(progress))?;
        bars.clear();
        models.push(report_field(&field, console));
    }
    console.say(format_args!(
        "{}: {} in {}; {} without a field of their own",
        name(options),
        counted(bake.fields().len(), "model", "models"),
        bake.cache().folder().display(),
        counted(bake.bodies_without_field(), "body", "bodies"),
    ));
    let bars = StageBars::new(console);
    let modes = bake.bake_modes(&mut |progress| bars.show(progress))?;
    bars.clear();
    let modes = modes.map_or(Vec::new(), |found| report_modes(&found, &loaded.world.bodies, console));
    console.json(&json!({ "cache": bake.cache().folder(), "models": models, "modes": modes }));
    Ok(())
}

/// The other bodies that share a model.
fn like(bodies: usize) -> String {
    match bodies {
        1 => String::new(),
        more => format!(" and {} like it", more - 1),
    }
}

/// Prints one line about a field, and returns it as JSON.
fn report_field(field: &BakedField, console: &Console) -> Value {
    field.remarks.iter().for_each(|remark| console.warn(remark));
    let BakedField { name, bodies, file, path, cached, time, .. } = field;
    let seconds = time.as_secs_f64();
    let from = match cached {
        true => "in the cache".into(),
        false => format!("baked in {seconds:.2} s, {}", model_report::evidence(file)),
    };
    console.say(format_args!("\"{name}\"{}: {from}", like(*bodies)));
    let mut result = model_report::json(path, file, std::fs::metadata(path).map_or(0, |m| m.len()));
    result["bodies"] = json!(bodies);
    result["seconds"] = json!(seconds);
    result["cached"] = json!(cached);
    result
}

/// Prints one line about the modes of each form, and returns them as JSON.
fn report_modes(found: &SoundModels, bodies: &[Body], console: &Console) -> Vec<Value> {
    found.remarks.iter().for_each(|remark| console.warn(remark));
    let mut modes = Vec::new();
    for ObtainedModel { body, bodies: count, cached, time, .. } in &found.obtained {
        let name = &bodies[body.index()].name;
        let ringing = &found.bodies[body.index()].modal;
        let from = match cached {
            true => "in the cache".into(),
            false => format!("baked in {:.2} s", time.as_secs_f64()),
        };
        console.say(format_args!("\"{name}\"{}: {ringing}, {from}", like(*count)));
        modes.push(json!({
            "name": name,
            "bodies": count,
            "modes": ringing.own().map_or(0, |model| model.modes.len()),
            "modal": ringing.to_string(),
            "cached": cached,
            "seconds": time.as_secs_f64(),
        }));
    }
    modes
}
