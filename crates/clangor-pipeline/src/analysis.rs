//! Analysis of sounds: levels, spectra and spectrograms.

pub mod levels;
pub mod spectrogram;
pub mod spectrum;
