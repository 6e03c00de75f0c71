//! The spectrum of a sound, and its peaks.
//!
//! ```text
//! P(f) = ∫ w(t) p(t) e^{−2πift} dt,    w = 1 in the first half, then cos² to 0
//! ```
//!
//! Sounds of impacts begin with silence and end by fading, so that only their end is tapered: a window that
//! opens slowly would take away the modes that die first.

use std::f64::consts::PI;

use clangor_fourier::Planner;
use num_complex::Complex64;

/// Magnitudes at even steps of frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Between neighbours \[Hz\].
    pub step: f64,
    /// |P| from 0 Hz on, in the unit of the samples times seconds.
    pub magnitudes: Vec<f64>,
}

/// A maximum of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Where \[Hz\].
    pub frequency: f64,
    /// Level against the highest of the spectrum \[dB\].
    pub level: f64,
}

/// Why a sound has no spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpectrumError {
    /// Too few samples.
    #[error("the sound has {0} samples; a spectrum needs {LEAST_SAMPLES}")]
    Short(usize),
    /// Nothing but zeros.
    #[error("the sound is silent")]
    Silent,
    /// Samples that are no numbers.
    #[error("the sound has samples that are not finite, the first at {0}")]
    NotFinite(usize),
}

/// Samples that are worth a spectrum.
const LEAST_SAMPLES: usize = 16;
/// Points of the spectrum on each that the sound determines: enough to find peaks between them.
const PADDING: usize = 2;
/// How far the spectrum falls on both sides of what counts as a peak, over its height.
const FALL: f64 = 0.5;

impl Spectrum {
    /// The spectrum of a signal of `rate` \[Hz\].
    ///
    /// # Errors
    /// [`SpectrumError`].
    pub fn of(samples: &[f32], rate: f64) -> Result<Self, SpectrumError> {
        let count = samples.len();
        if count < LEAST_SAMPLES {
            return Err(SpectrumError::Short(count));
        }
        if let Some(at) = samples.iter().position(|p| !p.is_finite()) {
            return Err(SpectrumError::NotFinite(at));
        }
        if samples.iter().all(|p| *p == 0.0) {
            return Err(SpectrumError::Silent);
        }
        let length = (PADDING * count).next_power_of_two();
        let window = |n: usize| {
            let late = (2.0 * n as f64 / count as f64 - 1.0).max(0.0);
            (0.5 * PI * late).cos().powi(2)
        };
        let mut signal: Vec<f64> =
            samples.iter().enumerate().map(|(n, p)| window(n) * f64::from(*p)).collect();
        signal.resize(length, 0.0);
        let transform = Planner::new().forward(length);
        let mut spectrum = vec![Complex64::ZERO; length / 2 + 1];
        // Lengths are as planned, which is all that can go wrong.
        if transform.process(&mut signal, &mut spectrum).is_err() {
            return Err(SpectrumError::Short(count));
        }
        Ok(Spectrum {
            step: rate / length as f64,
            magnitudes: spectrum.iter().map(|p| p.norm() / rate).collect(),
        })
    }

    /// Magnitudes up to a frequency \[Hz\].
    pub fn up_to(&self, frequency: f64) -> &[f64] {
        let count = ((frequency / self.step).max(0.0) as usize + 1).min(self.magnitudes.len());
        &self.magnitudes[..count]
    }

    /// The peaks up to a frequency \[Hz\] that are at most `depth` \[dB\] below the highest and stand out by
    /// 6 dB on both sides, by frequency.
    pub fn peaks(&self, frequency: f64, depth: f64) -> Vec<Peak> {
        let levels = self.up_to(frequency);
        let highest = levels.iter().copied().fold(0.0, f64::max);
        let least = highest * 10.0_f64.powf(-depth / 20.0);
        // Falls on one side before it rises above the peak.
        let falls = |own: f64, others: &mut dyn Iterator<Item = &f64>| {
            others.take_while(|m| **m <= own).any(|m| *m < FALL * own)
        };
        let is_peak = |k: &usize| {
            let own = levels[*k];
            own >= least
                && own > levels[k - 1]
                && own >= levels[k + 1]
                && falls(own, &mut levels[..*k].iter().rev())
                && falls(own, &mut levels[k + 1..].iter())
        };
        (1..levels.len().saturating_sub(1))
            .filter(is_peak)
            .map(|k| {
                // The top of the parabola through three levels.
                let [a, b, c] = [levels[k - 1], levels[k], levels[k + 1]].map(f64::ln);
                let curvature = a - 2.0 * b + c;
                let aside = if curvature < 0.0 { 0.5 * (a - c) / curvature } else { 0.0 };
                Peak {
                    frequency: self.step * (k as f64 + aside),
                    level: 20.0 * (levels[k] / highest).log10(),
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn decaying_tones_peak_where_they_are() {
        let rate = 16_000.0;
        let tones: [(f64, f64, f64); 3] = [(437.3, 1.0, 3.0), (1210.8, 0.01, 8.0), (5003.1, 0.2, 30.0)];
        let sample = |n: usize| {
            let t = n as f64 / rate;
            tones.iter().map(|(f, a, d)| a * (-d * t).exp() * (TAU * f * t).sin()).sum::<f64>() as f32
        };
        let samples: Vec<f32> = (0..32_000).map(sample).collect();
        let spectrum = Spectrum::of(&samples, rate).unwrap();
        let peaks = spectrum.peaks(8000.0, 60.0);
        assert_eq!(peaks.len(), tones.len(), "{peaks:?}");
        for (peak, (f, a, d)) in peaks.iter().zip(tones) {
            // Residual seen: 0.11 Hz, of a tone among the skirts of louder ones.
            assert!((peak.frequency - f).abs() < 0.2, "{peak:?}");
            // The tone's integral a/(2d), but for the end of the window.
            let at = (peak.frequency / spectrum.step).round() as usize;
            let expected = a / (2.0 * d);
            assert!(
                (spectrum.magnitudes[at] / expected - 1.0).abs() < 0.1,
                "{peak:?} {}",
                spectrum.magnitudes[at]
            );
        }
        assert_eq!(spectrum.peaks(1000.0, 60.0).len(), 1);
    }

    #[test]
    fn sounds_without_a_spectrum_are_refused() {
        assert_eq!(Spectrum::of(&[0.0; 100], 48e3), Err(SpectrumError::Silent));
        assert_eq!(Spectrum::of(&[1.0; 3], 48e3), Err(SpectrumError::Short(3)));
        let mut samples = [0.5; 100];
        samples[7] = f32::NAN;
        assert_eq!(Spectrum::of(&samples, 48e3), Err(SpectrumError::NotFinite(7)));
    }
}
