//! The sound model of one body, or those that the bodies of a scene need, baked ahead of their use.
//!
//! A part that is in the cache is not baked again; what is baked is kept there. The modal part depends on the
//! material, the acceleration part does not.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clangor_bake::acceleration::{BakeOptions, BakeProgress};
use clangor_bake::reference::PanForm;
use clangor_core::medium::Medium;
use clangor_core::reference::pan_file::PanFile;
use clangor_core::scene::render_description::Parts;
use clangor_core::sound_model::files::modal_file::ModalFile;
use clangor_core::sound_model::files::model_file::ModelFile;

use super::error::Error;
use super::named_body::NamedSolid;
use super::progress::{Progress, Stage};
use crate::formats::atomic_file::write_atomically;
use crate::formats::model_cache::ModelCache;
use crate::stages::sound_models::model_options::HIGHEST_BAND_LIMIT;
use crate::stages::sound_models::obtain::BakedPart;
use crate::stages::sound_models::{
    AccelerationBake, ModalBake, ModelOptions, Obtained, RequestError, SoundModelRequest, obtain,
    pan_representation,
};

/// Highest frequency that is heard \[Hz\].
const AUDIBLE: f64 = 20_000.0;

/// How sound models are baked.
///
/// ```no_run
/// use clangor_pipeline::session::{Bake, NamedSolid};
/// use clangor_pipeline::stages::sound_models::ModelOptions;
/// use std::ops::ControlFlow;
///
/// let coin = NamedSolid::open("coin", 1.0, None)?;
/// let coarse = ModelOptions { accuracy: Some(0.02), ..ModelOptions::default() };
/// let model = Bake::new().models(coarse).body(&coin, &mut |_| ControlFlow::Continue(()))?;
/// model.file.write("coin.safetensors")?;
/// # Ok::<(), clangor_pipeline::session::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bake {
    parts: Option<Parts>,
    pub(super) models: ModelOptions,
    near_field: bool,
    cache: Option<PathBuf>,
}

impl Default for Bake {
    fn default() -> Self {
        Bake::new()
    }
}

impl Bake {
    /// Both parts where the material is known, with the near field, by the default [`ModelOptions`].
    pub fn new() -> Self {
        Bake { parts: None, models: ModelOptions::default(), near_field: true, cache: None }
    }

    /// Parts of the sound model; the ground has none.
    #[must_use]
    pub fn parts(self, parts: Parts) -> Self {
        Bake { parts: Some(parts), ..self }
    }

    /// How the models are baked, whatever their patience: exact ones, or drafts with
    /// [`Quality::Draft`](crate::stages::sound_models::Quality::Draft).
    #[must_use]
    pub fn models(self, models: ModelOptions) -> Self {
        Bake { models, ..self }
    }

    /// Whether the field inside the bounding sphere is baked, which only listeners there need.
    #[must_use]
    pub fn near_field(self, near_field: bool) -> Self {
        Bake { near_field, ..self }
    }

    /// Folder of baked sound models. Default: `CLANGOR_CACHE`, or the system's folder for caches.
    #[must_use]
    pub fn cache(self, folder: impl Into<PathBuf>) -> Self {
        Bake { cache: Some(folder.into()), ..self }
    }

    /// The sound model of a body. Progress goes to `on_progress`, which breaks to stop.
    ///
    /// # Errors
    /// [`Error::ModelOptions`], [`Error::ModalMaterial`] for the modal part of a body without material,
    /// [`Error::Unbakeable`], [`Error::Models`].
    pub fn body(&self, solid: &NamedSolid, on_progress: &mut OnStep<'_>) -> Result<BakedBody, Error> {
        let started = Instant::now();
        self.models.check(2.0 * HIGHEST_BAND_LIMIT)?;
        let highest = self.models.max_frequency.unwrap_or(AUDIBLE);
        let parts = self.parts.unwrap_or(Parts { modal: solid.material.is_some(), ..Parts::default() });
        let modal = match (parts.modal, &solid.material) {
            (false, _) => None,
            (true, None) => return Err(Error::ModalMaterial),
            (true, Some(material)) => {
                let options = self.models.of_modes(self.models.modal(Medium::AIR, highest));
                let part = match &solid.modal {
                    Some(modes) => ModalBake::of_known_modes(material, modes.clone(), options),
                    None => ModalBake::new(material, options),
                };
                Some(self.part(solid, part, Stage::Modal, on_progress)?)
            }
        };
        let acceleration = match parts.acceleration {
            true => {
                let max_wavenumber = TAU * highest / Medium::AIR.sound_speed;
                let part = AccelerationBake(self.field_options(max_wavenumber));
                Some(self.part(solid, part, Stage::Acceleration, on_progress)?)
            }
            false => None,
        };
        BakedBody::try_new(&solid.name, acceleration, modal, started).ok_or(Error::NoParts)
    }

