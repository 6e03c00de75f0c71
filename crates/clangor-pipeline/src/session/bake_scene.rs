//! The sound models that the bodies of a scene need, baked into the cache.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clangor_core::acoustics::Acoustics;
use clangor_core::scene::Scene;
use clangor_core::sound_model::files::model_file::ModelFile;
use clangor_core::synthesis::SoundPart;
use clangor_core::synthesis::source_rule::SourceKind;
use clangor_core::synthesis::{RenderSettings, SampleRate};

use super::bake::{Bake, OnStep, obtain_part, remarks};
use super::error::Error;
use super::progress::{Progress, Stage};
use crate::formats::model_cache::ModelCache;
use crate::formats::soundbank::default_bank;
use crate::stages::find_impact_modes::find_impact_modes;
use crate::stages::load::LoadedScene;
use crate::stages::sound_models::acceleration_plan::{SharedField, shared_fields};
use crate::stages::sound_models::{
    ModalPlanSettings, Quality, SoundModelPlan, SoundModelProgress, SoundModelSettings, SoundModelStore,
    SoundModels,
};

/// The sound models of a scene that are to be baked.
#[derive(Debug)]
pub struct SceneBake<'a> {
    bake: &'a Bake,
    loaded: &'a LoadedScene,
    rendered: RenderSettings,
    cache: ModelCache,
    fields: Vec<SharedField>,
}

/// An acceleration field in the cache.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedField {
    /// The first body that has it.
    pub name: String,
    /// Number of bodies that share it.
    pub bodies: usize,
    /// The model.
    pub file: ModelFile,
    /// The entry of the cache.
    pub path: PathBuf,
    /// Whether it was there before.
    pub cached: bool,
    /// Wall-clock time.
    pub time: Duration,
    /// Replaced entries of the cache and warnings of the solver.
    pub remarks: Vec<String>,
}

impl Bake {
    /// Plans the models of a scene: fields for the bodies that are decided to have their own, one for each
    /// form.
    ///
    /// # Errors
    /// [`Error::NoCache`], [`Error::Synthesis`], and [`Error::ModelOptions`] as in a render of the scene.
    pub fn scene<'a>(&'a self, loaded: &'a LoadedScene) -> Result<SceneBake<'a>, Error> {
        let cache = self.model_cache().ok_or(Error::NoCache)?;
        let (scene, bodies) = (&loaded.scene, &loaded.world.bodies);
        let rendered = self.render_settings(scene)?;
        let highest = rendered.max_wavenumber();
        let bank = default_bank();
        let decisions = self.models.acceleration(highest).decide(bodies, &scene.sound_rules(), bank.as_ref());
        let fields = match self.scene_parts().acceleration {
            true => shared_fields(bodies, self.field_options(highest), &|id| {
                decisions[id.index()].kind == SourceKind::Own
            }),
            false => Vec::new(),
        };
        Ok(SceneBake { bake: self, loaded, rendered, cache, fields })
    }

    /// How a scene is rendered by the same options.
    fn render_settings(&self, scene: &Scene) -> Result<RenderSettings, Error> {
        let sample_rate = SampleRate::try_new(scene.render.sample_rate)?;
        self.models.check(sample_rate.as_f64())?;
        Ok(RenderSettings {
            sample_rate,
            start: 0.0,
            acoustics: Acoustics {
                max_frequency: self.models.max_frequency.or(scene.acoustics.max_frequency),
                ..scene.acoustics
            },
            sphere_model: scene.render.radiation,
        })
    }
}

impl SceneBake<'_> {
    /// The cache.
    pub fn cache(&self) -> &ModelCache {
        &self.cache
    }

    /// The acceleration fields to bake.
    pub fn fields(&self) -> &[SharedField] {
        &self.fields
    }

    /// Number of bodies without a field of their own.
    pub fn bodies_without_field(&self) -> usize {
        self.loaded.world.bodies.len() - self.fields.iter().map(|field| field.bodies.len()).sum::<usize>()
    }

    /// Finds or bakes one of the [`fields`](Self::fields). Progress goes to `on_progress`, which breaks to
    /// stop.
    ///
    /// # Errors
    /// [`Error::Models`].
    pub fn bake_field(&self, field: &SharedField, on_progress: &mut OnStep<'_>) -> Result<BakedField, Error> {
        let started = Instant::now();
        let obtained = obtain_part(&field.request, Some(&self.cache), Stage::Acceleration, on_progress)?;
        let time = started.elapsed();
        let name = self.loaded.world.bodies[field.bodies[0].index()].name.clone();
        Ok(BakedField {
            remarks: remarks(&name, &obtained, &obtained.file.origin.warnings),
            name,
            bodies: field.bodies.len(),
            file: obtained.file,
            path: self.cache.path::<ModelFile>(field.request.key()),
            cached: obtained.cached,
            time,
        })
    }

    /// Finds or bakes the modes of all bodies that may ring, and those with which they meet impacts; `None`
    /// if the modal part is not asked for, or not rendered. Progress goes to `on_progress`, which breaks to
    /// stop.
    ///
    /// # Errors
    /// [`Error::Models`].
    pub fn bake_modes(&self, on_progress: &mut OnStep<'_>) -> Result<Option<SoundModels>, Error> {
        let (scene, bodies) = (&self.loaded.scene, &self.loaded.world.bodies);
        if !(self.bake.scene_parts().modal && scene.render.parts.modal) {
            return Ok(None);
        }
        let (models, rendered) = (&self.bake.models, &self.rendered);
        let modal = ModalPlanSettings {
            options: models.modal(rendered.acoustics.medium, rendered.band().0),
            proxy_frequency: scene.render.proxy_frequency,
        };
        let settings = SoundModelSettings {
            acceleration: models.acceleration(rendered.max_wavenumber()),
            // The fields have been planned.
            wants_acceleration: false,
            modal: Some(modal),
            patience: if models.quality == Quality::Draft { 0.0 } else { f64::INFINITY },
        };
        let plan = SoundModelPlan::new(bodies, &scene.sound_rules(), settings);
        let all = plan.followed();
        let bank = default_bank();
        let store = SoundModelStore { cache: Some(&self.cache), bank: bank.as_ref() };
        let mut reached = |p: &SoundModelProgress<'_>| {
            let stage = if p.part == SoundPart::Modal { Stage::Modal } else { Stage::Acceleration };
            on_progress(&Progress { stage, done: p.done, body: p.body, step: p.step })
        };
        let mut found = plan.find(bodies, &all, store, &mut reached)?;
        // The modes with which they meet impacts have a band of their own.
        found.remarks.extend(find_impact_modes(self.loaded, Some(&self.cache), &mut reached)?.remarks);
        Ok(Some(found))
    }
}
