//! The sound models of all bodies of a scene, and what it took to obtain them.

use std::time::Duration;

use clangor_core::body::BodyId;
use clangor_core::synthesis::SoundSource;
use clangor_core::synthesis::{SoundModel, SoundPart};

/// One part of a sound model that was in the cache or has been baked.
#[derive(Clone, Debug, PartialEq)]
pub struct ObtainedModel {
    /// The part.
    pub part: SoundPart,
    /// The first body that has it.
    pub body: BodyId,
    /// Number of bodies that share it.
    pub bodies: usize,
    /// Whether it was in the cache.
    pub cached: bool,
    /// Wall-clock time that it took.
    pub time: Duration,
    /// Estimated CPU time \[s\] of the exact model, if this is a draft; infinite if it cannot be computed.
    pub draft_of: Option<f64>,
}

/// How the bodies of a scene sound.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoundModels {
    /// One model for each body, in their order.
    pub bodies: Vec<SoundModel>,
    /// What was found or baked, by part and body.
    pub obtained: Vec<ObtainedModel>,
    /// Models that could not be had, entries of the cache that were replaced, warnings of solvers.
    pub remarks: Vec<String>,
}

impl SoundModels {
    /// What radiates when each body is accelerated.
    pub fn sources(&self) -> Vec<SoundSource> {
        self.bodies.iter().map(|model| model.acceleration.source.clone()).collect()
    }

    /// The models that are drafts.
    pub fn drafts(&self) -> impl Iterator<Item = &ObtainedModel> {
        self.obtained.iter().filter(|model| model.draft_of.is_some())
    }

    /// The model of a body.
    pub fn get(&self, body: BodyId) -> Option<&SoundModel> {
        self.bodies.get(body.index())
    }

    /// Number of modes of a body.
    pub fn mode_count(&self, body: BodyId) -> usize {
        self.get(body).map_or(0, |model| model.modal.mode_count())
    }
}
