//! What every body of a scene sounds as: decided by the rules of `clangor_core::synthesis::source_rule`, with
//! the fields that this needs out of the cache, or baked.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_bake::acceleration::{BakeError, BakeOptions, BakeProgress};
use clangor_core::body::{Body, BodyId, Surface};
use clangor_core::sound_model::acceleration::field_evaluator::FieldError;
use clangor_core::sound_model::acceleration::model_evaluator::{BankEvaluator, ModelEvaluator};
use clangor_core::sound_model::acceleration::proxy_field::ProxyFields;
use clangor_core::synthesis::source_rule::{Decision, Reason, SourceKind, decide, source_of};
use clangor_core::synthesis::{SoundRule, SoundSource};

use super::recognise::exact_form;
use super::{SharedRequest, obtain, shared_requests};
use crate::formats::model_cache::{Lookup, ModelCache, model_key};

/// Highest kR of a form that takes no time to compute.
const SMALL_FORM: f64 = 6.0;
/// Most different forms that together take no time.
const MOST_FORMS: usize = 8;

/// What to know of the bodies, and what may be done for them.
#[derive(Clone, Copy, Debug)]
pub struct SourceSettings<'a> {
    /// What the scene says of each body; without a word for one it is [`SoundRule::Auto`].
    pub rules: &'a [SoundRule],
    /// k = 2πf/c [1/m] of the highest frequency that is rendered in full.
    pub max_wavenumber: f64,
    /// Level error of the fields.
    pub accuracy: f64,
    /// Where fields are kept.
    pub cache: Option<&'a ModelCache>,
    /// The ellipsoids.
    pub bank: Option<&'a BankEvaluator>,
    /// Whether to bake what is not in the cache; else such a body sounds as the next best.
    pub bake: bool,
}

impl SourceSettings<'_> {
    /// How fields are baked.
    pub fn bake_options(&self) -> BakeOptions {
        BakeOptions { near_field: true, ..BakeOptions::new(self.max_wavenumber, self.accuracy) }
    }

    /// What each body should sound as, in their order.
    pub fn decide(&self, bodies: &[Body]) -> Vec<Decision> {
        let rule = |index: usize| self.rules.get(index).copied().unwrap_or_default();
        let of = |(index, body)| decide(body, rule(index), self.bank, self.max_wavenumber);
        let mut decisions: Vec<Decision> = bodies.iter().enumerate().map(of).collect();
        if self.bake {
            self.prefer_exact_forms(bodies, &mut decisions);
        }
        decisions
    }

    /// Gives the bodies that would do as ellipsoids fields of their own, if they have exact forms, small
    /// ones, and few different: a coin and a die take a tenth of a second together.
    fn prefer_exact_forms(&self, bodies: &[Body], decisions: &mut [Decision]) {
        let options = self.bake_options();
        let mut forms: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        // Copies share their surface.
        let mut keys: BTreeMap<usize, Option<String>> = BTreeMap::new();
        for (index, (body, decision)) in bodies.iter().zip(&*decisions).enumerate() {
            let Surface::Mesh(surface) = &*body.surface else { continue };
            let small = body.surface.bounding_radius() * self.max_wavenumber <= SMALL_FORM;
            if !(small && matches!(decision.reason, Reason::SmallAndConvex { .. })) {
                continue;
            }
            let key = keys
                .entry(Arc::as_ptr(&body.surface).addr())
                .or_insert_with(|| exact_form(&surface.mesh).map(|geometry| model_key(&geometry, &options)));
            if let Some(key) = key {
                forms.entry(key.clone()).or_default().push(index);
            }
            if forms.len() > MOST_FORMS {
                return;
            }
        }
        let reason = Reason::ExactForm { forms: forms.len() };
        for index in forms.into_values().flatten() {
            decisions[index] = Decision { kind: SourceKind::Own, reason };
        }
    }

    /// The fields that these decisions need, for the bodies that `sounds` names; equal bodies share.
    pub fn requests(
        &self,
        bodies: &[Body],
        decisions: &[Decision],
        sounds: &BTreeSet<BodyId>,
    ) -> Vec<SharedRequest> {
        shared_requests(bodies, self.bake_options(), &|id| {
            sounds.contains(&id) && decisions[id.index()].kind == SourceKind::Own
        })
    }
}

/// What the bodies sound as.
#[derive(Clone, Debug, PartialEq)]
pub struct Sources {
    /// In the order of the bodies.
    pub sources: Vec<SoundSource>,
    /// What each was to be, and why.
    pub decisions: Vec<Decision>,
    /// What each is: the next best where there is no field.
    pub kinds: Vec<SourceKind>,
    /// Fields that were baked now.
    pub baked: usize,
    /// What the person should know.
    pub remarks: Vec<String>,
}

