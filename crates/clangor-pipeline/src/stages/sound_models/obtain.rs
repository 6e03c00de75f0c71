//! One part of a sound model: from the cache, or baked and kept there.

use std::ops::ControlFlow;

use clangor_bake::acceleration::BakeProgress;
use clangor_bake::cost::seconds;

use super::error::SoundModelError;
use super::request::{RequestedPart, SoundModelRequest};
use crate::formats::model_cache::{CacheEntry, CacheError, Lookup, ModelCache};

/// A part that can be baked into a file of its own.
pub trait BakedPart: RequestedPart + Sized {
    /// The file.
    type File: CacheEntry;

    /// Computes the part. A long bake keeps what it has in the cache, and resumes from what an earlier call
    /// kept.
    ///
    /// # Errors
    /// [`SoundModelError`].
    fn bake(
        request: &SoundModelRequest<Self>,
        cache: Option<&ModelCache>,
        progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
    ) -> Result<Self::File, SoundModelError>;

    /// Replaces the names in a file, which are those of the first bake, by those of the request.
    fn rename(request: &SoundModelRequest<Self>, file: &mut Self::File);

    /// The remark on a file that could not be kept.
    fn not_kept(name: &str, error: &CacheError) -> String;
}

impl<P: BakedPart> SoundModelRequest<P> {
    /// Estimated CPU time \[s\] until it is there: none if it is in the cache.
    pub fn cost(&self, cache: Option<&ModelCache>) -> f64 {
        let there = cache.is_some_and(|cache| cache.path::<P::File>(self.key()).is_file());
        if there { 0.0 } else { seconds(self.part().operations(self.geometry())) }
    }
}

/// A part of a sound model, and where it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Obtained<F> {
    /// The part.
    pub file: F,
    /// Whether it was in the cache.
    pub cached: bool,
    /// An entry that was replaced, or that could not be kept.
    pub remarks: Vec<String>,
}

/// The requested part of a sound model: from the cache, or baked and kept there. A cache that fails costs
/// time, not the model.
///
/// # Errors
/// [`SoundModelError`].
pub fn obtain<P: BakedPart>(
    request: &SoundModelRequest<P>,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<Obtained<P::File>, SoundModelError> {
    let mut remarks = Vec::new();
    match cache.map_or(Lookup::Missing, |cache| cache.read::<P::File>(request.key())) {
        Lookup::Found(mut file) => {
            P::rename(request, &mut file);
            return Ok(Obtained { file: *file, cached: true, remarks });
        }
        Lookup::Missing => {}
        Lookup::Invalid(why) => remarks.push(format!("{why}; it is baked again")),
    }
    let file = P::bake(request, cache, progress)?;
    if let Some(Err(error)) = cache.map(|cache| cache.write(&file)) {
        remarks.push(P::not_kept(request.name(), &error));
    }
    Ok(Obtained { file, cached: false, remarks })
}
