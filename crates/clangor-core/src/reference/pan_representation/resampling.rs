//! Band-limited interpolation: a sampled signal at times between its samples, and sums of shifted copies.
//!
//! The kernel is the sinc of the lower of the two Nyquist frequencies under a Kaiser window:
//!
//! ```text
//! x(t) = Σ_j x_j K(t/δ − j),   K(t) = c sinc(c t) I₀(β√(1 − (c t/w)²))/I₀(β),   |c t| < w
//! ```
//!
//! with w = 32 zero crossings on each side and c ≤ 1 the cut-off over the Nyquist frequency of the samples.
//! The kernel is tabulated once and interpolated linearly, 4e-7 of its peak off.

use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::math::bessel::bessel_i0;

/// Zero crossings on each side: the transition is ±9 % of the cut-off.
const HALF_WIDTH: usize = 32;
/// Kaiser's β: side lobes of −90 dB.
const BETA: f64 = 9.0;
/// Table entries between zero crossings.
const STEPS: usize = 1024;

/// sinc(t) under the window at t = i/STEPS; one zero behind the end.
static KERNEL: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let value = |i: usize| {
        let t = i as f64 / STEPS as f64;
        let inside = 1.0 - (t / HALF_WIDTH as f64).powi(2);
        let sinc = if i == 0 { 1.0 } else { (PI * t).sin() / (PI * t) };
        sinc * bessel_i0(BETA * inside.max(0.0).sqrt()) / bessel_i0(BETA)
    };
    (0..HALF_WIDTH * STEPS).map(value).chain([0.0, 0.0]).collect()
});

fn kernel(table: &[f64], t: f64) -> f64 {
    let place = (t.abs() * STEPS as f64).min((HALF_WIDTH * STEPS) as f64);
    let i = place as usize;
    table[i] + (place - i as f64) * (table[i + 1] - table[i])
}

/// A signal on a regular grid in time, zero outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Time of the first sample.
    pub start: f64,
    /// Time between samples.
    pub step: f64,
    /// Samples.
    pub samples: Vec<f64>,
}

impl Series {
    /// Leaves out the ends that are below `tolerance` of the largest sample.
    pub fn trim(&mut self, tolerance: f64) {
        let least = tolerance * self.samples.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let loud = |x: &f64| x.abs() > least;
        let Some(first) = self.samples.iter().position(loud) else {
            self.samples.clear();
            return;
        };
        let last = self.samples.iter().rposition(loud).unwrap_or(first);
        self.samples.truncate(last + 1);
        self.samples.drain(..first);
        self.start += first as f64 * self.step;
    }

    /// Σ_k weights_k x(t − k · spacing), on the grid of this signal.
    ///
    /// The filter that shifts and adds is as long as all shifts together, so this costs as much for many
    /// pulses as for few that last as long.
    pub fn shifted_sum(&self, weights: &[f64], spacing: f64) -> Series {
        let table = &*KERNEL;
        let width = HALF_WIDTH as i64;
        let spacing = spacing / self.step;
        let longest = (spacing * weights.len().saturating_sub(1) as f64).ceil() as i64;
        let mut filter = vec![0.0; (longest + 2 * width) as usize];
        for (k, weight) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            let at = k as f64 * spacing;
            let nearest = at.floor() as i64;
            for m in (nearest - width + 1)..=(nearest + width) {
                if let Some(tap) = filter.get_mut((m + width - 1) as usize) {
                    *tap += weight * kernel(table, m as f64 - at);
                }
            }
        }
        let mut samples = vec![0.0; self.samples.len() + filter.len() - 1];
        for (j, &x) in self.samples.iter().enumerate() {
            samples[j..j + filter.len()].iter_mut().zip(&filter).for_each(|(y, g)| *y += x * g);
        }
        Series { start: self.start - (width - 1) as f64 * self.step, step: self.step, samples }
    }

    /// The signal at the times n/`rate`, without what lies above `cutoff` (cycles per unit of time, at most
    /// half of either rate): n of the first sample, and the samples.
    pub fn resampled(&self, rate: f64, cutoff: f64) -> (i64, Vec<f64>) {
        let table = &*KERNEL;
        let relative = 2.0 * cutoff * self.step;
        let reach = HALF_WIDTH as f64 / relative;
        let end = self.start + (self.samples.len() as f64 - 1.0) * self.step;
        let first = ((self.start - reach * self.step) * rate).ceil() as i64;
        let last = ((end + reach * self.step) * rate).floor() as i64;
        let sample = |n: i64| {
            let at = (n as f64 / rate - self.start) / self.step;
            let from = (at - reach).ceil().max(0.0) as usize;
            let to = ((at + reach).floor().max(-1.0) + 1.0) as usize;
            let window = &self.samples[from.min(self.samples.len())..to.min(self.samples.len())];
            let sum: f64 = window
                .iter()
                .enumerate()
                .map(|(j, x)| x * kernel(table, relative * (at - (from + j) as f64)))
                .sum();
            relative * sum
        };
        (first, (first..=last).map(sample).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn burst(t: f64) -> f64 {
        (-(t / 9.0).powi(2)).exp() * (1.1 * t).cos()
    }

    fn series() -> Series {
        Series { start: -59.7, step: 1.0, samples: (0..120).map(|j| burst(f64::from(j) - 59.7)).collect() }
    }

    #[test]
    fn shifted_copies_are_the_signal_at_shifted_times() {
        let weights = [0.0, 1.0, -0.4, 0.7];
        let sum = series().shifted_sum(&weights, 3.37);
        for (j, x) in sum.samples.iter().enumerate() {
            let t = sum.start + j as f64;
            let exact: f64 = weights.iter().enumerate().map(|(k, w)| w * burst(t - 3.37 * k as f64)).sum();
            // Residual seen: 2e-5, the side lobes of the kernel.
            assert!((x - exact).abs() < 6e-5, "{t}: {x} {exact}");
        }
    }

    #[test]
    fn resampling_keeps_what_is_below_the_cutoff_and_drops_the_rest() {
        for (rate, cutoff) in [(0.83, 0.37), (1.7, 0.45), (1.0, 0.45)] {
            let (first, samples) = series().resampled(rate, cutoff);
            for (i, x) in samples.iter().enumerate() {
                let t = (first + i as i64) as f64 / rate;
                // Residual seen: 3e-5.
                assert!((x - burst(t)).abs() < 1e-4, "{rate} {t}: {x} {}", burst(t));
            }
        }
        // The burst is at 0.175 ± 0.05 cycles per sample.
        let (_, samples) = series().resampled(0.2, 0.05);
        let loudest = samples.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        // Seen: 1.6e-5.
        assert!(loudest < 1e-4, "{loudest}");
    }

    #[test]
    fn trimming_keeps_the_times() {
        let mut x = Series { start: 2.0, step: 0.5, samples: vec![0.0, 1e-9, 0.5, 0.0, 1.0, 1e-8] };
        x.trim(1e-6);
        assert_eq!(x, Series { start: 3.0, step: 0.5, samples: vec![0.5, 0.0, 1.0] });
        x.samples.fill(0.0);
        x.trim(1e-6);
        assert!(x.samples.is_empty());
        assert!(x.shifted_sum(&[1.0], 1.0).samples.iter().all(|y| *y == 0.0));
    }
}
