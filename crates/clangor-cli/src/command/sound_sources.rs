//! What bodies sound as, found or baked under a progress bar.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use clangor_bake::modal::ModalBakeOptions;
use clangor_core::body::{Body, BodyId};
use clangor_core::material::Material;
use clangor_core::reference::PanSource;
use clangor_core::reference::pan_file::PanFile;
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::acceleration::model_evaluator::{BankEvaluator, ModelEvaluator};
use clangor_core::sound_model::files::modal_file::{ModalOrigin, ModalPart};
use clangor_core::sound_model::files::model_file::Solid;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::synthesis::source_rule::{Decision, Reason, SourceKind, source_of};
use clangor_core::synthesis::{RenderSettings, SoundRule, SoundSource};
use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::stages::sound_models::ringers::{Ringers, Ringing, RingingPlan};
use clangor_pipeline::stages::sound_models::sources::{SourceProgress, SourceSettings, Sources, sources};
use clangor_pipeline::stages::sound_models::{ModelRequest, SoundFile, obtain, read_sound_file};

use crate::arguments::{Global, Quality, Sound};
use crate::console::{Console, Progress};
use crate::failure::Failure;

/// What is wanted of the bodies' sound.
pub(super) struct Wanted<'a> {
    /// What each body is to sound as.
    pub(super) rules: &'a [SoundRule],
    /// How good fields must be.
    pub(super) quality: Quality,
    /// How they are rendered.
    pub(super) settings: &'a RenderSettings,
}

impl From<Sound> for SoundRule {
    fn from(sound: Sound) -> Self {
        match sound {
            Sound::Auto => SoundRule::Auto,
            Sound::Own => SoundRule::Own,
            Sound::Proxy => SoundRule::Proxy,
            Sound::NearestProxy => SoundRule::NearestProxy,
            Sound::Sphere => SoundRule::Sphere,
        }
    }
}

/// What bodies sound as; those that are `struck` have fields of their own where the rules want them.
pub(super) fn find_sources(
    bodies: &[Body],
    struck: &BTreeSet<BodyId>,
    wanted: &Wanted<'_>,
    global: &Global,
    console: &Console,
) -> Result<Sources, Failure> {
    let cache = ModelCache::find(global.cache.as_deref());
    let bank = default_bank();
    let settings = source_settings(wanted, cache.as_ref(), bank.as_ref());
    // A bar appears with the first field that has to be baked.
    let mut bar: Option<Progress<'_>> = None;
    let mut on_progress = |p: &SourceProgress<'_>| {
        let bar = bar.get_or_insert_with(|| console.progress("bake", 1.0));
        bar.stage(p.stage);
        match bar.reached(p.done) {
            ControlFlow::Continue(()) => console.flow(),
            stop => stop,
        }
    };
    let found = sources(bodies, struck, &settings, &mut on_progress)?;
    drop(bar);
    for remark in &found.remarks {
        console.warn(remark);
    }
    Ok(found)
}

/// The model of a body that clicks by a field of its own: what [`find_sources`] has put into the cache.
pub(super) fn own_model(body: &Body, wanted: &Wanted<'_>, global: &Global) -> Option<AccelerationModel> {
    let cache = ModelCache::find(global.cache.as_deref());
    let settings = source_settings(wanted, cache.as_ref(), None);
    let request = ModelRequest::of_body(body, settings.bake_options()).ok()?;
    obtain(&request, cache.as_ref(), &mut |_| ControlFlow::Continue(()))
        .ok()
        .map(|found| found.model.acceleration)
}

fn source_settings<'a>(
    wanted: &Wanted<'a>,
    cache: Option<&'a ModelCache>,
    bank: Option<&'a BankEvaluator>,
) -> SourceSettings<'a> {
    SourceSettings {
        rules: wanted.rules,
        max_wavenumber: wanted.settings.max_wavenumber(),
        accuracy: if wanted.quality == Quality::High { 0.002 } else { 0.01 },
        cache,
        bank,
        bake: wanted.quality != Quality::Draft,
    }
}

/// How modes are baked for what is rendered so.
pub(super) fn modal_options(quality: Quality, settings: &RenderSettings) -> ModalBakeOptions {
    let normal = ModalBakeOptions::new(settings.medium);
    let max_frequency = normal.max_frequency.min(settings.band().0);
    let (mesh_error, accuracy) = match quality {
        Quality::Draft => (0.03, 0.05),
        Quality::Normal => (normal.mesh_error, normal.accuracy),
        Quality::High => (0.005, 0.002),
    };
    ModalBakeOptions { max_frequency, mesh_error, accuracy, ..normal }
}

