//! `clangor export`: a scene, a timeline or a model becomes another tool's file.

mod web;

use std::path::Path;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::material::{Material, presets};
use clangor_core::shape::{Form, Shape};
use clangor_core::sound_model::files::model_file::Solid;
use clangor_pipeline::interchange::audio_rigid_bodies::{
    AudioBody, AudioMaterial, BodyMass, Ringing, write_audio_body,
};
use clangor_pipeline::interchange::body_files::{export_scene_gltf, export_timeline_gltf};
use clangor_pipeline::session::named_body::preset;
use clangor_pipeline::stages::sound_models::{SoundFile, read_sound_file};
use serde_json::json;

use super::impact_modes::impact_modes;
use super::{check_ending, is_timeline, load, refuse_overwriting};
use crate::arguments::{Export, ExportFormat, Global};
use crate::console::{Console, counted};
use crate::failure::Failure;

pub(crate) fn run(options: &Export, global: &Global, console: &Console) -> Result<(), Failure> {
    match &options.format {
        ExportFormat::Gltf { input, output, rate } => motion(input, output, *rate, global, console),
        ExportFormat::Web { input, output, models, device } => {
            web::run(input, output.as_deref(), models.on(device.device), global, console)
        }
        ExportFormat::Modal { model, output, material } => modal(model, output, material.as_deref(), console),
    }
}

/// The moving bodies of a scene or a timeline.
fn motion(input: &Path, output: &Path, rate: f64, global: &Global, console: &Console) -> Result<(), Failure> {
    check_ending(output, "glb")?;
    refuse_overwriting(input, output)?;
    let summary = if is_timeline(input) {
        export_timeline_gltf(input, output, rate)?
    } else {
        let mut loaded = load(input, global, &|_| (), console)?;
        impact_modes(&mut loaded, global, console)?;
        let progress = console.progress("simulate", loaded.scene.simulation.duration);
        export_scene_gltf(&loaded, output, rate, &mut |t| progress.reached(t))?
    };
    console.say(format_args!(
        "{}: {}, {}",
        output.display(),
        counted(summary.nodes as usize, "node", "nodes"),
        counted(summary.frames as usize, "instant", "instants")
    ));
    console.json(
        &json!({ "gltf": output.display().to_string(), "nodes": summary.nodes, "frames": summary.frames }),
    );
    Ok(())
}

/// A body with its modes.
fn modal(model: &Path, output: &Path, material: Option<&str>, console: &Console) -> Result<(), Failure> {
    check_ending(output, "glb")?;
    refuse_overwriting(model, output)?;
    let (modal, solid) = match read_sound_file(model).map_err(Failure::new)? {
        SoundFile::Model(file) => (file.modal, file.solid),
        SoundFile::Modal(file) => (Some(file.modal), file.solid),
        SoundFile::Pan(_) | SoundFile::Bank(_) | SoundFile::ModalSoundbank(_) => {
            return Err(Failure::new(format_args!("{} is not the model of one body", model.display())));
        }
    };
    let Some(modal) = modal else {
        return Err(Failure::new(format_args!(
            "{} has no modes; bake them with --parts acceleration,modal --material NAME",
            model.display()
        )));
    };
    let origin = &modal.origin;
    let damping = match material {
        Some(name) => preset(name)?.damping,
        None => {
            let known = presets::preset(&origin.material).ok_or_else(|| {
                Failure::new(format_args!(
                    "nothing tells the damping of \"{}\"; add --material NAME",
                    origin.material
                ))
            })?;
            known.damping
        }
    };
    let material = Material {
        name: origin.material.clone(),
        density: modal.model.density,
        youngs_modulus: origin.youngs_modulus,
        poisson_ratio: origin.poisson_ratio,
        damping,
        ..presets::STEEL.material()
    };
    // Vertices are about the centre of mass, as they are in the model.
    let mut mass = BodyMass::of_solid(&solid.mass, material.density);
    mass.centre_of_mass = DVec3::ZERO;
    let body = AudioBody {
        name: body_name(&solid.name),
        mesh: mesh(&solid, modal.model.radius)?,
        material: AudioMaterial::of(&material),
        mass: Some(mass),
        ringing: Some(Ringing::of_model(&modal.model, &material.damping)),
        gain: 1.0,
        remarks: Vec::new(),
    };
    let modes = write_audio_body(output, &body).map_err(Failure::new)?;
    console.say(format_args!(
        "{}: \"{}\" of {}, {}",
        output.display(),
        body.name,
        material.name,
        counted(modes, "mode", "modes")
    ));
    let written = output.to_string_lossy();
    console.json(&json!({ "gltf": written, "name": body.name, "material": material.name, "modes": modes }));
    Ok(())
}

/// What a body is called in the file: its shape, or its file without the folder.
fn body_name(solid: &str) -> String {
    solid.rsplit(['/', '\\']).next().unwrap_or(solid).into()
}

/// The surface of a solid about its centre of mass; that of a sphere in flat triangles.
fn mesh(solid: &Solid, radius: f64) -> Result<TriMesh, Failure> {
    match &solid.surface {
        Some(mesh) => Ok(mesh.clone()),
        None => {
            Ok(Shape::try_new(Form::Sphere { radius }, Some(0.25 * radius)).map_err(Failure::new)?.mesh())
        }
    }
}
