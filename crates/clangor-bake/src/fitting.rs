//! Fits: surface pressure to multipoles, spectra to rational functions; and how far two fields are apart.

pub mod comparison;
pub mod multipole_projection;
pub mod rational;
