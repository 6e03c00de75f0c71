//! The sample rate of a rendering.

use super::synthesis_error::{HIGHEST_RATE_HZ, LOWEST_RATE_HZ, SynthesisError};

/// Samples per second, 8 to 384 kHz.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SampleRate(u32);

impl SampleRate {
    /// Lowest rate \[Hz\].
    pub const MIN_HZ: u32 = LOWEST_RATE_HZ;
    /// Highest rate \[Hz\].
    pub const MAX_HZ: u32 = HIGHEST_RATE_HZ;
    /// 48 kHz.
    pub const HZ_48000: SampleRate = SampleRate(48_000);

    /// A rate in hertz.
    ///
    /// # Errors
    /// [`SynthesisError::SampleRate`] outside 8 to 384 kHz.
    pub fn try_new(hz: u32) -> Result<Self, SynthesisError> {
        let supported = (Self::MIN_HZ..=Self::MAX_HZ).contains(&hz);
        supported.then_some(SampleRate(hz)).ok_or(SynthesisError::SampleRate { hz })
    }

    /// The rate \[Hz\].
    pub fn hz(self) -> u32 {
        self.0
    }

    /// The rate \[Hz\] as a real number.
    pub fn as_f64(self) -> f64 {
        f64::from(self.0)
    }
}

impl Default for SampleRate {
    fn default() -> Self {
        SampleRate::HZ_48000
    }
}
