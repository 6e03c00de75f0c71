//! What bodies sound as, found or baked under a progress bar.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use clangor::body::{Body, BodyId};
use clangor::model::model_file::Solid;
use clangor::model::playable_model::PlayableModel;
use clangor::model::published_file::PublishedFile;
use clangor::synthesis::source_rule::{Decision, Reason, SourceKind, source_of};
use clangor::synthesis::{PublishedSource, RenderSettings, SoundRule, SoundSource};
use clangor_pipeline::model_cache::ModelCache;
use clangor_pipeline::sound_models::sources::{SourceProgress, SourceSettings, Sources, sources};
use clangor_pipeline::sound_models::{SoundFile, read_sound_file};
use clangor_pipeline::soundbank::default_bank;

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
    let settings = SourceSettings {
        rules: wanted.rules,
        max_wavenumber: wanted.settings.max_wavenumber(),
        accuracy: if wanted.quality == Quality::High { 0.002 } else { 0.01 },
        cache: cache.as_ref(),
        bank: bank.as_ref(),
        bake: wanted.quality != Quality::Draft,
    };
    // A bar appears with the first field that has to be baked.
    let mut bar: Option<Progress<'_>> = None;
    let mut told = |p: &SourceProgress<'_>| {
        let bar = bar.get_or_insert_with(|| console.progress("bake", 1.0));
        bar.stage(p.stage);
        match bar.reached(p.done) {
            ControlFlow::Continue(()) => console.flow(),
            stop => stop,
        }
    };
    let found = sources(bodies, struck, &settings, &mut told)?;
    drop(bar);
    for remark in &found.remarks {
        console.warn(remark);
    }
    Ok(found)
}

/// Part of a body's volume by which that of the solid that a given model was baked from may differ.
const SAME_VOLUME: f64 = 0.02;

/// From a body to its sound by a model.
type Play = Box<dyn Fn(&Body) -> SoundSource>;

/// The models that the command line gives to bodies, and to copies of bodies, by name.
pub(super) fn given_models(
    bodies: &[Body],
    given: &[(String, PathBuf)],
    console: &Console,
) -> Result<BTreeMap<BodyId, SoundSource>, Failure> {
    let mut sources = BTreeMap::new();
    for (name, path) in given {
        let file = read_sound_file(path).map_err(Failure::new)?;
        let unplayable =
            |why: &dyn std::fmt::Display| Failure::new(format_args!("{}: {why}", path.display()));
        let (play, solid): (Play, Solid) = match file {
            SoundFile::Model(file) => {
                let own = PlayableModel::try_new(&file.acceleration).map_err(|e| unplayable(&e))?;
                let decision = Decision { kind: SourceKind::Own, reason: Reason::Asked };
                let play = move |body: &Body| source_of(body, &decision, None, Some(&own)).0;
                (Box::new(play), file.solid)
            }
            SoundFile::Published(file) => {
                let PublishedFile { model, solid, .. } = *file;
                let model = Arc::new(model);
                let play = move |body: &Body| {
                    let source = PublishedSource::new(Arc::clone(&model), Arc::clone(&body.surface));
                    SoundSource::Published(Arc::new(source))
                };
                (Box::new(play), solid)
            }
            SoundFile::Bank(_) => return Err(unplayable(&"is a soundbank, not the model of one body")),
        };
        let copy_of = |body: &Body| {
            let number = body.name.strip_prefix(name.as_str()).and_then(|rest| rest.strip_prefix('-'));
            body.name == *name
                || number.is_some_and(|n| !n.is_empty() && n.bytes().all(|c| c.is_ascii_digit()))
        };
        let mut found = false;
        for (index, body) in bodies.iter().enumerate().filter(|(_, body)| copy_of(body)) {
            found = true;
            let volume = body.mass / body.material.density;
            if (volume / solid.mass.volume - 1.0).abs() > SAME_VOLUME {
                console.warn(format_args!(
                    "\"{}\" has {volume:.3e} m³, and {} is the model of {:.3e} m³",
                    body.name,
                    path.display(),
                    solid.mass.volume
                ));
            }
            sources.insert(BodyId(index as u32), play(body));
        }
        if !found {
            return Err(Failure::new(format_args!("--model {name}: there is no body of this name")));
        }
    }
    Ok(sources)
}
