//! A body as a binary glTF file with the extension.

use std::f64::consts::TAU;
use std::path::Path;

use clangor_core::geometry::principal_axes::principal_axes;
use glam::DQuat;
use serde_json::{Value, json};

use super::importance::by_importance;
use super::json::{Extras, MassJson, MaterialJson, ModelJson, NodeJson, Others, OwnExtras};
use super::{AudioBody, AudioMaterial, BodyMass, EXTENSION, Ringing, RingingMode};
use crate::formats::atomic_file::write_atomically;
use crate::formats::glb::GlbError;
use crate::formats::glb::container::{Container, container_bytes};

/// Why a body could not be written.
#[derive(Debug, thiserror::Error)]
pub enum AudioWriteError {
    /// None of its modes rings, and the extension has no empty models.
    #[error("\"{body}\" has no mode that rings: there is nothing to export")]
    Silent {
        /// The body.
        body: String,
    },
    /// A mode that the extension cannot have.
    #[error("mode {mode} of \"{body}\", at {frequency} Hz, has {what}")]
    Mode {
        /// The body.
        body: String,
        /// Which mode, from 0.
        mode: usize,
        /// Its frequency \[Hz\].
        frequency: f64,
        /// What is wrong with it.
        what: &'static str,
    },
    /// The file.
    #[error(transparent)]
    Glb(#[from] GlbError),
}

/// Writes a body; how many of its modes are in the file. Those that creep back without ringing (ξ ≥ 1) are
/// not.
///
/// # Errors
/// [`AudioWriteError`]; no file is left then.
pub fn write_audio_body(path: &Path, body: &AudioBody) -> Result<usize, AudioWriteError> {
    let mut out = Container::default();
    let mut tables = AudioTables::default();
    let mesh = out.mesh(&body.name, &body.mesh, None);
    let node = tables.node(&mut out, body)?;
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("Clangor ", env!("CARGO_PKG_VERSION")) },
        "extensionsUsed": [EXTENSION],
        "extensions": { EXTENSION: tables.document() },
        "scene": 0,
        "scenes": [{ "name": "scene", "nodes": [0] }],
        "nodes": [{ "name": body.name, "mesh": 0, "extensions": { EXTENSION: node } }],
        "meshes": [mesh],
        "accessors": out.accessors,
        "bufferViews": out.views,
        "buffers": [{ "byteLength": out.bytes.len() }],
    });
    write_atomically(path, &container_bytes(path, &document, out.bytes)?).map_err(GlbError::from)?;
    Ok(tables.modes)
}

/// The lists of the extension in a document.
#[derive(Default)]
struct AudioTables {
    materials: Vec<Value>,
    surfaces: Vec<Value>,
    models: Vec<Value>,
    /// Modes in all models.
    modes: usize,
}

impl AudioTables {
    /// Puts a body into the lists, and says what its node has.
    fn node(&mut self, out: &mut Container, body: &AudioBody) -> Result<Value, AudioWriteError> {
        let material = self.materials.len();
        self.materials.push(json!(material_json(&body.material)));
        // The material of a contact; nothing is known of the finish, whose numbers the draft gives itself.
        let surface = self.surfaces.len();
        self.surfaces.push(json!({ "name": body.material.name, "material": material }));
        if body.material.name.is_none() {
            self.surfaces[surface] = json!({ "material": material });
        }
        let modal_model = match &body.ringing {
            None => None,
            Some(ringing) => {
                let model = model_json(out, body, ringing, material)?;
                self.modes += model.1;
                self.models.push(json!(model.0));
                Some(self.models.len() - 1)
            }
        };
        let gain = (body.gain != 1.0).then_some(body.gain);
        Ok(json!(NodeJson { modal_model, acoustic_surface: Some(surface), gain, others: Others::new() }))
    }

