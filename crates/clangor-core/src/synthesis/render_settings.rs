//! Settings of a rendering to sound pressure: sample rate, acoustics and band limit.
//!
//! The band limit is that of [`lowpass`]: full gain up to f₁, zero from f₂ on, with f₂ − f₁ = 2/30 of the
//! sample rate, and (f₁ + f₂)/2 at most 0.45 of it.

use super::lowpass;
use super::{SampleRate, SynthesisError};
use crate::acoustics::Acoustics;
use crate::medium::Medium;
use crate::propagation::Floor;
use crate::sound_model::acceleration::sphere_radiation::SphereModel;

/// Settings of a rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderSettings {
    /// Sample rate \[Hz\], 8000 to 384 000. Default: 48 000.
    pub sample_rate: SampleRate,
    /// Time of sample 0 \[s\]. Default: 0.
    pub start: f64,
    /// Medium, air, reflectors and band limit.
    pub acoustics: Acoustics,
    /// Sound field of an accelerated sphere.
    pub sphere_model: SphereModel,
}

impl RenderSettings {
    /// The same settings with another sample rate.
    #[must_use]
    pub fn with_sample_rate(self, sample_rate: SampleRate) -> Self {
        RenderSettings { sample_rate, ..self }
    }

    /// The same settings with other acoustics.
    #[must_use]
    pub fn with_acoustics(self, acoustics: Acoustics) -> Self {
        RenderSettings { acoustics, ..self }
    }

    /// The same settings with another reflecting floor.
    #[must_use]
    pub fn with_floor(mut self, floor: Floor) -> Self {
        self.acoustics.floor = floor;
        self
    }

    /// The same settings with another band limit \[Hz\]; `None`: as high as the sample rate allows.
    #[must_use]
    pub fn with_max_frequency(mut self, max_frequency: Option<f64>) -> Self {
        self.acoustics.max_frequency = max_frequency;
        self
    }

    /// Rejects an invalid medium, band limit, or planes in a room.
    pub(super) fn check(&self) -> Result<(), SynthesisError> {
        let Medium { density, sound_speed } = self.acoustics.medium;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !positive(density) || !positive(sound_speed) {
            return Err(SynthesisError::BadMedium { density, sound_speed });
        }
        self.acoustics.check()?;
        match self.acoustics.max_frequency.filter(|hz| !positive(*hz)) {
            Some(hz) => Err(SynthesisError::MaxFrequency { hz }),
            None => Ok(()),
        }
    }

    /// Highest frequency rendered in full, and lowest frequency from which on the output is zero \[Hz\].
    pub fn band(&self) -> (f64, f64) {
        let rate = self.sample_rate.as_f64();
        let widest = lowpass::CENTRE * rate;
        let half_width = lowpass::HALF_WIDTH * rate;
        match self.acoustics.max_frequency {
            // Models are baked up to this frequency, and their keys depend on its last bit.
            Some(hz) if hz + half_width < widest => (hz, hz + 2.0 * half_width),
            _ => (widest - half_width, widest + half_width),
        }
    }

    /// k = 2πf/c [1/m] of the highest frequency rendered in full.
    pub fn max_wavenumber(&self) -> f64 {
        std::f64::consts::TAU * self.band().0 / self.acoustics.medium.sound_speed
    }
}
