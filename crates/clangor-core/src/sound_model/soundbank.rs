//! Soundbanks of ellipsoids, for bodies without a sound model of their own.

pub mod ellipsoid_bank;
pub mod modal_soundbank;
