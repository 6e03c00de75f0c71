//! How far the sound models of a scene are.

use clangor_core::synthesis::SoundPart;

/// How far the baking of one part of the sound models is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoundModelProgress<'a> {
    /// The part.
    pub part: SoundPart,
    /// The body whose model is baked, the first of those that share it; empty for a soundbank.
    pub body: &'a str,
    /// Fraction done of this part of all models, 0 to 1.
    pub done: f64,
    /// What is being computed.
    pub step: &'static str,
}
