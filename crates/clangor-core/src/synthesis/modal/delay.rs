//! Propagation delay from a body to a receiver: arrival of each emitted sample, and the received signal
//! between samples.
//!
//! With the delay d(e), in samples, of the sound emitted at e, sample n receives the sound emitted at the e
//! with e + d(e) = n. The delay is computed about every millisecond and interpolated by a cubic with the
//! slopes of neighbouring points (Catmull and Rom); e is found by Newton's method. The signal between samples
//! is that of a Kaiser-windowed sinc of 64 samples, flat to 0.45 of the rate, with side lobes of −100 dB.

use std::sync::LazyLock;

use crate::math::bessel::bessel_i0;

/// Half the length of the sinc \[samples\].
pub(super) const HALF_TAPS: usize = 32;
const TAPS: usize = 2 * HALF_TAPS;
/// Fractions of a sample for which it is tabulated; linear interpolation between them has an error of 5e-6 at
/// most.
const PHASES: usize = 512;
/// Kaiser's β.
const BETA: f64 = 10.0;

/// Signal emitted along one path, and its arrival times.
#[derive(Clone, Debug, Default)]
pub(super) struct DelayLine {
    /// Index of the first sample held.
    base: i64,
    /// Samples between known delays.
    spacing: i64,
    /// Place of the first known delay over the spacing.
    first: i64,
    delays: Vec<f64>,
    /// Emission time of the sample received last.
    left: Option<f64>,
}

impl DelayLine {
    /// A line whose samples begin with `base` and whose delays are known at the multiples of `spacing` from
    /// `first` × `spacing` on.
    pub(super) fn new(base: i64, spacing: i64, first: i64) -> Self {
        DelayLine { base, spacing, first, delays: Vec::new(), left: None }
    }

    /// Adds the delay \[samples\] at the next multiple of the spacing.
    pub(super) fn push_delay(&mut self, delay: f64) {
        self.delays.push(delay);
    }

    /// Arrival time of the sample emitted at e, and by how much later the next one arrives.
    fn arrival(&self, left: f64) -> (f64, f64) {
        let place = left / self.spacing as f64 - self.first as f64;
        let last = self.delays.len() as isize - 1;
        let at = (place.floor() as isize).clamp(0, (last - 1).max(0));
        let value = |i: isize| self.delays[i.clamp(0, last) as usize];
        let u = (place - at as f64).clamp(0.0, 1.0);
        let (p, q) = (value(at), value(at + 1));
        let (m, n) = (0.5 * (q - value(at - 1)), 0.5 * (value(at + 2) - p));
        let (cubic, square) = (2.0 * p - 2.0 * q + m + n, -3.0 * p + 3.0 * q - 2.0 * m - n);
        let delay = ((cubic * u + square) * u + m) * u + p;
        let slope = ((3.0 * cubic * u + 2.0 * square) * u + m) / self.spacing as f64;
        let inside = (place - at as f64 - u).abs() < 1e-9;
        (left + delay, if inside { 1.0 + slope } else { 1.0 })
    }

    /// Whether all sound that arrives up to `sample` has been emitted, if samples before `end` have.
    pub(super) fn covers(&self, sample: i64, end: i64) -> bool {
        let known = self.arrival((end - HALF_TAPS as i64 - 1) as f64).0;
        known >= sample as f64
    }

    /// Adds the arriving sound to `channel`, whose first sample is `first`.
    pub(super) fn listen(&mut self, sent: &[f64], first: i64, channel: &mut [f64]) {
        for (i, sum) in channel.iter_mut().enumerate() {
            let sample = (first + i as i64) as f64;
            let mut left =
                self.left.map_or_else(|| sample - self.delays.first().copied().unwrap_or(0.0), |l| l + 1.0);
            for _ in 0..20 {
                let (arrival, slope) = self.arrival(left);
                // With a supersonic receiver the solution is not unique; any later one will do.
                let step = (sample - arrival) / slope.max(0.2);
                left += step;
                if step.abs() < 1e-9 {
                    break;
                }
            }
            self.left = Some(left);
            *sum += interpolated(sent, left - self.base as f64);
        }
    }

    /// Restarts reception, for a receiver that continues elsewhere.
    pub(super) fn forget_place(&mut self) {
        self.left = None;
    }

