//! Where sound models come from that need not be baked.

use clangor_core::sound_model::acceleration::model_evaluator::BankEvaluator;

use crate::formats::model_cache::ModelCache;

/// The cache of baked models and the soundbank of ellipsoids; without both, everything is baked.
#[derive(Clone, Copy, Debug, Default)]
pub struct SoundModelStore<'a> {
    /// Models baked before.
    pub cache: Option<&'a ModelCache>,
    /// Fields of accelerated ellipsoids.
    pub bank: Option<&'a BankEvaluator>,
}
