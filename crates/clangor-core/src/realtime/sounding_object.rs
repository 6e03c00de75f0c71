//! An object of a real-time engine: a body with acceleration noise, with modes, or with both.
//!
//! Made on any thread other than the audio thread, with all memory that the engine will need for it.

use std::sync::Arc;

use glam::DQuat;

use super::engine_settings::EngineSettings;
use crate::body::{MeshSurface, Surface};
use crate::material::Damping;
use crate::sound_model::acceleration::model_evaluator::ModelEvaluator;
use crate::sound_model::files::model_file::Solid;
use crate::synthesis::live_pulses::LiveField;
use crate::synthesis::modal::ModalSource;
use crate::synthesis::modal::live_voice::LiveVoice;
use crate::synthesis::object_file::{ObjectError, ObjectFile};
use crate::synthesis::{FieldSource, SampleRate, SoundSource};

/// A body with a sound model: see the module.
pub struct SoundingObject {
    /// Source of acceleration noise.
    pub(super) source: Option<SoundSource>,
    /// Its field, with the memory of its pulses.
    pub(super) field: Option<LiveField>,
    /// Its modes.
    pub(super) voice: Option<Box<LiveVoice>>,
    /// Coefficients evaluated by an update of the transfers of all modes.
    pub(super) transfer_work: usize,
    /// Bounding radius \[m\].
    pub(super) radius: f64,
    shape: ObjectShape,
}

/// Settings that the memory of an object depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ObjectShape {
    receivers: usize,
    paths: usize,
    block: usize,
    rate: SampleRate,
}

impl ObjectShape {
    pub(super) fn new(settings: &EngineSettings, paths: usize) -> Self {
        let EngineSettings { receivers, block, sample_rate: rate, .. } = *settings;
        ObjectShape { receivers, paths, block, rate }
    }
}

impl SoundingObject {
    /// A rigid sphere of this radius \[m\], with acceleration noise only.
    pub fn sphere(radius: f64, settings: &EngineSettings) -> Self {
        SoundingObject::new(Some(SoundSource::Sphere { radius }), None, settings)
    }

    /// A body with the acceleration noise of a source, if any, and with modes, if any, for an engine of these
    /// settings.
    pub fn new(
        acceleration: Option<SoundSource>,
        modal: Option<Arc<ModalSource>>,
        settings: &EngineSettings,
    ) -> Self {
        let settings = &settings.clamped();
        let rendering = settings.rendering();
        let field = match &acceleration {
            Some(SoundSource::Field(field)) => Some(LiveField::new(field, &rendering)),
            _ => None,
        };
        let radii =
            [acceleration.as_ref().map(SoundSource::radius), modal.as_ref().map(|modal| modal.radius())];
        let radius = radii.into_iter().flatten().fold(0.0, f64::max);
        let paths = settings.paths();
        let transfer_work = modal
            .as_ref()
            .map_or(0, |modal| modal.transfer_coefficients() * paths.count() * settings.receivers);
        let voice = modal.map(|source| {
            let (receivers, block) = (settings.receivers, settings.block);
            Box::new(LiveVoice::new(source, &rendering, &paths, receivers, block, settings.longest_delay()))
        });
        // Pulses name the field as the engine holds it.
        let source = field.as_ref().map(LiveField::source).or(acceleration);
        let shape = ObjectShape::new(settings, paths.count());
        SoundingObject { source, field, voice, transfer_work, radius, shape }
    }

    /// A body from a file of `clangor bake` or `clangor modes`. Without damping, the modes have that of the
    /// library's material that the file names.
    ///
    /// # Errors
    /// [`ObjectError`].
    pub fn from_file(
        bytes: &[u8],
        damping: Option<&Damping>,
        settings: &EngineSettings,
    ) -> Result<Self, ObjectError> {
        let file = ObjectFile::decode(bytes)?;
        let acceleration = file.acceleration.as_ref().map(ModelEvaluator::try_new).transpose()?;
        let source = acceleration.map(|model| {
            let ModelEvaluator { radius, field, near } = model;
            let surface = Arc::new(surface_of(&file.solid, radius));
            SoundSource::Field(Arc::new(FieldSource::new(field, near, radius, DQuat::IDENTITY, surface)))
        });
        let modal = file.modal_source(damping)?;
        Ok(SoundingObject::new(source, modal, settings))
    }

    /// Whether it was made for an engine of these settings.
    pub(super) fn fits(&self, shape: &ObjectShape) -> bool {
        self.shape == *shape
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
