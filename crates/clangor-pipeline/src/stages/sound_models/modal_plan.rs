//! The modes of the bodies of a scene.
//!
//! Every body that is struck has modes, unless the scene excludes them: those of the body as its supports
//! hold it, and of a body that nothing holds, fixed or not, those of the free body. They are computed once
//! for all bodies of the same form, material and supports. Where forms are many, as in a heap of stones, the
//! loudest have modes of their own, and the others those of the nearest ellipsoid (`crowd`). A body whose
//! modes all lie above the band is distinguished from one whose modes cannot be computed.
//!
//! A large body that does not move, such as a table top, has a draft of its modes unless the scene asks for
//! its own: its many modes at short waves would take longer than all the rest.
//!
//! Pieces of a broken body follow the rule of that body; left to themselves, those with a lowest frequency
//! above a threshold have the modes of ellipsoids (`piece_proxies`), and the rest their own.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use clangor_bake::acceleration::BakeProgress;
use clangor_bake::modal::{Effort, ModalBakeOptions};
use clangor_bake::soundbank::modal::ModalSoundbankBakeError;
use clangor_core::body::{Body, BodyId};
use clangor_core::sound_model::ModalRule;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::synthesis::{BodyModes, NoModes, SoundPart};

use super::crowd::{Divided, divide};
use super::error::SoundModelError;
use super::modal_bake::{ModalBake, vibrates_alike};
use super::obtain::{Obtained, obtain};
use super::piece_proxies::{Candidate, Choice, choose};
use super::progress::SoundModelProgress;
use super::report::ObtainedModel;
use super::request::{RequestedPart, SoundModelRequest};
use crate::formats::model_cache::ModelCache;

/// Most different forms and materials whose modes are all computed without being asked for.
pub const MOST_FORMS: usize = 16;

/// How the modes of bodies are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModalPlanSettings {
    /// Mesh error, accuracy, band and medium.
    pub options: ModalBakeOptions,
    /// Pieces of a lowest frequency above this \[Hz\] have the modes of ellipsoids.
    pub proxy_frequency: f64,
}

/// kR at the highest frequency above which a body that does not move has a draft of its modes.
const LARGE: f64 = 40.0;

impl ModalPlanSettings {
    /// How the modes of a body are computed under a rule.
    fn options_of(&self, body: &Body, rule: ModalRule) -> ModalBakeOptions {
        let ModalBakeOptions { medium, max_frequency, .. } = self.options;
        let size = TAU * max_frequency / medium.sound_speed * body.surface.bounding_radius();
        let large = rule == ModalRule::Auto && !body.motion.is_movable() && size > LARGE;
        ModalBakeOptions { effort: if large { Effort::Draft } else { self.options.effort }, ..self.options }
    }
}

/// Modes that bodies of a scene share.
#[derive(Clone, Debug)]
struct SharedModes {
    request: SoundModelRequest<ModalBake>,
    bodies: Vec<BodyId>,
}

/// Which bodies may have modes, before anything moves.
#[derive(Clone, Debug)]
pub(super) struct ModalPlan {
    /// Of each body, as far as is known.
    bodies: Vec<BodyModes>,
    /// What is wanted, and who shares it.
    requests: Vec<SharedModes>,
    /// Bodies that may have the modes of an ellipsoid.
    candidates: Vec<Candidate>,
    /// Bodies of too many forms, that may have either.
    crowd: Vec<Candidate>,
    /// Energy that impacts give each body \[J\], which decides who is loud.
    energies: BTreeMap<BodyId, f64>,
    names: Vec<String>,
    rules: Vec<ModalRule>,
    settings: ModalPlanSettings,
}

/// The modes of all bodies, and what it took to obtain them.
#[derive(Debug, Default)]
pub(super) struct ModalParts {
    pub(super) bodies: Vec<BodyModes>,
    pub(super) obtained: Vec<ObtainedModel>,
    pub(super) remarks: Vec<String>,
}

