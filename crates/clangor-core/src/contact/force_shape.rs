//! The shape of a contact force over time: one of the closed forms, or a history.
//!
//! Whatever the shape, the force is an impulse times S(t), with ∫ S dt = 1. Spectra are seen from the middle
//! of the duration τ, where those of the closed forms are real.

use std::sync::Arc;

use num_complex::Complex64;

use super::force_history::ForceHistory;
use super::force_profile::ForceProfile;

/// Shape of a force over time: see the module.
#[derive(Clone, Debug, PartialEq)]
pub enum ForceShape {
    /// A closed form, stretched to the duration.
    Profile(ForceProfile),
    /// The result of a solve.
    History(Arc<ForceHistory>),
}

impl Default for ForceShape {
    fn default() -> Self {
        ForceShape::Profile(ForceProfile::default())
    }
}

impl From<ForceProfile> for ForceShape {
    fn from(profile: ForceProfile) -> Self {
        ForceShape::Profile(profile)
    }
}

impl ForceShape {
    /// S(t) [1/s] at `time` after the onset \[s\], for a duration τ \[s\].
    pub fn value(&self, time: f64, duration: f64) -> f64 {
        match self {
            ForceShape::Profile(profile) => profile.value(time, duration),
            ForceShape::History(history) => history.value(time),
        }
    }

    /// Ŝ(ω) e^{iωτ/2}.
    pub fn centred_spectrum(&self, omega: f64, duration: f64) -> Complex64 {
        match self {
            ForceShape::Profile(profile) => Complex64::new(profile.centred_spectrum(omega, duration), 0.0),
            ForceShape::History(history) => {
                history.at_pole(Complex64::new(0.0, omega)) * Complex64::cis(0.5 * omega * duration)
            }
        }
    }

    /// ∫ S(t) e^{−λt} dt from the onset.
    pub fn at_pole(&self, pole: Complex64, duration: f64) -> Complex64 {
        match self {
            ForceShape::Profile(profile) => profile.at_pole(pole, duration),
            ForceShape::History(history) => history.at_pole(pole),
        }
    }

    /// Times after the onset \[s\] between which the force acts.
    pub fn extent(&self, duration: f64) -> (f64, f64) {
        match self {
            ForceShape::Profile(profile) => profile.extent(duration),
            ForceShape::History(history) => history.extent(),
        }
    }
}
