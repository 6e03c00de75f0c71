//! Soundbanks of ellipsoids, computed from nothing: their acceleration noise and their modes.

pub mod acceleration;
pub mod modal;
