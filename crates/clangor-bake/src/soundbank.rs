//! Soundbanks of ellipsoids, baked from first principles: acceleration noise and modes.

pub mod acceleration;
pub mod modal;
