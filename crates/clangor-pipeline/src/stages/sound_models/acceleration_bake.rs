//! The field of an accelerated body, baked.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use clangor_bake::acceleration::{
    BakeError, BakeOptions, BakeProgress, Resumption, SolvedFrequency, resume_bake,
};
use clangor_bake::cost;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_core::sound_model::files::model_file::{ModelFile, Origin};

use super::error::SoundModelError;
use super::obtain::BakedPart;
use super::request::{RequestedPart, SoundModelRequest};
use crate::formats::model_cache::{CacheError, ModelCache, model_key};

/// How the field of an acceleration is baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationBake(pub BakeOptions);

impl RequestedPart for AccelerationBake {
    fn key(&self, geometry: &BakeGeometry) -> String {
        model_key(geometry, &self.0)
    }

    fn draft(&self) -> Self {
        AccelerationBake(self.0.draft())
    }

    fn within(&self, seconds: f64) -> Self {
        AccelerationBake(BakeOptions { patience: seconds, ..self.0 })
    }

    fn operations(&self, geometry: &BakeGeometry) -> f64 {
        cost::of_field(geometry, &self.0)
    }
}

impl BakedPart for AccelerationBake {
    type File = ModelFile;

    fn bake(
        request: &SoundModelRequest<Self>,
        cache: Option<&ModelCache>,
        progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
    ) -> Result<ModelFile, SoundModelError> {
        Ok(match cache {
            Some(cache) => bake_and_keep(request, cache, KEEP_EVERY, progress)?,
            None => bake_model(request, progress)?,
        })
    }

    fn rename(request: &SoundModelRequest<Self>, file: &mut ModelFile) {
        file.solid.name.clone_from(&request.solid.name);
    }

    fn not_kept(name: &str, error: &CacheError) -> String {
        format!("the model of \"{name}\" is not kept: {error}")
    }
}

/// Computation that a killed bake may lose: what takes less is not kept on the way.
pub const KEEP_EVERY: Duration = Duration::from_secs(5);

/// Computes the field, without a cache.
///
/// # Errors
/// [`BakeError`].
pub fn bake_model(
    request: &SoundModelRequest<AccelerationBake>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModelFile, BakeError> {
    bake_model_from(request, Resumption { solved: Vec::new(), keep: &mut |_| () }, progress)
}

/// Computes the field, keeps the solved frequencies in the cache at intervals of `every`, and resumes from
/// what an earlier call kept.
///
/// # Errors
/// [`BakeError`].
pub fn bake_and_keep(
    request: &SoundModelRequest<AccelerationBake>,
    cache: &ModelCache,
    every: Duration,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModelFile, BakeError> {
    let key = request.key();
    let mut kept_at = Instant::now();
    let mut keep = |solved: &[SolvedFrequency]| {
        // Without a folder to keep them in, a bake that is killed begins again.
        if kept_at.elapsed() >= every && cache.write_partial(key, solved).is_ok() {
            kept_at = Instant::now();
        }
    };
    let resumption = Resumption { solved: cache.read_partial(key), keep: &mut keep };
    bake_model_from(request, resumption, progress)
}

fn bake_model_from(
    request: &SoundModelRequest<AccelerationBake>,
    resumption: Resumption<'_>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<ModelFile, BakeError> {
    let AccelerationBake(options) = &request.part;
    let (acceleration, evidence) = resume_bake(&request.geometry, options, resumption, progress)?;
    Ok(ModelFile {
        acceleration,
        modal: None,
        solid: request.solid.clone(),
        origin: Origin {
            program: format!("clangor {}", env!("CARGO_PKG_VERSION")),
            inputs: request.key.clone(),
            asked_accuracy: options.accuracy,
            method: evidence.method,
            unknowns: evidence.unknowns as u64,
            solves: evidence.solves as u64,
            held_out_error: evidence.held_out_error,
            warnings: evidence.warnings,
        },
    })
}
