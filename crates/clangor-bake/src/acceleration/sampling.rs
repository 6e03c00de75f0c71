//! How densely frequencies are solved, and how long pulses are simulated, by what air a body encloses:
//! resonances put poles near the real axis and ring long. Shared by the choice of a solver and by its
//! estimated cost.

/// Spacing in κ of the first solves for bodies without cavities.
pub(crate) const SOLID_SPACING: f64 = 0.8;
/// The same for bodies with cavities.
pub(super) const CAVITY_SPACING: f64 = 0.45;
/// Spacing in κ of all solves of a body with cavities.
const CAVITY_DENSITY: f64 = 0.35;
/// Spacing in κ of all solves of a vessel with a narrow mouth.
pub(crate) const VESSEL_DENSITY: f64 = 0.15;
/// Spacing in κ of all solves of a body with or without cavities.
pub(crate) fn density(has_cavities: bool) -> f64 {
    if has_cavities { CAVITY_DENSITY } else { SOLID_SPACING }
}

/// Longest time simulated after the pulse, in R/c, without and with cavities.
pub(crate) const LONGEST: [f64; 2] = [12.0, 30.0];
