//! The fields of accelerated bodies: decided by the rules of `clangor_core::synthesis::source_rule`, obtained
//! from the cache or baked.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use clangor_bake::acceleration::{BakeOptions, BakeProgress};
use clangor_bake::cost::{of_field, seconds};
use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::sound_model::SoundRule;
use clangor_core::sound_model::acceleration::model_evaluator::{BankEvaluator, ModelEvaluator};
use clangor_core::sound_model::acceleration::proxy_field::ProxyFields;
use clangor_core::sound_model::files::model_file::ModelFile;
use clangor_core::synthesis::source_rule::{Decision, Reason, SourceKind, decide, source_of};
use clangor_core::synthesis::{AccelerationPart, SoundPart};

use super::acceleration_bake::AccelerationBake;
use super::error::SoundModelError;
use super::obtain::{Obtained, obtain};
use super::progress::SoundModelProgress;
use super::report::ObtainedModel;
use super::request::{RequestedPart, SoundModelRequest, recognised};
use super::store::SoundModelStore;
use crate::formats::model_cache::model_key;

/// Most different forms of bodies that would do as ellipsoids and have fields of their own.
const MOST_FORMS: usize = 8;
/// Part of the patience that their fields may take.
const OWN_SHARE: f64 = 0.5;

/// How the fields of accelerated bodies are chosen and baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationSettings {
    /// Band and accuracy of the fields.
    pub options: BakeOptions,
    /// CPU time \[s\], estimated, that exact models may take: bodies that would do as ellipsoids have fields
    /// of their own where that is little of it.
    pub patience: f64,
}

impl AccelerationSettings {
    /// Fields up to a wavenumber k = 2πf/c [1/m], of a relative error `accuracy` \[-\], also near the body.
    pub fn new(max_wavenumber: f64, accuracy: f64, patience: f64) -> Self {
        let options = BakeOptions { near_field: true, ..BakeOptions::new(max_wavenumber, accuracy) };
        AccelerationSettings { options, patience }
    }

    /// What each body should radiate as, in their order; [`SoundRule::default`] where `rules` end.
    pub fn decide(
        &self,
        bodies: &[Body],
        rules: &[SoundRule],
        bank: Option<&BankEvaluator>,
    ) -> Vec<Decision> {
        let rule = |index: usize| rules.get(index).copied().unwrap_or_default().acceleration;
        let of = |(index, body)| decide(body, rule(index), bank, self.options.max_wavenumber);
        let mut decisions: Vec<Decision> = bodies.iter().enumerate().map(of).collect();
        if self.patience > 0.0 {
            self.prefer_own_fields(bodies, &mut decisions);
        }
        decisions
    }

    /// Gives the bodies that would do as ellipsoids fields of their own, if their forms are few and their
    /// fields take a small part of the patience. Pieces of broken bodies stay ellipsoids: they are many.
    fn prefer_own_fields(&self, bodies: &[Body], decisions: &mut [Decision]) {
        let mut forms: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        // Copies share their surface.
        let mut keys: BTreeMap<usize, String> = BTreeMap::new();
        let mut cost = 0.0;
        for (index, (body, decision)) in bodies.iter().zip(&*decisions).enumerate() {
            let Surface::Mesh(surface) = &*body.surface else { continue };
            let is_piece = body.life.parent.is_some();
            if is_piece || !matches!(decision.reason, Reason::SmallAndConvex { .. }) {
                continue;
            }
            let address = Arc::as_ptr(&body.surface).addr();
            let key = keys.entry(address).or_insert_with(|| {
                let geometry = recognised(&surface.mesh);
                cost += seconds(of_field(&geometry, &self.options));
                model_key(&geometry, &self.options)
            });
            forms.entry(key.clone()).or_default().push(index);
            if forms.len() > MOST_FORMS || cost > OWN_SHARE * self.patience {
                return;
            }
        }
        let reason = Reason::ExactForm { forms: forms.len() };
        for index in forms.into_values().flatten() {
            decisions[index] = Decision { kind: SourceKind::Own, reason };
        }
    }
}

/// A field that bodies of a scene share.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedField {
    /// The field.
    pub request: SoundModelRequest<AccelerationBake>,
    /// The bodies that share it, ascending.
    pub bodies: Vec<BodyId>,
}

/// The fields for the moving bodies that `wants` names; equal bodies share, in the order of their first.
pub fn shared_fields(
    bodies: &[Body],
    options: BakeOptions,
    wants: &dyn Fn(BodyId) -> bool,
) -> Vec<SharedField> {
    let mut shared: Vec<SharedField> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for (index, body) in bodies.iter().enumerate() {
        let id = BodyId(index as u32);
        if body.motion == Motion::Fixed || !wants(id) {
            continue;
        }
        let Ok(request) = SoundModelRequest::of_body(body, AccelerationBake(options)) else { continue };
        match known.get(request.key()) {
            Some(at) => shared[*at].bodies.push(id),
            None => {
                known.insert(request.key().to_owned(), shared.len());
                shared.push(SharedField { request, bodies: vec![id] });
            }
        }
    }
    shared
}

/// The fields of all bodies, and what it took to obtain them.
pub(super) struct AccelerationParts {
    pub(super) bodies: Vec<AccelerationPart>,
    pub(super) obtained: Vec<ObtainedModel>,
    pub(super) remarks: Vec<String>,
}

/// What each body radiates as, and the fields that this takes.
pub(super) struct PlannedFields {
    decisions: Vec<Decision>,
    pub(super) fields: Vec<SharedField>,
}

