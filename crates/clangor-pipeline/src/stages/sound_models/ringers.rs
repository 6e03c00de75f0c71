//! Which bodies of a scene ring, and their modes.
//!
//! Every body that moves freely and is struck rings, unless the scene says otherwise. Modes are found once
//! for all bodies of the same form and material. Where these are many, as in a heap of stones, finding modes
//! would take longer than all the rest: then only those ring that the scene asks for. A body whose modes all
//! lie above the band does not ring, and is told apart from one whose modes cannot be found.
//!
//! Pieces of a broken body are as it was, if the scene says how it rings; else those with a lowest frequency
//! above a threshold ring as ellipsoids (`piece_proxies`), and the rest with modes of their own.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clangor_bake::acceleration::BakeProgress;
use clangor_bake::modal::{ModalBakeError, ModalBakeOptions};
use clangor_bake::soundbank::modal::ModalSoundbankBakeError;
use clangor_core::body::{Body, BodyId, Motion};
use clangor_core::medium::Medium;
use clangor_core::scene::render_description::PROXY_FREQUENCY;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::sound_model::soundbank::modal_soundbank::ModalProxy;
use clangor_core::synthesis::modal::RingingRule;

use super::piece_proxies::{Candidate, Choice, choose};
use super::ringing::{ModalRequest, ObtainedModes, obtain_modes};
use super::sources::SourceProgress;
use crate::formats::model_cache::ModelCache;

/// Most different forms and materials whose modes are found without being asked for.
pub const MOST_FORMS: usize = 16;

/// Whether a body rings, and why.
#[derive(Clone, Debug, PartialEq)]
pub enum Ringing {
    /// With these modes; bodies of the same form and material share them.
    Modes(Arc<ModalModel>),
    /// With those of an ellipsoid.
    Proxy(Arc<ModalProxy>),
    /// All modes lie above the band.
    Above {
        /// The lowest \[Hz\].
        first: f64,
        /// The band \[Hz\].
        limit: f64,
    },
    /// The scene says no.
    Unwanted,
    /// It is fixed, moved by keyframes, or not struck.
    Unstruck,
    /// It is one of too many different bodies.
    OneOfMany,
    /// Its modes or their sound cannot be computed.
    Failed(String),
}

impl std::fmt::Display for Ringing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Ringing::Modes(model) => match model.modes.len() {
                1 => write!(f, "one mode"),
                count => write!(f, "{count} modes"),
            },
            Ringing::Proxy(proxy) => match proxy.mode_count() {
                1 => write!(f, "one mode of ellipsoid {}", proxy.entry()),
                count => write!(f, "{count} modes of ellipsoid {}", proxy.entry()),
            },
            Ringing::Above { first, limit } => {
                let (first, limit) = (1e-3 * first, 1e-3 * limit);
                write!(f, "no audible modes: first at {first:.2} kHz, above the limit of {limit:.2} kHz")
            }
            Ringing::Unwanted => f.write_str("it is not to ring"),
            Ringing::Unstruck => f.write_str("nothing strikes it, or it cannot move"),
            Ringing::OneOfMany => {
                write!(f, "one of more than {MOST_FORMS} forms: ask for its modes with modal = true")
            }
            Ringing::Failed(why) => write!(f, "its modes cannot be baked: {why}"),
        }
    }
}

/// Modes of one form, and what they took.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundModes {
    /// The first body that has them.
    pub body: BodyId,
    /// How many bodies share them.
    pub bodies: usize,
    /// Whether they were in the cache.
    pub cached: bool,
    /// Time that it took.
    pub time: Duration,
}

/// How the bodies ring.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ringers {
    /// In the order of the bodies.
    pub bodies: Vec<Ringing>,
    /// What was found or baked.
    pub found: Vec<FoundModes>,
    /// What the person should know.
    pub remarks: Vec<String>,
}

impl Ringers {
    /// Bodies that do not ring.
    pub fn none(bodies: usize) -> Self {
        Ringers { bodies: vec![Ringing::Unwanted; bodies], ..Ringers::default() }
    }

    /// The modes of a body, if it rings.
    pub fn modes(&self, body: BodyId) -> Option<&Arc<ModalModel>> {
        match self.bodies.get(body.index()) {
            Some(Ringing::Modes(model)) => Some(model),
            _ => None,
        }
    }

    /// The ellipsoid as which a body rings.
    pub fn proxy(&self, body: BodyId) -> Option<&Arc<ModalProxy>> {
        match self.bodies.get(body.index()) {
            Some(Ringing::Proxy(proxy)) => Some(proxy),
            _ => None,
        }
    }

    /// How many modes a body rings with.
    pub fn mode_count(&self, body: BodyId) -> usize {
        let own = self.modes(body).map(|model| model.modes.len());
        own.or(self.proxy(body).map(|proxy| proxy.mode_count())).unwrap_or(0)
    }
}