    /// The extension of the document; lists in it may not be empty.
    fn document(&self) -> Value {
        let lists = [
            ("acousticMaterials", &self.materials),
            ("acousticSurfaces", &self.surfaces),
            ("modalModels", &self.models),
        ];
        let lists = lists.into_iter().filter(|(_, list)| !list.is_empty());
        Value::Object(lists.map(|(name, list)| (name.into(), json!(list))).collect())
    }
}

fn material_json(material: &AudioMaterial) -> MaterialJson {
    let AudioMaterial { name, density, youngs_modulus, poisson_ratio, alpha, beta } = material.clone();
    MaterialJson { name, density, youngs_modulus, poisson_ratio, alpha, beta, others: Others::new() }
}

fn mass_json(mass: &BodyMass) -> MassJson {
    let (moments, axes) = principal_axes(mass.inertia);
    MassJson {
        mass: Some(mass.mass),
        center_of_mass: Some(mass.centre_of_mass.to_array()),
        inertia_diagonal: Some(moments.to_array()),
        inertia_orientation: Some(DQuat::from_mat3(&axes).normalize().to_array()),
    }
}

/// A modal model, and how many modes it has.
fn model_json(
    out: &mut Container,
    body: &AudioBody,
    ringing: &Ringing,
    material: usize,
) -> Result<(ModelJson, usize), AudioWriteError> {
    let Ringing { surface, modes, max_frequency } = ringing;
    for (at, mode) in modes.iter().enumerate() {
        check_mode(&body.name, at, mode, surface.nodes.len())?;
    }
    let order: Vec<(&RingingMode, f32)> = by_importance(surface, modes)
        .into_iter()
        .map(|i| (&modes[i], observed_frequency(&modes[i]) as f32))
        .filter(|(_, frequency)| *frequency > 0.0)
        .collect();
    if order.is_empty() {
        return Err(AudioWriteError::Silent { body: body.name.clone() });
    }
    let frequencies: Vec<f32> = order.iter().map(|(_, frequency)| *frequency).collect();
    let decay_rates: Vec<f32> = order.iter().map(|(mode, _)| mode.decay_rate as f32).collect();
    let shapes: Vec<f32> =
        order.iter().flat_map(|(m, _)| &m.shape).flat_map(|u| u.to_array()).map(|u| u as f32).collect();
    let quarters = surface.quarters();
    let model = ModelJson {
        name: Some(body.name.clone()),
        frequencies: out.floats(&frequencies, "SCALAR", false),
        decay_rates: out.floats(&decay_rates, "SCALAR", false),
        positions: out.positions(&surface.nodes, None),
        shapes: out.floats(&shapes, "VEC3", false),
        indices: Some(out.indices(quarters.triangles.into_iter().flatten(), None)),
        material: Some(material),
        mass_properties: body.mass.as_ref().map(mass_json),
        extras: Extras::new(&OwnExtras { quadratic: true, max_frequency: *max_frequency }),
        others: Others::new(),
    };
    Ok((model, order.len()))
}

/// √(ω² − d²)/2π \[Hz\], zero where nothing oscillates.
fn observed_frequency(mode: &RingingMode) -> f64 {
    let d = mode.decay_rate / TAU;
    ((mode.frequency - d) * (mode.frequency + d)).max(0.0).sqrt()
}

/// Refuses numbers that 32 bits do not hold, and shapes of other surfaces.
fn check_mode(body: &str, at: usize, mode: &RingingMode, nodes: usize) -> Result<(), AudioWriteError> {
    let good = |x: f64| (x as f32).is_finite();
    let what = if mode.shape.len() != nodes {
        "a shape of another surface"
    } else if !(mode.frequency > 0.0 && good(mode.frequency)) {
        "no positive frequency"
    } else if !(mode.decay_rate >= 0.0 && good(mode.decay_rate)) {
        "no positive decay"
    } else if !mode.shape.iter().all(|u| u.as_vec3().is_finite()) {
        "a shape that is not finite"
    } else {
        return Ok(());
    };
    Err(AudioWriteError::Mode { body: body.into(), mode: at, frequency: mode.frequency, what })
}
