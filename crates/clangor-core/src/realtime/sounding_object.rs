//! What a live engine can let sound besides spheres: a body with a field, with modes, or with both.
//!
//! Made by whoever has time, on any thread; the engine gets it whole, with all memory that it will ever need.

use std::sync::Arc;

use glam::DQuat;

use super::engine::EngineSettings;
use crate::body::{MeshSurface, Surface};
use crate::material::{Damping, presets};
use crate::sound_model::acceleration::field_evaluator::FieldError;
use crate::sound_model::acceleration::model_evaluator::ModelEvaluator;
use crate::sound_model::files::modal_file::{ModalFile, ModalPart};
use crate::sound_model::files::model_file::{ModelFile, Solid};
use crate::sound_model::files::tensor_file::TensorFileError;
use crate::synthesis::live_pulses::LiveField;
use crate::synthesis::modal::live_voice::LiveVoice;
use crate::synthesis::modal::{ModalError, ModalSettings, ModalSource};
use crate::synthesis::{FieldSource, SampleRate, SoundSource};

/// Why bytes are no object that sounds.
#[derive(Debug, thiserror::Error)]
pub enum ObjectError {
    /// Neither a sound model nor a modal model.
    #[error("the sound model cannot be read: {0}")]
    File(#[from] TensorFileError),
    /// A field that contradicts itself.
    #[error("the field of the sound model cannot be played: {0}")]
    Field(#[from] FieldError),
    /// Modes that contradict themselves.
    #[error("the modes of the sound model cannot be played: {0}")]
    Modes(#[from] ModalError),
    /// A material of which only the name is known.
    #[error(
        "the model rings as \"{material}\", which is no material of the library: its damping must be given"
    )]
    UnknownDamping {
        /// The name.
        material: String,
    },
}

/// See the module.
pub struct SoundingObject {
    /// What clicks.
    pub(super) click: Option<SoundSource>,
    /// The same, for the engine to keep.
    pub(super) field: Option<LiveField>,
    /// What rings.
    pub(super) voice: Option<Box<LiveVoice>>,
    /// Work of setting the transfers of all modes anew.
    pub(super) transfer_work: usize,
    /// Bounding radius \[m\].
    pub(super) radius: f64,
    shape: Shape,
}

/// What the memory of an object depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    receivers: usize,
    paths: usize,
    block: usize,
    rate: SampleRate,
}

impl Shape {
    fn new(settings: &EngineSettings, paths: usize) -> Self {
        let EngineSettings { receivers, block, sample_rate: rate, .. } = *settings;
        Shape { receivers, paths, block, rate }
    }
}

impl SoundingObject {
    /// A body that clicks as a source does, if any, and rings as another does, if any.
    pub fn new(
        click: Option<SoundSource>,
        ringing: Option<Arc<ModalSource>>,
        settings: &EngineSettings,
    ) -> Self {
        let settings = &settings.clamped();
        let rendering = settings.rendering();
        let field = match &click {
            Some(SoundSource::Field(field)) => Some(LiveField::new(field, &rendering)),
            _ => None,
        };
        let radii = [click.as_ref().map(SoundSource::radius), ringing.as_ref().map(|r| r.radius())];
        let radius = radii.into_iter().flatten().fold(0.0, f64::max);
        let paths = settings.paths();
        let transfer_work = ringing
            .as_ref()
            .map_or(0, |ringing| ringing.transfer_coefficients() * paths.count() * settings.receivers);
        let voice = ringing.map(|source| {
            let (receivers, block) = (settings.receivers, settings.block);
            Box::new(LiveVoice::new(source, &rendering, &paths, receivers, block, settings.longest_delay()))
        });
        // As the engine knows it.
        let click = field.as_ref().map(LiveField::source).or(click);
        let shape = Shape::new(settings, paths.count());
        SoundingObject { click, field, voice, transfer_work, radius, shape }
    }

    /// A body as `clangor bake` or `clangor modes` writes it. How long modes ring is the material's; without
    /// damping, that of the library's material of the same name.
    ///
    /// # Errors
    /// [`ObjectError`].
    pub fn from_file(
        bytes: &[u8],
        damping: Option<&Damping>,
        settings: &EngineSettings,
    ) -> Result<Self, ObjectError> {
        let (acceleration, modal, solid) = match ModelFile::decode(bytes) {
            Ok(file) => (Some(ModelEvaluator::try_new(&file.acceleration)?), file.modal, file.solid),
            Err(error) => match ModalFile::decode(bytes) {
                Ok(file) => (None, Some(file.modal), file.solid),
                Err(_) => return Err(error.into()),
            },
        };
        let click = acceleration.map(|model| {
            let ModelEvaluator { radius, field, near } = model;
            let surface = Arc::new(surface_of(&solid, radius));
            SoundSource::Field(Arc::new(FieldSource::new(field, near, radius, DQuat::IDENTITY, surface)))
        });
        let ringing = modal.map(|part| source_of(part, damping)).transpose()?;
        Ok(SoundingObject::new(click, ringing, settings))
    }

    /// Whether it was made for an engine of these settings and so many paths.
    pub(super) fn fits(&self, settings: &EngineSettings, paths: usize) -> bool {
        self.shape == Shape::new(settings, paths)
    }

    /// Bounding radius \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

fn surface_of(solid: &Solid, radius: f64) -> Surface {
    match &solid.surface {
        None => Surface::Sphere { radius },
        Some(mesh) => {
            let flat = vec![0.0; mesh.vertices.len()];
            Surface::Mesh(MeshSurface::restored(mesh.clone(), flat, solid.mass.volume))
        }
    }
}

fn source_of(part: ModalPart, damping: Option<&Damping>) -> Result<Arc<ModalSource>, ObjectError> {
    let ModalPart { model, origin } = part;
    let known = || presets::preset(&origin.material).map(|material| material.damping);
    let Some(damping) = damping.cloned().or_else(known) else {
        return Err(ObjectError::UnknownDamping { material: origin.material });
    };
    Ok(Arc::new(ModalSource::new(Arc::new(model), &damping, &ModalSettings::default())?))
}