/// Who may ring, before anything moves.
#[derive(Clone, Debug)]
pub struct RingingPlan {
    /// Of each body: why it does not ring, as far as is known.
    bodies: Vec<Ringing>,
    /// What is wanted, and who shares it.
    requests: Vec<(ModalRequest, Vec<BodyId>)>,
    /// Who may ring as an ellipsoid.
    candidates: Vec<Candidate>,
    names: Vec<String>,
    rules: Vec<RingingRule>,
    options: ModalBakeOptions,
    proxy_frequency: f64,
}

impl RingingPlan {
    /// Plans for bodies, of which `rules` say what the scene says of those that are there from the beginning.
    pub fn new(bodies: &[Body], rules: &[RingingRule], options: ModalBakeOptions) -> Self {
        let mut plan = RingingPlan {
            bodies: vec![Ringing::Unstruck; bodies.len()],
            requests: Vec::new(),
            candidates: Vec::new(),
            names: bodies.iter().map(|body| body.name.clone()).collect(),
            rules: inherited(bodies, rules),
            options,
            proxy_frequency: PROXY_FREQUENCY,
        };
        let rules = plan.rules.clone();
        // Copies share their surface, and to recognise its form takes time.
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        let mut copies: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut unasked = BTreeSet::new();
        for (index, body) in bodies.iter().enumerate() {
            let rule = rules[index];
            if body.motion != Motion::Free {
                continue;
            }
            if rule == RingingRule::Never {
                plan.bodies[index] = Ringing::Unwanted;
                continue;
            }
            let always = rule == RingingRule::Proxy;
            let piece = rule == RingingRule::Auto && body.life.parent.is_some();
            if always || piece {
                plan.candidates.push(Candidate { id: BodyId(index as u32), body: body.clone(), always });
                continue;
            }
            if rule == RingingRule::Auto && unasked.len() > MOST_FORMS {
                plan.bodies[index] = Ringing::OneOfMany;
                continue;
            }
            let id = BodyId(index as u32);
            let same = copies.entry(Arc::as_ptr(&body.surface).addr()).or_default();
            let equal = |at: &&usize| bodies[plan.requests[**at].1[0].index()].material == body.material;
            let at = match same.iter().find(equal) {
                Some(at) => *at,
                None => {
                    let Ok(request) = ModalRequest::of_body(body, options) else { continue };
                    let at = *known.entry(request.key().to_owned()).or_insert(plan.requests.len());
                    if at == plan.requests.len() {
                        plan.requests.push((request, Vec::new()));
                    }
                    same.push(at);
                    at
                }
            };
            if rule == RingingRule::Auto {
                unasked.insert(at);
            }
            plan.requests[at].1.push(id);
        }
        if unasked.len() > MOST_FORMS {
            let asked = |id: &BodyId| rules[id.index()] != RingingRule::Auto;
            for (_, own) in &mut plan.requests {
                for id in own.iter().filter(|id| !asked(id)) {
                    plan.bodies[id.index()] = Ringing::OneOfMany;
                }
                own.retain(asked);
            }
            plan.requests.retain(|(_, own)| !own.is_empty());
        }
        plan
    }

    /// With another threshold \[Hz\] above which pieces ring as ellipsoids.
    #[must_use]
    pub fn with_proxy_frequency(mut self, frequency: f64) -> Self {
        self.proxy_frequency = frequency;
        self
    }

    /// Lets copies of one body ring with modes that are known; only their sound is to be found.
    pub fn give(&mut self, copies: &[BodyId], body: &Body, modes: &ModalModel, options: ModalBakeOptions) {
        self.requests.iter_mut().for_each(|(_, own)| own.retain(|id| !copies.contains(id)));
        self.requests.retain(|(_, own)| !own.is_empty());
        self.candidates.retain(|candidate| !copies.contains(&candidate.id));
        let (mass, modes) = (super::unit_mass(body), modes.clone());
        let request = ModalRequest::of_modes(&body.name, &body.surface, mass, &body.material, modes, options);
        if let (Ok(request), Motion::Free) = (request, &body.motion) {
            self.requests.push((request, copies.to_vec()));
        }
    }

    /// Takes note of the bodies that have been born since; `bodies` are all that ever were.
    pub fn add_pieces(&mut self, bodies: &[Body]) {
        for body in bodies.iter().skip(self.bodies.len()) {
            let id = BodyId(self.bodies.len() as u32);
            let parent = body.life.parent.and_then(|parent| self.rules.get(parent.index()));
            let rule = parent.copied().unwrap_or_default();
            self.rules.push(rule);
            self.names.push(body.name.clone());
            self.bodies.push(match rule {
                RingingRule::Never => Ringing::Unwanted,
                _ => Ringing::Unstruck,
            });
            match rule {
                RingingRule::Never => {}
                RingingRule::Own => {
                    let Ok(request) = ModalRequest::of_body(body, self.options) else { continue };
                    self.requests.push((request, vec![id]));
                }
                RingingRule::Auto | RingingRule::Proxy => {
                    let always = rule == RingingRule::Proxy;
                    self.candidates.push(Candidate { id, body: body.clone(), always });
                }
            }
        }
    }