impl Sources {
    /// Gives bodies other sources than were found: models that somebody names.
    pub fn replace(&mut self, given: BTreeMap<BodyId, SoundSource>) {
        for (body, source) in given {
            self.sources[body.index()] = source;
            self.kinds[body.index()] = SourceKind::Own;
            self.decisions[body.index()] = Decision { kind: SourceKind::Own, reason: Reason::Asked };
        }
    }
}

/// How far the baking of a scene's fields is.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceProgress<'a> {
    /// The body whose field is baked, the first of those that share it.
    pub body: &'a str,
    /// Part of all fields, 0 to 1.
    pub done: f64,
    /// What is being done.
    pub stage: &'static str,
}

/// Finds or bakes what the bodies sound as. Only those that `sounds` names are worth a field of their own.
///
/// A field that cannot be baked is told among the remarks, and the body sounds as the next best.
///
/// # Errors
/// [`BakeError::Interrupted`], when `progress` says so.
pub fn sources(
    bodies: &[Body],
    sounds: &BTreeSet<BodyId>,
    settings: &SourceSettings<'_>,
    progress: &mut dyn FnMut(&SourceProgress<'_>) -> ControlFlow<()>,
) -> Result<Sources, BakeError> {
    let decisions = settings.decide(bodies);
    let requests = settings.requests(bodies, &decisions, sounds);
    let mut models: BTreeMap<BodyId, ModelEvaluator> = BTreeMap::new();
    let (mut baked, mut remarks) = (0, Vec::new());
    for (index, shared) in requests.iter().enumerate() {
        let body = bodies[shared.bodies[0].index()].name.as_str();
        let mut on_progress = |p: &BakeProgress| {
            let done = (index as f64 + p.done) / requests.len() as f64;
            progress(&SourceProgress { body, done, stage: p.stage })
        };
        match field(shared, settings, &mut on_progress)? {
            Found::Model { model, baked: now, remarks: more } => {
                baked += usize::from(now);
                remarks.extend(more);
                models.extend(shared.bodies.iter().map(|id| (*id, model.clone())));
            }
            Found::Nothing(why) => remarks.push(why),
        }
    }
    let mut proxies = settings.bank.map(|bank| ProxyFields::new(bank, settings.max_wavenumber));
    let (mut sources, mut kinds) = (Vec::with_capacity(bodies.len()), Vec::with_capacity(bodies.len()));
    for (index, (body, decision)) in bodies.iter().zip(&decisions).enumerate() {
        let own = models.get(&BodyId(index as u32));
        let (source, kind) = source_of(body, decision, proxies.as_mut(), own);
        sources.push(source);
        kinds.push(kind);
    }
    Ok(Sources { sources, decisions, kinds, baked, remarks })
}

/// What became of a request.
enum Found {
    Model {
        model: ModelEvaluator,
        baked: bool,
        remarks: Vec<String>,
    },
    /// And why.
    Nothing(String),
}

fn field(
    shared: &SharedRequest,
    settings: &SourceSettings<'_>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Found, BakeError> {
    let name = &shared.request.solid.name;
    let instead = "it sounds as the ellipsoid or sphere nearest to it";
    if !settings.bake {
        let lookup = settings.cache.map_or(Lookup::Missing, |cache| cache.read(shared.request.key()));
        return Ok(match lookup {
            Lookup::Found(file) => match ModelEvaluator::try_new(&file.acceleration) {
                Ok(model) => Found::Model { model, baked: false, remarks: Vec::new() },
                Err(error) => Found::Nothing(unplayable(name, &error, instead)),
            },
            _ => Found::Nothing(format!("\"{name}\" has no baked field: {instead}")),
        });
    }
    let obtained = match obtain(&shared.request, settings.cache, progress) {
        Ok(obtained) => obtained,
        Err(BakeError::Interrupted) => return Err(BakeError::Interrupted),
        Err(error) => {
            return Ok(Found::Nothing(format!(
                "the field of \"{name}\" cannot be baked: {error}; {instead}"
            )));
        }
    };
    let mut remarks = obtained.remarks;
    remarks.extend(obtained.model.origin.warnings.iter().map(|warning| format!("\"{name}\": {warning}")));
    Ok(match ModelEvaluator::try_new(&obtained.model.acceleration) {
        Ok(model) => Found::Model { model, baked: !obtained.cached, remarks },
        Err(error) => Found::Nothing(unplayable(name, &error, instead)),
    })
}

fn unplayable(name: &str, error: &FieldError, instead: &str) -> String {
    format!("the field of \"{name}\" cannot be played: {error}; {instead}")
}
