//! What bodies sound as, found or baked under a progress bar.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use clangor::body::{Body, BodyId};
use clangor::synthesis::{RenderSettings, SoundRule};
use clangor_pipeline::model_cache::ModelCache;
use clangor_pipeline::sound_models::sources::{SourceProgress, SourceSettings, Sources, sources};
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
