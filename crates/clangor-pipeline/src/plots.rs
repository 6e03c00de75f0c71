//! Pictures of sound models, sounds and fracture reports.

pub mod bank_use;
pub mod field;
pub mod modes;
pub mod picture;
pub mod spectrogram;
pub mod spectrum;