    /// Drops samples that will not be received any more.
    pub(super) fn trim(&mut self, sent: &mut Vec<f64>) {
        let Some(left) = self.left else { return };
        let needed = left.floor() as i64 - TAPS as i64;
        let done = (needed - self.base).clamp(0, sent.len() as i64) as usize;
        if done > sent.len() / 2 {
            sent.drain(..done);
            self.base += done as i64;
        }
        let passed =
            (needed.div_euclid(self.spacing) - 2 - self.first).clamp(0, self.delays.len() as i64) as usize;
        if passed > self.delays.len() / 2 {
            self.delays.drain(..passed);
            self.first += passed as i64;
        }
    }
}

/// The signal between samples; silence before the first and after the last.
fn interpolated(samples: &[f64], place: f64) -> f64 {
    let whole = place.floor();
    let start = whole as i64 - HALF_TAPS as i64 + 1;
    if start + TAPS as i64 <= 0 || start >= samples.len() as i64 {
        return 0.0;
    }
    let phase = (place - whole) * PHASES as f64;
    let (row, part) = ((phase as usize).min(PHASES - 1), phase.fract());
    let (here, next) = (&SINC[row], &SINC[row + 1]);
    let sum = |samples: &[f64], from: usize| {
        let range = from..from + samples.len();
        samples
            .iter()
            .zip(&here[range.clone()])
            .zip(&next[range])
            .map(|((s, a), b)| s * (a + part * (b - a)))
            .sum::<f64>()
    };
    let begin = start.max(0) as usize;
    let end = ((start + TAPS as i64) as usize).min(samples.len());
    sum(&samples[begin..end], (begin as i64 - start) as usize)
}

/// sinc(x) times the window, for each fraction of a sample.
static SINC: LazyLock<Vec<[f64; TAPS]>> = LazyLock::new(|| windowed_sinc(PHASES, BETA));

/// sinc(x) times Kaiser's window of this β, at the samples around a place, for so many fractions of a sample
/// and 1.
pub(super) fn windowed_sinc<const TAPS: usize>(phases: usize, beta: f64) -> Vec<[f64; TAPS]> {
    let half = (TAPS / 2) as f64;
    let scale = bessel_i0(beta);
    let value = |x: f64| {
        let window = 1.0 - (x / half).powi(2);
        if window <= 0.0 {
            return 0.0;
        }
        let angle = std::f64::consts::PI * x;
        let sinc = if angle.abs() < 1e-8 { 1.0 } else { angle.sin() / angle };
        sinc * bessel_i0(beta * window.sqrt()) / scale
    };
    let row = |phase: usize| {
        let fraction = phase as f64 / phases as f64;
        std::array::from_fn(|tap| value(tap as f64 - (half - 1.0) - fraction))
    };
    (0..=phases).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_is_interpolated_up_to_the_end_of_the_band() {
        for part in [0.0, 0.1, 0.3, 0.41] {
            let tone = |t: f64| (std::f64::consts::TAU * part * t + 0.4).cos();
            let samples: Vec<f64> = (0..200).map(|i| tone(f64::from(i))).collect();
            for place in [100.0, 100.25, 100.4999, 99.7003, 120.999_99] {
                let error = (interpolated(&samples, place) - tone(place)).abs();
                assert!(error < 2e-5, "{part} {place}: {error:e}");
            }
        }
        assert_eq!(interpolated(&[1.0; 10], -40.0), 0.0);
        assert_eq!(interpolated(&[1.0; 10], 50.0), 0.0);
    }

    #[test]
    fn a_growing_delay_stretches_time() {
        let mut line = DelayLine::new(0, 10, -2);
        (-2..60).for_each(|i| line.push_delay(7.5 + 0.02 * f64::from(i) * 10.0));
        let sent: Vec<f64> = (0..500).map(|i| (0.3 * f64::from(i)).sin()).collect();
        let mut heard = vec![0.0; 200];
        line.listen(&sent, 150, &mut heard);
        for (i, value) in heard.iter().enumerate() {
            let left = ((150 + i) as f64 - 7.5) / 1.02;
            assert!((value - (0.3 * left).sin()).abs() < 2e-5, "{i}");
        }
    }
}