impl ModalPlan {
    /// Plans for bodies under one rule each.
    pub(super) fn new(bodies: &[Body], rules: Vec<ModalRule>, settings: ModalPlanSettings) -> Self {
        let mut plan = ModalPlan {
            bodies: vec![BodyModes::None(NoModes::Unstruck); bodies.len()],
            requests: Vec::new(),
            candidates: Vec::new(),
            crowd: Vec::new(),
            energies: BTreeMap::new(),
            names: bodies.iter().map(|body| body.name.clone()).collect(),
            rules,
            settings,
        };
        // Copies share their surface, and to recognise its form takes time.
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        let mut copies: BTreeMap<(usize, bool), Vec<usize>> = BTreeMap::new();
        let mut unasked = BTreeSet::new();
        for (index, body) in bodies.iter().enumerate() {
            let (id, rule) = (BodyId(index as u32), plan.rules[index]);
            if body.surface.is_plane() {
                continue;
            }
            if rule == ModalRule::Never {
                plan.bodies[index] = BodyModes::None(NoModes::Unwanted);
                continue;
            }
            // No ellipsoid of the bank has supports.
            let always = rule == ModalRule::Proxy && body.supports.is_empty();
            let piece = rule == ModalRule::Auto && body.life.parent.is_some();
            if always || piece {
                plan.candidates.push(Candidate { id, body: body.clone(), always });
                continue;
            }
            if rule == ModalRule::Auto && unasked.len() > MOST_FORMS {
                plan.crowd.push(Candidate { id, body: body.clone(), always: true });
                continue;
            }
            let options = settings.options_of(body, rule);
            let draft = options.effort == Effort::Draft;
            let same = copies.entry((Arc::as_ptr(&body.surface).addr(), draft)).or_default();
            let equal = |at: &&usize| vibrates_alike(&bodies[plan.requests[**at].bodies[0].index()], body);
            let at = match same.iter().find(equal) {
                Some(at) => *at,
                None => {
                    let part = ModalBake::of_body(body, options);
                    let Ok(request) = SoundModelRequest::of_body(body, part) else { continue };
                    let at = *known.entry(request.key().to_owned()).or_insert(plan.requests.len());
                    if at == plan.requests.len() {
                        plan.requests.push(SharedModes { request, bodies: Vec::new() });
                    }
                    same.push(at);
                    at
                }
            };
            if rule == ModalRule::Auto {
                unasked.insert(at);
            }
            plan.requests[at].bodies.push(id);
        }
        if unasked.len() > MOST_FORMS {
            plan.crowd_unasked(bodies);
        }
        plan
    }

    /// Leaves only the requests that the scene asks for; the other bodies join the crowd.
    fn crowd_unasked(&mut self, bodies: &[Body]) {
        let ModalPlan { requests, rules, crowd, .. } = self;
        let asked = |id: &BodyId| rules[id.index()] != ModalRule::Auto;
        for SharedModes { bodies: own, .. } in &mut *requests {
            let others = own.iter().filter(|id| !asked(id));
            crowd.extend(others.map(|id| Candidate {
                id: *id,
                body: bodies[id.index()].clone(),
                always: true,
            }));
            own.retain(asked);
        }
        requests.retain(|shared| !shared.bodies.is_empty());
    }

    /// Tells the energy that impacts give each body \[J\].
    pub(super) fn give_energies(&mut self, energies: BTreeMap<BodyId, f64>) {
        self.energies = energies;
    }

    /// Gives known modes to copies of one body; only their transfers are to be computed.
    pub(super) fn give_modes(&mut self, copies: &[BodyId], body: &Body, modes: &ModalModel) {
        self.requests.iter_mut().for_each(|shared| shared.bodies.retain(|id| !copies.contains(id)));
        self.requests.retain(|shared| !shared.bodies.is_empty());
        self.candidates.retain(|candidate| !copies.contains(&candidate.id));
        self.crowd.retain(|candidate| !copies.contains(&candidate.id));
        let part = ModalBake::of_known_modes(&body.material, modes.clone(), self.settings.options);
        let request = SoundModelRequest::of_body(body, part);
        if let Ok(request) = request {
            self.requests.push(SharedModes { request, bodies: copies.to_vec() });
        }
    }

    /// Adds the bodies born since; `bodies` are all that ever were.
    pub(super) fn add_pieces(&mut self, bodies: &[Body]) {
        for body in bodies.iter().skip(self.bodies.len()) {
            let id = BodyId(self.bodies.len() as u32);
            let parent = body.life.parent.and_then(|parent| self.rules.get(parent.index()));
            let rule = parent.copied().unwrap_or_default();
            self.rules.push(rule);
            self.names.push(body.name.clone());
            self.bodies.push(BodyModes::None(match rule {
                ModalRule::Never => NoModes::Unwanted,
                _ => NoModes::Unstruck,
            }));
            match rule {
                ModalRule::Never => {}
                ModalRule::Own => {
                    let part = ModalBake::of_body(body, self.settings.options);
                    let Ok(request) = SoundModelRequest::of_body(body, part) else { continue };
                    self.requests.push(SharedModes { request, bodies: vec![id] });
                }
                ModalRule::Auto | ModalRule::Proxy => {
                    let always = rule == ModalRule::Proxy;
                    self.candidates.push(Candidate { id, body: body.clone(), always });
                }
            }
        }
    }

