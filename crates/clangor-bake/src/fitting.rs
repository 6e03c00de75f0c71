//! Fits: surface pressure to multipoles, spectra to rational functions; and the distance of two fields.

pub mod comparison;
pub mod multipole_projection;
pub mod rational;