    /// One part of the sound model of a body.
    fn part<P: BakedPart>(
        &self,
        solid: &NamedSolid,
        part: P,
        stage: Stage,
        on_progress: &mut OnStep<'_>,
    ) -> Result<Obtained<P::File>, Error> {
        let (surface, mass) = (&solid.geometry.surface, solid.geometry.mass);
        let unbakeable = |source: RequestError| Error::Unbakeable { name: solid.name.clone(), source };
        let request = SoundModelRequest::new(&solid.name, surface, mass, part).map_err(unbakeable)?;
        obtain_part(&request, self.model_cache().as_ref(), stage, on_progress)
    }

    /// The cache; `None` on a system without a folder for caches.
    pub(super) fn model_cache(&self) -> Option<ModelCache> {
        ModelCache::find(self.cache.as_deref())
    }

    /// The parts of models in a scene.
    pub(super) fn scene_parts(&self) -> Parts {
        self.parts.unwrap_or_default()
    }

    /// How the acceleration part is baked up to a wavenumber k [1/m].
    pub(super) fn field_options(&self, max_wavenumber: f64) -> BakeOptions {
        let exact =
            BakeOptions { near_field: self.near_field, ..self.models.acceleration(max_wavenumber).options };
        self.models.of_field(exact)
    }
}

/// Receives the progress of baking; breaks to stop it.
pub type OnStep<'a> = dyn FnMut(&Progress<'_>) -> ControlFlow<()> + 'a;

/// Obtains a part and reports its progress as that of a stage.
pub(super) fn obtain_part<P: BakedPart>(
    request: &SoundModelRequest<P>,
    cache: Option<&ModelCache>,
    stage: Stage,
    on_progress: &mut OnStep<'_>,
) -> Result<Obtained<P::File>, Error> {
    let mut reached = |p: &BakeProgress| {
        on_progress(&Progress { stage, done: p.done, body: request.name(), step: p.stage })
    };
    Ok(obtain(request, cache, &mut reached)?)
}

/// The baked sound model of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedBody {
    /// The model.
    pub file: BakedFile,
    /// Whether all its parts were in the cache.
    pub cached: bool,
    /// Wall-clock time.
    pub time: Duration,
    /// Replaced entries of the cache and warnings of the solver, of the acceleration part.
    pub acceleration_remarks: Vec<String>,
    /// The same, of the modal part.
    pub modal_remarks: Vec<String>,
}

/// The file of a baked sound model.
#[derive(Clone, Debug, PartialEq)]
pub enum BakedFile {
    /// The acceleration part, and the modal part if that is asked for.
    Model(Box<ModelFile>),
    /// The modal part alone.
    Modal(Box<ModalFile>),
}

impl BakedBody {
    /// Joins the parts; `None` without any.
    fn try_new(
        name: &str,
        acceleration: Option<Obtained<ModelFile>>,
        modal: Option<Obtained<ModalFile>>,
        started: Instant,
    ) -> Option<Self> {
        let cached = acceleration.as_ref().is_none_or(|part| part.cached)
            && modal.as_ref().is_none_or(|part| part.cached);
        let acceleration_remarks =
            acceleration.as_ref().map_or(Vec::new(), |part| remarks(name, part, &part.file.origin.warnings));
        let modal_remarks =
            modal.as_ref().map_or(Vec::new(), |part| remarks(name, part, &part.file.modal.origin.warnings));
        let file = match (acceleration, modal) {
            (Some(part), modal) => {
                let file = ModelFile { modal: modal.map(|modal| modal.file.modal), ..part.file };
                BakedFile::Model(Box::new(file))
            }
            (None, Some(part)) => BakedFile::Modal(Box::new(part.file)),
            (None, None) => return None,
        };
        let time = started.elapsed();
        Some(BakedBody { file, cached, time, acceleration_remarks, modal_remarks })
    }
}

/// What a user should know of the cache and of a part.
pub(super) fn remarks<F>(name: &str, part: &Obtained<F>, warnings: &[String]) -> Vec<String> {
    let warnings = warnings.iter().map(|warning| format!("\"{name}\": {warning}"));
    part.remarks.iter().cloned().chain(warnings).collect()
}

impl BakedFile {
    /// Writes the file, and returns its size in bytes.
    ///
    /// # Errors
    /// [`Error::Encode`] and [`Error::Output`]; the file appears only once it is complete.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<u64, Error> {
        let bytes = match self {
            BakedFile::Model(file) => file.encode()?,
            BakedFile::Modal(file) => file.encode()?,
        };
        write_atomically(path.as_ref(), &bytes)?;
        Ok(bytes.len() as u64)
    }
}

/// Writes the acceleration part of a model in the representation of \[PAN\], and returns it with its size in
/// bytes.
///
/// # Errors
/// [`Error::Pan`], [`Error::Encode`] and [`Error::Output`].
pub fn write_pan(model: &ModelFile, form: PanForm, path: impl AsRef<Path>) -> Result<(PanFile, u64), Error> {
    let file = pan_representation(model, form)?;
    let bytes = file.encode()?;
    write_atomically(path.as_ref(), &bytes)?;
    Ok((file, bytes.len() as u64))
}