    /// A plan in which nothing rings.
    pub fn none(bodies: &[Body]) -> Self {
        RingingPlan::new(bodies, &vec![RingingRule::Never; bodies.len()], ModalBakeOptions::new(Medium::AIR))
    }

    /// Bodies whose motion matters because they may ring.
    pub fn may_ring(&self) -> BTreeSet<BodyId> {
        let own = self.requests.iter().flat_map(|(_, own)| own.iter().copied());
        own.chain(self.candidates.iter().map(|candidate| candidate.id)).collect()
    }

    /// Finds or bakes the modes of those that are `struck`.
    ///
    /// Modes that cannot be computed are told among the remarks, and the body does not ring.
    ///
    /// # Errors
    /// [`ModalBakeError::Interrupted`], when `progress` says so.
    pub fn find(
        self,
        struck: &BTreeSet<BodyId>,
        cache: Option<&ModelCache>,
        progress: &mut dyn FnMut(&SourceProgress<'_>) -> ControlFlow<()>,
    ) -> Result<Ringers, ModalBakeError> {
        let RingingPlan { bodies, mut requests, mut candidates, names, options, proxy_frequency, .. } = self;
        let mut result = Ringers { bodies, ..Ringers::default() };
        candidates.retain(|candidate| struck.contains(&candidate.id));
        let mut on_progress =
            |done: f64| progress(&SourceProgress { body: "", done, stage: "baking the modal bank" });
        let (choices, remarks) = match choose(&candidates, &options, proxy_frequency, cache, &mut on_progress)
        {
            Ok(chosen) => chosen,
            Err(ModalSoundbankBakeError::Interrupted) => return Err(ModalBakeError::Interrupted),
            Err(error) => (vec![Choice::Own; candidates.len()], vec![error.to_string()]),
        };
        result.remarks.extend(remarks);
        for (Candidate { id, body, .. }, choice) in candidates.iter().zip(choices) {
            result.bodies[id.index()] = match choice {
                Choice::Proxy(proxy) => Ringing::Proxy(proxy),
                Choice::Above(first) => Ringing::Above { first, limit: options.max_frequency },
                Choice::Failed(why) => {
                    result.remarks.push(format!("\"{}\" does not ring: {why}", body.name));
                    Ringing::Failed(why)
                }
                Choice::Own => {
                    let Ok(request) = ModalRequest::of_body(body, options) else { continue };
                    match requests.iter_mut().find(|(other, _)| other.key() == request.key()) {
                        Some((_, own)) => own.push(*id),
                        None => requests.push((request, vec![*id])),
                    }
                    continue;
                }
            };
        }
        requests.iter_mut().for_each(|(_, own)| own.retain(|id| struck.contains(id)));
        requests.retain(|(_, own)| !own.is_empty());
        let count = requests.len();
        for (at, (request, own)) in requests.iter().enumerate() {
            let name = names[own[0].index()].as_str();
            let mut on_progress = |p: &BakeProgress| {
                let done = (at as f64 + p.done) / count as f64;
                progress(&SourceProgress { body: name, done, stage: p.stage })
            };
            let started = Instant::now();
            let ringing = match obtain_modes(request, cache, &mut on_progress) {
                Ok(ObtainedModes { file, cached, remarks }) => {
                    let origin = &file.modal.origin;
                    result.remarks.extend(remarks);
                    result.remarks.extend(origin.warnings.iter().map(|w| format!("\"{name}\": {w}")));
                    let (bodies, time) = (own.len(), started.elapsed());
                    result.found.push(FoundModes { body: own[0], bodies, cached, time });
                    match origin.first_frequency {
                        Some(first) => Ringing::Above { first, limit: file.modal.model.max_frequency },
                        None => Ringing::Modes(Arc::new(file.modal.model)),
                    }
                }
                Err(ModalBakeError::Interrupted) => return Err(ModalBakeError::Interrupted),
                Err(error) => {
                    let why = format!("the modes of \"{name}\" cannot be baked: {error}; it does not ring");
                    result.remarks.push(why);
                    Ringing::Failed(error.to_string())
                }
            };
            own.iter().for_each(|id| result.bodies[id.index()] = ringing.clone());
        }
        Ok(result)
    }
}

/// The rule of each body: a piece has that of the body that it was part of.
fn inherited(bodies: &[Body], rules: &[RingingRule]) -> Vec<RingingRule> {
    let mut all: Vec<RingingRule> = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let of_parent = body.life.parent.and_then(|parent| all.get(parent.index()).copied());
        all.push(of_parent.unwrap_or(rules.get(index).copied().unwrap_or_default()));
    }
    all
}