    /// Bodies that may have modes.
    pub(super) fn may_vibrate(&self) -> BTreeSet<BodyId> {
        let own = self.requests.iter().flat_map(|shared| shared.bodies.iter().copied());
        own.chain(self.candidates.iter().chain(&self.crowd).map(|candidate| candidate.id)).collect()
    }

    /// Decides who of those that are `struck` has modes of its own, and who those of an ellipsoid.
    ///
    /// # Errors
    /// [`SoundModelError::Interrupted`], when `progress` breaks.
    pub(super) fn prepare(
        mut self,
        struck: &BTreeSet<BodyId>,
        cache: Option<&ModelCache>,
        progress: &mut dyn FnMut(&SoundModelProgress<'_>) -> ControlFlow<()>,
    ) -> Result<PreparedModes, SoundModelError> {
        let mut found = ModalParts { bodies: std::mem::take(&mut self.bodies), ..ModalParts::default() };
        let mut crowd = std::mem::take(&mut self.crowd);
        crowd.retain(|candidate| struck.contains(&candidate.id));
        let silent = self.divide_crowd(crowd, cache);
        for id in silent {
            found.bodies[id.index()] = BodyModes::None(NoModes::TooManyForms { most: MOST_FORMS });
        }
        self.candidates.retain(|candidate| struck.contains(&candidate.id));
        self.choose_proxies(cache, &mut found, progress)?;
        self.requests.iter_mut().for_each(|shared| shared.bodies.retain(|id| struck.contains(id)));
        self.requests.retain(|shared| !shared.bodies.is_empty());
        Ok(PreparedModes { found, requests: self.requests, names: self.names })
    }

    /// Requests modes for the loudest of a crowd, and puts the others among the candidates for ellipsoids, if
    /// there is a bank of their material; returns those that are left.
    fn divide_crowd(&mut self, crowd: Vec<Candidate>, cache: Option<&ModelCache>) -> Vec<BodyId> {
        let options = self.settings.options;
        let Divided { loudest, others, silent } = divide(crowd, &self.energies, (&options, cache));
        for form in loudest {
            let body = &form[0].body;
            let Ok(request) = SoundModelRequest::of_body(body, ModalBake::of_body(body, options)) else {
                continue;
            };
            let own = form.iter().map(|candidate| candidate.id);
            match self.requests.iter_mut().find(|other| other.request.key() == request.key()) {
                Some(shared) => shared.bodies.extend(own),
                None => self.requests.push(SharedModes { request, bodies: own.collect() }),
            }
        }
        self.candidates.extend(others);
        silent
    }

    /// Decides which candidates have the modes of an ellipsoid, and requests modes of their own for the
    /// others.
    fn choose_proxies(
        &mut self,
        cache: Option<&ModelCache>,
        found: &mut ModalParts,
        progress: &mut dyn FnMut(&SoundModelProgress<'_>) -> ControlFlow<()>,
    ) -> Result<(), SoundModelError> {
        let ModalPlan { candidates, requests, settings, .. } = self;
        let ModalPlanSettings { options, proxy_frequency } = *settings;
        let mut on_progress = |done: f64| {
            let step = "baking the modal bank";
            progress(&SoundModelProgress { part: SoundPart::Modal, body: "", done, step })
        };
        let chosen = choose(candidates, &options, proxy_frequency, cache, &mut on_progress);
        let (choices, remarks) = match chosen {
            Ok(chosen) => chosen,
            Err(ModalSoundbankBakeError::Interrupted) => return Err(SoundModelError::Interrupted),
            Err(error) => (vec![Choice::Own; candidates.len()], vec![error.to_string()]),
        };
        found.remarks.extend(remarks);
        for (Candidate { id, body, .. }, choice) in candidates.iter().zip(choices) {
            found.bodies[id.index()] = match choice {
                Choice::Proxy(proxy) => BodyModes::Proxy(proxy),
                Choice::Above(first) => {
                    BodyModes::None(NoModes::AboveBand { first, limit: options.max_frequency })
                }
                Choice::Failed(why) => {
                    found.remarks.push(format!("\"{}\" does not ring: {why}", body.name));
                    BodyModes::None(NoModes::Failed(why))
                }
                Choice::Own => {
                    let part = ModalBake::of_body(body, options);
                    let Ok(request) = SoundModelRequest::of_body(body, part) else { continue };
                    match requests.iter_mut().find(|other| other.request.key() == request.key()) {
                        Some(shared) => shared.bodies.push(*id),
                        None => requests.push(SharedModes { request, bodies: vec![*id] }),
                    }
                    continue;
                }
            };
        }
        Ok(())
    }
}

/// Who has modes of its own, and all that is known of the others.
pub(super) struct PreparedModes {
    found: ModalParts,
    requests: Vec<SharedModes>,
    names: Vec<String>,
}

impl PreparedModes {
    /// Estimated CPU time \[s\] of each request, 0 for those in the cache.
    pub(super) fn costs(&self, cache: Option<&ModelCache>) -> Vec<f64> {
        self.requests.iter().map(|shared| shared.request.cost(cache)).collect()
    }

    /// Finds or bakes the modes within the CPU time \[s\] that each is allowed, and drafts of those that are
    /// allowed none or need more. Modes that cannot be computed make a remark, and the body has a draft of
    /// them, or else none.
    ///
    /// # Errors
    /// [`SoundModelError::Interrupted`], when `progress` breaks.
    pub(super) fn find(
        self,
        allowed: &[Option<f64>],
        cache: Option<&ModelCache>,
        progress: &mut dyn FnMut(&SoundModelProgress<'_>) -> ControlFlow<()>,
    ) -> Result<ModalParts, SoundModelError> {
        let PreparedModes { mut found, requests, names } = self;
        let count = requests.len();
        for (at, (shared, allowed)) in requests.iter().zip(allowed).enumerate() {
            let body = names[shared.bodies[0].index()].as_str();
            let mut on_progress = |p: &BakeProgress| {
                let done = (at as f64 + p.done) / count as f64;
                progress(&SoundModelProgress { part: SoundPart::Modal, body, done, step: p.stage })
            };
            let modes = obtain_shared((shared, body), *allowed, cache, &mut found, &mut on_progress)?;
            shared.bodies.iter().for_each(|id| found.bodies[id.index()] = modes.clone());
        }
        Ok(found)
    }
}

/// The modes of a request within the CPU time \[s\] that it is allowed, the first of whose bodies is called
/// `name`, or their draft.
fn obtain_shared(
    (shared, name): (&SharedModes, &str),
    allowed: Option<f64>,
    cache: Option<&ModelCache>,
    found: &mut ModalParts,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<BodyModes, SoundModelError> {
    let started = Instant::now();
    let request = &shared.request;
    let mut cost = request.cost(cache);
    let within = |seconds: f64| request.with_part(request.part().within(seconds));
    let mut obtained = allowed.map(|seconds| obtain(&within(seconds), cache, progress));
    if let Some(Err(error)) = &obtained
        && !matches!(error, SoundModelError::Interrupted)
    {
        match error.too_long() {
            Some(seconds) => cost = seconds,
            None => {
                cost = f64::INFINITY;
                found.remarks.push(format!(
                    "the modes of \"{name}\" cannot be baked: {error}; it rings with a draft of them"
                ));
            }
        }
        obtained = None;
    }
    let draft_of = obtained.is_none().then_some(cost);
    let obtained = match obtained {
        Some(obtained) => obtained,
        None => obtain(&request.with_part(request.part().draft()), cache, progress),
    };
    match obtained {
        Ok(Obtained { file, cached, remarks }) => {
            let origin = &file.modal.origin;
            found.remarks.extend(remarks);
            found.remarks.extend(origin.warnings.iter().map(|w| format!("\"{name}\": {w}")));
            found.obtained.push(ObtainedModel {
                part: SoundPart::Modal,
                body: shared.bodies[0],
                bodies: shared.bodies.len(),
                cached,
                time: started.elapsed(),
                draft_of,
            });
            Ok(match origin.first_frequency {
                Some(first) => {
                    BodyModes::None(NoModes::AboveBand { first, limit: file.modal.model.max_frequency })
                }
                None => BodyModes::Own(Arc::new(file.modal.model)),
            })
        }
        Err(SoundModelError::Interrupted) => Err(SoundModelError::Interrupted),
        Err(error) => {
            let why = format!("the modes of \"{name}\" cannot be baked: {error}; it does not ring");
            found.remarks.push(why);
            Ok(BodyModes::None(NoModes::Failed(error.to_string())))
        }
    }
}
