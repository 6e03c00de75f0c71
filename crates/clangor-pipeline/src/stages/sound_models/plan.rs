//! Which sound models a scene needs, planned before anything moves and obtained once it is known what was
//! struck and what broke.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::sound_model::rule::rules_with_pieces;
use clangor_core::sound_model::{AccelerationRule, SoundRule};
use clangor_core::synthesis::SoundSource;
use clangor_core::synthesis::source_rule::{Decision, Reason, SourceKind};
use clangor_core::synthesis::{AccelerationPart, BodyModes, NoModes, SoundModel};

use super::acceleration_plan::{self, AccelerationParts, AccelerationSettings};
use super::error::SoundModelError;
use super::modal_plan::{ModalParts, ModalPlan, ModalPlanSettings, PreparedModes};
use super::patience::allowances;
use super::progress::SoundModelProgress;
use super::report::SoundModels;
use super::store::SoundModelStore;

/// How the parts of sound models are chosen and baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoundModelSettings {
    /// Fields of accelerated bodies.
    pub acceleration: AccelerationSettings,
    /// Whether these fields are heard; otherwise none is baked.
    pub wants_acceleration: bool,
    /// Modes; `None` where they are not heard.
    pub modal: Option<ModalPlanSettings>,
    /// CPU time \[s\], estimated, that all exact models together may take: [`patience`](super::patience).
    pub patience: f64,
}

/// See the module.
#[derive(Clone, Debug)]
pub struct SoundModelPlan {
    settings: SoundModelSettings,
    rules: Vec<SoundRule>,
    /// One rule for the acceleration of all bodies, pieces included.
    acceleration_rule: Option<AccelerationRule>,
    known_acceleration: BTreeMap<BodyId, SoundSource>,
    modal: Option<ModalPlan>,
    known_modal: BTreeMap<BodyId, Arc<ModalModel>>,
}

impl SoundModelPlan {
    /// Plans for bodies; `rules` are those of the bodies present from the beginning.
    pub fn new(bodies: &[Body], rules: &[SoundRule], settings: SoundModelSettings) -> Self {
        let of_modes = |settings| {
            let rules = rules_with_pieces(bodies, rules).iter().map(|rule| rule.modal).collect();
            ModalPlan::new(bodies, rules, settings)
        };
        SoundModelPlan {
            settings,
            rules: rules.to_vec(),
            acceleration_rule: None,
            known_acceleration: BTreeMap::new(),
            modal: settings.modal.map(of_modes),
            known_modal: BTreeMap::new(),
        }
    }

    /// With one rule for the acceleration of all bodies, pieces included, in place of theirs.
    #[must_use]
    pub fn with_acceleration_rule(self, rule: AccelerationRule) -> Self {
        SoundModelPlan { acceleration_rule: Some(rule), ..self }
    }

    /// Gives a body a known source of its acceleration.
    pub fn give_acceleration(&mut self, body: BodyId, source: SoundSource) {
        self.known_acceleration.insert(body, source);
    }

    /// Gives a body known modes with their transfers. Without effect where modes are not heard.
    pub fn give_modal(&mut self, body: BodyId, modes: Arc<ModalModel>) {
        if self.modal.is_some() {
            self.known_modal.insert(body, modes);
        }
    }

    /// Gives known modes to copies of `body`; their transfers are computed. Without effect where modes are
    /// not
    /// heard.
    pub fn give_modes(&mut self, copies: &[BodyId], body: &Body, modes: &ModalModel) {
        if let Some(plan) = &mut self.modal {
            plan.give_modes(copies, body, modes);
        }
    }

    /// Tells the energy that impacts give each body \[J\]: of many forms, the loudest have modes of their
    /// own.
    pub fn give_energies(&mut self, energies: BTreeMap<BodyId, f64>) {
        if let Some(plan) = &mut self.modal {
            plan.give_energies(energies);
        }
    }