/// Plans the fields of the bodies. Only bodies in `sounding` get fields of their own.
pub(super) fn plan(
    bodies: &[Body],
    (rules, settings): (&[SoundRule], &AccelerationSettings),
    sounding: &BTreeSet<BodyId>,
    store: SoundModelStore<'_>,
) -> PlannedFields {
    let decisions = settings.decide(bodies, rules, store.bank);
    let fields = shared_fields(bodies, settings.options, &|id| {
        sounding.contains(&id) && decisions[id.index()].kind == SourceKind::Own
    });
    PlannedFields { decisions, fields }
}

/// Finds or bakes the fields within the CPU time \[s\] that each is allowed, and drafts of those that are
/// allowed none or need more. A field that cannot be baked makes a remark, and the body has a draft, or else
/// the next best.
///
/// # Errors
/// [`SoundModelError::Interrupted`], when `progress` breaks.
pub(super) fn find(
    bodies: &[Body],
    settings: &AccelerationSettings,
    (planned, allowed): (PlannedFields, &[Option<f64>]),
    store: SoundModelStore<'_>,
    progress: &mut dyn FnMut(&SoundModelProgress<'_>) -> ControlFlow<()>,
) -> Result<AccelerationParts, SoundModelError> {
    let PlannedFields { decisions, fields } = planned;
    let mut models: BTreeMap<BodyId, ModelEvaluator> = BTreeMap::new();
    let (mut obtained, mut remarks) = (Vec::new(), Vec::new());
    for (index, (shared, allowed)) in fields.iter().zip(allowed).enumerate() {
        let body = bodies[shared.bodies[0].index()].name.as_str();
        let mut on_progress = |p: &BakeProgress| {
            let done = (index as f64 + p.done) / fields.len() as f64;
            progress(&SoundModelProgress { part: SoundPart::Acceleration, body, done, step: p.stage })
        };
        let started = Instant::now();
        match field(&shared.request, *allowed, store, &mut on_progress)? {
            Found::Model { model, cached, remarks: more, draft_of } => {
                obtained.push(ObtainedModel {
                    part: SoundPart::Acceleration,
                    body: shared.bodies[0],
                    bodies: shared.bodies.len(),
                    cached,
                    time: started.elapsed(),
                    draft_of,
                });
                remarks.extend(more);
                models.extend(shared.bodies.iter().map(|id| (*id, model.clone())));
            }
            Found::Nothing(why) => remarks.push(why),
        }
    }
    let mut proxies = store.bank.map(|bank| ProxyFields::new(bank, settings.options.max_wavenumber));
    let part = |(index, (body, decision)): (usize, (&Body, Decision))| {
        let own = models.get(&BodyId(index as u32));
        let (source, kind) = source_of(body, &decision, proxies.as_mut(), own);
        AccelerationPart { source, kind, decision }
    };
    let bodies = bodies.iter().zip(decisions).enumerate().map(part).collect();
    Ok(AccelerationParts { bodies, obtained, remarks })
}

/// What became of a request.
enum Found {
    Model {
        model: ModelEvaluator,
        cached: bool,
        remarks: Vec<String>,
        /// Estimated CPU time \[s\] of the exact field that a draft stands for; infinite if it cannot be
        /// computed.
        draft_of: Option<f64>,
    },
    /// And why.
    Nothing(String),
}

/// One field within the CPU time \[s\] that it is allowed, or its draft: from the cache, or baked.
fn field(
    request: &SoundModelRequest<AccelerationBake>,
    allowed: Option<f64>,
    store: SoundModelStore<'_>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Found, SoundModelError> {
    let name = request.name();
    let instead = "it sounds as the ellipsoid or sphere nearest to it";
    let mut cost = request.cost(store.cache);
    let mut remarks = Vec::new();
    if let Some(seconds) = allowed {
        match obtain(&request.with_part(request.part().within(seconds)), store.cache, progress) {
            Ok(Obtained { file, cached, mut remarks }) => {
                remarks.extend(file.origin.warnings.iter().map(|warning| format!("\"{name}\": {warning}")));
                return Ok(playable((name, instead), &file, (cached, None), remarks));
            }
            Err(SoundModelError::Interrupted) => return Err(SoundModelError::Interrupted),
            Err(error) => match error.too_long() {
                Some(seconds) => cost = seconds,
                None => {
                    cost = f64::INFINITY;
                    remarks.push(format!("the field of \"{name}\" cannot be baked: {error}; it is a draft"));
                }
            },
        }
    }
    let draft = request.with_part(request.part().draft());
    match obtain(&draft, store.cache, progress) {
        Ok(Obtained { file, cached, remarks: more }) => {
            remarks.extend(more);
            remarks.extend(file.origin.warnings.iter().map(|warning| format!("\"{name}\": {warning}")));
            Ok(playable((name, instead), &file, (cached, Some(cost)), remarks))
        }
        Err(SoundModelError::Interrupted) => Err(SoundModelError::Interrupted),
        Err(error) => {
            Ok(Found::Nothing(format!("the field of \"{name}\" cannot be baked: {error}; {instead}")))
        }
    }
}

/// A field that can be evaluated, or why not.
fn playable(
    (name, instead): (&str, &str),
    file: &ModelFile,
    (cached, draft_of): (bool, Option<f64>),
    remarks: Vec<String>,
) -> Found {
    match ModelEvaluator::try_new(&file.acceleration) {
        Ok(model) => Found::Model { model, cached, remarks, draft_of },
        Err(error) => Found::Nothing(format!("the field of \"{name}\" cannot be played: {error}; {instead}")),
    }
}
