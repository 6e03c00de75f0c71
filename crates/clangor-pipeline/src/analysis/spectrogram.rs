//! How the spectrum of a sound changes in time.
//!
//! ```text
//! S(t, f) = |∫ w(s − t) p(s) e^{−2πifs} ds|²,    w = cos²(πs/L) for |s| < L/2
//! ```
//!
//! A window of length L tells frequencies apart that differ by 2/L, and instants that differ by L/2.

use std::f64::consts::PI;

use clangor_fourier::Planner;
use num_complex::Complex64;

use crate::analysis::spectrum::SpectrumError;

/// Power over time and frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrogram {
    /// Between neighbouring frequencies \[Hz\].
    pub step: f64,
    /// Frequencies from 0 on.
    pub rows: usize,
    /// S for each instant, frequencies in their order; in the square of the unit of the samples times
    /// seconds.
    pub powers: Vec<f64>,
}

/// Samples of a window, at least.
const LEAST_WINDOW: usize = 16;

impl Spectrogram {
    /// The spectrogram of a signal of `rate` \[Hz\] around `columns` instants in the middle of equal parts of
    /// it, up to a frequency, with windows of a length \[s\].
    ///
    /// # Errors
    /// [`SpectrumError`].
    pub fn of(
        samples: &[f32],
        rate: f64,
        columns: usize,
        max_frequency: f64,
        window: f64,
    ) -> Result<Self, SpectrumError> {
        if samples.len() < LEAST_WINDOW {
            return Err(SpectrumError::Short(samples.len()));
        }
        if let Some(at) = samples.iter().position(|p| !p.is_finite()) {
            return Err(SpectrumError::NotFinite(at));
        }
        if samples.iter().all(|p| *p == 0.0) {
            return Err(SpectrumError::Silent);
        }
        let length = ((window * rate).round() as usize).clamp(LEAST_WINDOW, samples.len());
        let padded = (2 * length).next_power_of_two();
        let step = rate / padded as f64;
        let rows = ((max_frequency / step) as usize + 1).min(padded / 2 + 1);
        let shape: Vec<f64> =
            (0..length).map(|n| (PI * ((n as f64 + 0.5) / length as f64 - 0.5)).cos().powi(2)).collect();
        let transform = Planner::new().forward(padded);
        let mut signal = vec![0.0; padded];
        let mut spectrum = vec![Complex64::ZERO; padded / 2 + 1];
        let mut powers = Vec::with_capacity(columns * rows);
        for column in 0..columns {
            let middle = (column as f64 + 0.5) / columns as f64 * samples.len() as f64;
            let first = middle.round() as i64 - length as i64 / 2;
            signal.fill(0.0);
            for (n, (value, weight)) in signal.iter_mut().zip(&shape).enumerate() {
                let sample = usize::try_from(first + n as i64).ok().and_then(|at| samples.get(at));
                *value = weight * sample.map_or(0.0, |p| f64::from(*p));
            }
            // Lengths are as planned, which is all that can go wrong.
            if transform.process(&mut signal, &mut spectrum).is_err() {
                return Err(SpectrumError::Short(samples.len()));
            }
            powers.extend(spectrum[..rows].iter().map(|p| p.norm_sqr() / (rate * rate)));
        }
        Ok(Spectrogram { step, rows, powers })
    }

    /// Number of instants.
    pub fn columns(&self) -> usize {
        self.powers.len() / self.rows.max(1)
    }

    /// Powers at an instant.
    pub fn column(&self, index: usize) -> &[f64] {
        &self.powers[index * self.rows..(index + 1) * self.rows]
    }

    /// The largest power.
    pub fn highest(&self) -> f64 {
        self.powers.iter().copied().fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn tones_are_where_and_when_they_sound() {
        let rate = 16_000.0;
        let tone = |n: usize| {
            let t = n as f64 / rate;
            let f = if t < 0.5 { 1000.0 } else { 3000.0 };
            (TAU * f * t).sin() as f32
        };
        let samples: Vec<f32> = (0..16_000).map(tone).collect();
        let found = Spectrogram::of(&samples, rate, 20, 4000.0, 0.02).unwrap();
        assert_eq!((found.columns(), found.rows), (20, (4000.0 / found.step) as usize + 1));
        for column in 0..20 {
            let powers = found.column(column);
            let top = (0..found.rows).max_by(|a, b| powers[*a].total_cmp(&powers[*b])).unwrap();
            let expected = if column < 10 { 1000.0 } else { 3000.0 };
            // The step is 15.6 Hz; tones lie on it.
            assert!((top as f64 * found.step - expected).abs() < found.step, "{column}: {top}");
            // A tone in the middle of a window of area L/2 has ½ · L/2 = 5 ms. Residual seen: 2e-5.
            assert!((powers[top].sqrt() / 0.005 - 1.0).abs() < 1e-3, "{column}: {}", powers[top].sqrt());
        }
    }

    #[test]
    fn sounds_without_a_spectrogram_are_refused() {
        let of = |samples: &[f32]| Spectrogram::of(samples, 48e3, 4, 20e3, 0.01);
        assert_eq!(of(&[0.0; 1000]), Err(SpectrumError::Silent));
        assert_eq!(of(&[1.0; 3]), Err(SpectrumError::Short(3)));
        let mut samples = [0.5; 100];
        samples[7] = f32::INFINITY;
        assert_eq!(of(&samples), Err(SpectrumError::NotFinite(7)));
        // Windows longer than the sound are as long as it is.
        samples[7] = 0.5;
        assert!(of(&samples).unwrap().highest() > 0.0);
    }
}
