//! Analysis of sounds: levels, spectra and spectrograms, decaying tones and what they say of a body.

pub mod damping_fit;
pub mod decaying_tones;
pub mod levels;
pub mod mode_match;
pub mod spectrogram;
pub mod spectrum;
mod subband;