/// The modes of those among the bodies of a plan that are `struck`, and those that the command line gives.
pub(super) fn find_ringers(
    plan: RingingPlan,
    struck: &BTreeSet<BodyId>,
    given: &BTreeMap<BodyId, Arc<ModalModel>>,
    global: &Global,
    console: &Console,
) -> Result<Ringers, Failure> {
    let cache = ModelCache::find(global.cache.as_deref());
    let wanting: BTreeSet<BodyId> = struck.iter().filter(|id| !given.contains_key(id)).copied().collect();
    let mut bar: Option<Progress<'_>> = None;
    let mut on_progress = |p: &SourceProgress<'_>| {
        let bar = bar.get_or_insert_with(|| console.progress("modes", 1.0));
        bar.stage(p.stage);
        match bar.reached(p.done) {
            ControlFlow::Continue(()) => console.flow(),
            stop => stop,
        }
    };
    let mut found = plan.find(&wanting, cache.as_ref(), &mut on_progress)?;
    drop(bar);
    found.remarks.iter().for_each(|remark| console.warn(remark));
    for (id, model) in given.iter().filter(|(id, _)| struck.contains(id)) {
        found.bodies[id.index()] = Ringing::Modes(Arc::clone(model));
    }
    Ok(found)
}

/// Part of a body's volume by which that of the solid that a given model was baked from may differ.
pub(super) const SAME_VOLUME: f64 = 0.02;

/// From a body to its sound by a model.
type Play = Box<dyn Fn(&Body) -> SoundSource>;

/// What the command line gives to bodies.
#[derive(Default)]
pub(super) struct GivenModels {
    /// How they sound when they are accelerated.
    pub(super) sources: BTreeMap<BodyId, SoundSource>,
    /// How they ring.
    pub(super) modes: BTreeMap<BodyId, Arc<ModalModel>>,
}

/// The models that the command line gives to bodies, and to copies of bodies, by name.
pub(super) fn given_models(
    bodies: &[Body],
    given: &[(String, PathBuf)],
    console: &Console,
) -> Result<GivenModels, Failure> {
    let mut models = GivenModels::default();
    for (name, path) in given {
        let file = read_sound_file(path).map_err(Failure::new)?;
        let unplayable =
            |why: &dyn std::fmt::Display| Failure::new(format_args!("{}: {why}", path.display()));
        let (play, modal, solid): (Option<Play>, _, Solid) = match file {
            SoundFile::Model(file) => {
                let own = ModelEvaluator::try_new(&file.acceleration).map_err(|e| unplayable(&e))?;
                let decision = Decision { kind: SourceKind::Own, reason: Reason::Asked };
                let play = move |body: &Body| source_of(body, &decision, None, Some(&own)).0;
                (Some(Box::new(play)), file.modal, file.solid)
            }
            SoundFile::Modal(file) => (None, Some(file.modal), file.solid),
            SoundFile::Pan(file) => {
                let PanFile { model, solid, .. } = *file;
                let model = Arc::new(model);
                let play = move |body: &Body| {
                    let source = PanSource::new(Arc::clone(&model), Arc::clone(&body.surface));
                    SoundSource::Reference(Arc::new(source))
                };
                (Some(Box::new(play)), None, solid)
            }
            SoundFile::Bank(_) | SoundFile::ModalSoundbank(_) => {
                return Err(unplayable(&"is a soundbank, not the model of one body"));
            }
        };
        let volume_of_solid = solid.mass.volume;
        let modes = modal.map(|modal| (Arc::new(modal.model.clone()), modal));
        let mut found = false;
        for (index, body) in bodies.iter().enumerate().filter(|(_, body)| is_copy(body, name)) {
            found = true;
            let id = BodyId(index as u32);
            let volume = body.mass / body.material.density;
            if (volume / volume_of_solid - 1.0).abs() > SAME_VOLUME {
                console.warn(format_args!(
                    "\"{}\" has {volume:.3e} m³, and {} is the model of {volume_of_solid:.3e} m³",
                    body.name,
                    path.display(),
                ));
            }
            if let Some(play) = &play {
                models.sources.insert(id, play(body));
            }
            if let Some((model, modal)) = &modes {
                warn_of_other_material(&body.material, modal, console);
                models.modes.insert(id, Arc::clone(model));
            }
        }
        if !found {
            return Err(Failure::new(format_args!("--model {name}: there is no body of this name")));
        }
    }
    Ok(models)
}

/// Whether a body has this name, or is one of the copies of the body that has it.
pub(super) fn is_copy(body: &Body, name: &str) -> bool {
    let number = body.name.strip_prefix(name).and_then(|rest| rest.strip_prefix('-'));
    body.name == *name || number.is_some_and(|n| !n.is_empty() && n.bytes().all(|c| c.is_ascii_digit()))
}

/// Part by which elastic constants that were written and read may differ.
const SAME_CONSTANT: f64 = 1e-6;

/// Warns of modes that were baked of something else.
pub(super) fn warn_of_other_material(material: &Material, modes: &ModalPart, console: &Console) {
    let ModalOrigin { youngs_modulus, poisson_ratio, .. } = modes.origin;
    let pairs = [
        (material.youngs_modulus, youngs_modulus),
        (material.poisson_ratio, poisson_ratio),
        (material.density, modes.model.density),
    ];
    if pairs.iter().any(|(a, b)| (a - b).abs() > SAME_CONSTANT * b.abs()) {
        console.warn(format_args!(
            "the modes are those of {}, and ring so, whatever the stiffness of {}; its damping is used",
            modes.origin.material, material.name
        ));
    }
}
