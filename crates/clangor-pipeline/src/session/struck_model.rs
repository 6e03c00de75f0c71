//! The sound model of a struck body: given, found in the cache, or baked.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::slice;
use std::sync::Arc;

use clangor_core::acoustics::Acoustics;
use clangor_core::body::BodyId;
use clangor_core::reference::PanSource;
use clangor_core::scene::render_description::PROXY_FREQUENCY;
use clangor_core::sound_model::AccelerationRule;
use clangor_core::sound_model::acceleration::model_evaluator::ModelEvaluator;
use clangor_core::sound_model::files::modal_file::ModalPart;
use clangor_core::synthesis::source_rule::{Decision, Reason, SourceKind, source_of};
use clangor_core::synthesis::{BodyModes, SoundModel, SoundPart};
use clangor_core::synthesis::{RenderSettings, SoundSource, strike};

use super::error::Error;
use super::progress::{Progress, Stage};
use super::struck_body::{KnownSound, StruckBody};
use super::struck_sound::StrikeRemark;
use crate::formats::model_cache::ModelCache;
use crate::formats::soundbank::default_bank;
use crate::stages::sound_models::{
    ModalPlanSettings, ModelOptions, OtherMaterial, SoundModelPlan, SoundModelProgress, SoundModelSettings,
    SoundModelStore,
};

/// Relative error of a wavenumber that was stored.
const STORED_WAVENUMBER: f64 = 1e-9;

/// How the sound model of a struck body is chosen, where it is not given.
#[derive(Clone, Debug, Default)]
pub(crate) struct ModelChoice {
    /// Rule of the acceleration part; chosen by size and convexity otherwise.
    pub(crate) acceleration_rule: Option<AccelerationRule>,
    pub(crate) options: ModelOptions,
    /// Folder of baked models.
    pub(crate) cache: Option<PathBuf>,
}

/// Obtains the parts of the sound model of a struck body, and collects remarks on them.
pub(super) struct StruckModel<'a> {
    pub(super) struck: &'a StruckBody,
    pub(super) choice: &'a ModelChoice,
    /// The impact, with the sample rate resolved.
    pub(super) impact: strike::Strike,
    pub(super) on_progress: &'a mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    pub(super) remarks: Vec<StrikeRemark>,
}

impl StruckModel<'_> {
    /// The modes; `None` if a given model lacks the modal part.
    pub(super) fn modes(&mut self) -> Result<Option<BodyModes>, Error> {
        match &self.struck.known {
            KnownSound::Model(file) => Ok(file.modal.as_ref().map(|part| self.given_modes(part))),
            KnownSound::Modal(file) => Ok(Some(self.given_modes(&file.modal))),
            KnownSound::Pan(_) => Ok(None),
            KnownSound::Nothing | KnownSound::Modes(_) => {
                let settings = SoundModelSettings { wants_acceleration: false, ..self.settings() };
                Ok(Some(self.find(settings)?.modal))
            }
        }
    }

    /// Modes out of a file.
    fn given_modes(&mut self, part: &ModalPart) -> BodyModes {
        let other = OtherMaterial::find(&self.struck.body.material, part);
        self.remarks.extend(other.map(StrikeRemark::OtherMaterial));
        BodyModes::Own(Arc::new(part.model.clone()))
    }

    /// What radiates when the body is accelerated, and its kind; no kind for a source by \[PAN\].
    pub(super) fn source(&mut self) -> Result<(SoundSource, Option<SourceKind>), Error> {
        let body = &self.struck.body;
        let (source, kind) = match &self.struck.known {
            KnownSound::Pan(file) => {
                let model = Arc::new(file.model.clone());
                let source = PanSource::new(model, Arc::clone(&body.surface));
                return Ok((SoundSource::Reference(Arc::new(source)), None));
            }
            KnownSound::Model(file) => {
                let own = ModelEvaluator::try_new(&file.acceleration)
                    .map_err(|source| Error::ModelField { name: body.name.clone(), source })?;
                let decision = Decision { kind: SourceKind::Own, reason: Reason::Asked };
                source_of(body, &decision, None, Some(&own))
            }
            KnownSound::Nothing | KnownSound::Modes(_) | KnownSound::Modal(_) => {
                let settings = SoundModelSettings { modal: None, ..self.settings() };
                let found = self.find(settings)?.acceleration;
                (found.source, found.kind)
            }
        };
        if let SoundSource::Field(field) = &source {
            let (end, band) =
                (field.max_frequency(self.impact.medium.sound_speed), self.render_settings().band().0);
            if end < band * (1.0 - STORED_WAVENUMBER) {
                self.remarks.push(StrikeRemark::ShortField { body: body.name.clone(), end, band });
            }
        }
        Ok((source, Some(kind)))
    }

    /// How the impact is rendered.
    fn render_settings(&self) -> RenderSettings {
        RenderSettings {
            sample_rate: self.impact.sample_rate,
            start: 0.0,
            acoustics: Acoustics {
                medium: self.impact.medium,
                max_frequency: self.impact.max_frequency,
                ..Acoustics::default()
            },
            sphere_model: self.impact.sphere_model,
        }
    }

    /// How both parts are baked.
    fn settings(&self) -> SoundModelSettings {
        let (models, render) = (&self.choice.options, self.render_settings());
        let options = models.modal(render.acoustics.medium, render.band().0);
        SoundModelSettings {
            acceleration: models.acceleration(render.max_wavenumber()),
            wants_acceleration: true,
            modal: Some(ModalPlanSettings { options, proxy_frequency: PROXY_FREQUENCY }),
            patience: models.patience(),
        }
    }

    /// Finds or bakes the parts that the settings ask for.
    fn find(&mut self, settings: SoundModelSettings) -> Result<SoundModel, Error> {
        let ModelChoice { acceleration_rule, cache, .. } = self.choice;
        let struck = self.struck;
        let bodies = slice::from_ref(&struck.body);
        let (cache, bank) = (ModelCache::find(cache.as_deref()), default_bank());
        let store = SoundModelStore { cache: cache.as_ref(), bank: bank.as_ref() };
        let mut plan = SoundModelPlan::new(bodies, &[], settings);
        if let Some(rule) = *acceleration_rule {
            plan = plan.with_acceleration_rule(rule);
        }
        if let KnownSound::Modes(modes) = &struck.known {
            plan.give_modes(&[BodyId(0)], &struck.body, modes);
        }
        let on_progress = &mut *self.on_progress;
        let mut reached = |p: &SoundModelProgress<'_>| {
            let stage = if p.part == SoundPart::Modal { Stage::Modal } else { Stage::Acceleration };
            on_progress(&Progress { stage, done: p.done, body: p.body, step: p.step })
        };
        let mut found = plan.find(bodies, &BTreeSet::from([BodyId(0)]), store, &mut reached)?;
        self.remarks.extend(found.remarks.drain(..).map(StrikeRemark::SoundModel));
        let drafts = found.drafts().map(|draft| (draft.part, draft.draft_of.unwrap_or(0.0)));
        self.remarks.extend(drafts.map(|(part, seconds)| StrikeRemark::Draft {
            body: struck.body.name.clone(),
            part,
            seconds,
        }));
        Ok(found.bodies.swap_remove(0))
    }
}