    /// Bodies whose motion between impacts matters, because they may vibrate.
    pub fn followed(&self) -> BTreeSet<BodyId> {
        let mut followed = self.modal.as_ref().map(ModalPlan::may_vibrate).unwrap_or_default();
        followed.extend(self.known_modal.keys());
        followed
    }

    /// Finds or bakes the models of those that are `struck`; `bodies` are all that ever were, pieces
    /// included.
    /// A part that cannot be baked makes a remark, and the body has the next best.
    ///
    /// # Errors
    /// [`SoundModelError::Interrupted`], when `progress` breaks.
    pub fn find(
        mut self,
        bodies: &[Body],
        struck: &BTreeSet<BodyId>,
        store: SoundModelStore<'_>,
        progress: &mut dyn FnMut(&SoundModelProgress<'_>) -> ControlFlow<()>,
    ) -> Result<SoundModels, SoundModelError> {
        let rules = match self.acceleration_rule {
            Some(rule) => vec![rule.into(); bodies.len()],
            None => rules_with_pieces(bodies, &self.rules),
        };
        let wanted =
            |id: &BodyId| self.settings.wants_acceleration && !self.known_acceleration.contains_key(id);
        let sounding: BTreeSet<BodyId> = struck.iter().copied().filter(wanted).collect();
        let (settings, patience) = (self.settings.acceleration, self.settings.patience);
        let fields = acceleration_plan::plan(bodies, (&rules[..], &settings), &sounding, store);
        let modes = self.prepare_modes(bodies, struck, store, progress)?;
        // Which of both parts are drafts, and how long the others may take.
        let mut costs: Vec<f64> = fields.fields.iter().map(|f| f.request.cost(store.cache)).collect();
        costs.extend(modes.iter().flat_map(|modes| modes.costs(store.cache)));
        let allowed = allowances(&costs, patience);
        let (of_fields, of_modes) = allowed.split_at(fields.fields.len());
        let AccelerationParts { bodies: mut acceleration, mut obtained, mut remarks } =
            acceleration_plan::find(bodies, &settings, (fields, of_fields), store, progress)?;
        for (body, source) in std::mem::take(&mut self.known_acceleration) {
            let decision = Decision { kind: SourceKind::Own, reason: Reason::Asked };
            acceleration[body.index()] = AccelerationPart { source, kind: SourceKind::Own, decision };
        }
        let mut modal = match modes {
            Some(modes) => modes.find(of_modes, store.cache, progress)?,
            None => without_modes(bodies),
        };
        for (id, modes) in self.known_modal.into_iter().filter(|(id, _)| struck.contains(id)) {
            modal.bodies[id.index()] = BodyModes::Own(modes);
        }
        obtained.extend(modal.obtained);
        remarks.extend(modal.remarks);
        let model = |(acceleration, modal)| SoundModel { acceleration, modal };
        Ok(SoundModels {
            bodies: acceleration.into_iter().zip(modal.bodies).map(model).collect(),
            obtained,
            remarks,
        })
    }

    /// Who has modes; `None` where they are not heard.
    fn prepare_modes(
        &mut self,
        bodies: &[Body],
        struck: &BTreeSet<BodyId>,
        store: SoundModelStore<'_>,
        progress: &mut dyn FnMut(&SoundModelProgress<'_>) -> ControlFlow<()>,
    ) -> Result<Option<PreparedModes>, SoundModelError> {
        let Some(mut plan) = self.modal.take() else { return Ok(None) };
        plan.add_pieces(bodies);
        let wanting = struck.iter().filter(|id| !self.known_modal.contains_key(id)).copied().collect();
        plan.prepare(&wanting, store.cache, progress).map(Some)
    }
}

/// The modal parts where they are not heard.
fn without_modes(bodies: &[Body]) -> ModalParts {
    let without = |body: &Body| {
        BodyModes::None(match body.surface.is_plane() {
            true => NoModes::Unstruck,
            false => NoModes::Unwanted,
        })
    };
    ModalParts { bodies: bodies.iter().map(without).collect(), ..ModalParts::default() }
}
