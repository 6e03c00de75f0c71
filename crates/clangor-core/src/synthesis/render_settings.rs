//! Settings of a rendering to sound pressure: sample rate, acoustics and band limit.
//!
//! The band limit is that of [`lowpass`]: rendered in full up to f₁, nothing from f₂ on, with
//! f₂ − f₁ = 2/30 of the sample rate, and at most (f₁ + f₂)/2 = 0.45 of it.

use super::listener::Floor;
use super::lowpass;
use super::{SampleRate, SynthesisError};
use crate::medium::Medium;
use crate::propagation::PathLoss;
use crate::sound_model::acceleration::sphere_radiation::SphereModel;

/// How to render.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderSettings {
    /// Samples per second.
    pub sample_rate: SampleRate,
    /// Time of sample 0 \[s\].
    pub start: f64,
    /// What carries the sound.
    pub medium: Medium,
    /// What reflects it.
    pub floor: Floor,
    /// Field of an accelerated sphere.
    pub sphere_model: SphereModel,
    /// What is lost on the way.
    pub loss: PathLoss,
    /// Highest frequency that is rendered in full \[Hz\]; by default what the sample rate holds.
    pub max_frequency: Option<f64>,
}

impl RenderSettings {
    /// Refuses what gives no sound.
    pub(super) fn check(&self) -> Result<(), SynthesisError> {
        let Medium { density, sound_speed } = self.medium;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !positive(density) || !positive(sound_speed) {
            return Err(SynthesisError::BadMedium { density, sound_speed });
        }
        match self.max_frequency.filter(|hz| !positive(*hz)) {
            Some(hz) => Err(SynthesisError::MaxFrequency { hz }),
            None => Ok(()),
        }
    }

    /// Highest frequency that is rendered in full, and that from which on nothing is \[Hz\].
    pub fn band(&self) -> (f64, f64) {
        let rate = self.sample_rate.as_f64();
        let widest = lowpass::CENTRE * rate;
        let half_width = lowpass::HALF_WIDTH * rate;
        let centre = self.max_frequency.map_or(widest, |f| (f + half_width).min(widest));
        (centre - half_width, centre + half_width)
    }

    /// k = 2πf/c [1/m] of the highest frequency that is rendered in full.
    pub fn max_wavenumber(&self) -> f64 {
        std::f64::consts::TAU * self.band().0 / self.medium.sound_speed
    }
}
