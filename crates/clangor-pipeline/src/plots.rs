//! Pictures and levels of what was computed.

pub mod bank_use;
pub mod field;
pub mod levels;
pub mod modes;
pub mod picture;
pub mod spectrogram;
pub mod spectrogram_plot;
pub mod spectrum;
pub mod spectrum_plot;
