//! A contact force over time that has no closed form, on the coarsest grid that holds its audible part.
//!
//! A solve of the contact gives a force that is constant on steps of its own length. What is heard of it lies
//! below a band B. The force is filtered and sampled at the rate 4 B,
//!
//! ```text
//! v_m = ∫ F(t) g(t_m − t) dt        g: sinc of cutoff 2 B, Kaiser window of 16 samples, β = 12
//! ```
//!
//! so that Σ v_m e^{−iωt_m}/(4 B) is the spectrum of F to 3e-6 for ω ≤ 2π B. The filter rings for 8 samples
//! before and after the force. The history is kept per unit of impulse, because the same force acts on the
//! motion, the modes and the ground, and may be scaled.
//!
//! Not covered: frequencies above B.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use num_complex::Complex64;

use crate::math::bessel::bessel_i0;

/// Samples per period of the band.
const RATE_OVER_BAND: f64 = 4.0;
/// Half-length of the filter \[samples\].
const REACH: f64 = 8.0;
/// Kaiser's β.
const BETA: f64 = 12.0;
/// Entries of the filter's table per sample.
const DENSITY: usize = 64;
/// Frequencies that advance together.
const LANES: usize = 8;

/// A force over time, of unit impulse: see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceHistory {
    /// Time of the first sample after the onset \[s\], usually negative.
    start: f64,
    /// Distance of the samples \[s\].
    step: f64,
    /// v [1/s].
    values: Vec<f64>,
    /// B \[Hz\].
    band: f64,
}

impl ForceHistory {
    /// Forces \[N\], each constant over a `step` \[s\], the first from the onset on, kept up to a `band`
    /// \[Hz\]; with their impulse [N s]. `None` for forces without impulse, or numbers that are not finite.
    pub fn of_steps(forces: &[f64], step: f64, band: f64) -> Option<(ForceHistory, f64)> {
        let impulse = forces.iter().sum::<f64>() * step;
        let usable = impulse.is_finite() && impulse != 0.0 && step > 0.0 && band > 0.0 && band.is_finite();
        if !usable {
            return None;
        }
        let spacing = 1.0 / (RATE_OVER_BAND * band);
        let first = -REACH.ceil();
        let end = forces.len() as f64 * step / spacing + REACH;
        let mut values = vec![0.0; (end - first).ceil() as usize + 1];
        // Each step adds the integral of the filter over it to the samples within reach.
        for (n, force) in forces.iter().enumerate().filter(|(_, force)| **force != 0.0) {
            let [from, to] = [n, n + 1].map(|n| n as f64 * step / spacing);
            let lowest = ((from - REACH - first).ceil().max(0.0)) as usize;
            let highest = (((to + REACH - first).floor()) as usize).min(values.len() - 1);
            for (m, value) in values.iter_mut().enumerate().take(highest + 1).skip(lowest) {
                let place = m as f64 + first;
                *value += force * (integrated_filter(place - from) - integrated_filter(place - to));
            }
        }
        values.iter_mut().for_each(|value| *value /= impulse);
        let mut history = ForceHistory { start: first * spacing, step: spacing, values, band };
        history.trim();
        Some((history, impulse))
    }

    /// A history as a file holds it: samples [1/s] from `start` \[s\] after the onset on, a `step` \[s\]
    /// apart. `None` for numbers that are not finite, a step that is not positive, or no area.
    pub fn restored(start: f64, step: f64, values: Vec<f64>) -> Option<Self> {
        let area = values.iter().sum::<f64>() * step;
        let good = start.is_finite() && step > 0.0 && area.is_finite() && area > 0.0;
        let history = ForceHistory { start, step, values, band: 1.0 / (RATE_OVER_BAND * step) };
        (good && history.values.iter().all(|value| value.is_finite())).then_some(history)
    }

    /// Drops samples at the end that carry nothing.
    fn trim(&mut self) {
        let peak = self.values.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
        let kept = self.values.iter().rposition(|value| value.abs() > 1e-9 * peak).map_or(0, |at| at + 1);
        self.values.truncate(kept);
    }

    /// Time of the first sample after the onset \[s\].
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Distance of the samples \[s\].
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The samples [1/s].
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Highest frequency that it holds \[Hz\].
    pub fn band(&self) -> f64 {
        self.band
    }

    /// Times after the onset between which it acts \[s\].
    pub fn extent(&self) -> (f64, f64) {
        (self.start, self.start + self.values.len() as f64 * self.step)
    }

    /// S at a time after the onset [1/s], linear between samples.
    pub fn value(&self, time: f64) -> f64 {
        let place = (time - self.start) / self.step;
        if !(place >= 0.0 && place < self.values.len() as f64) {
            return 0.0;
        }
        let index = place as usize;
        let next = self.values.get(index + 1).copied().unwrap_or(0.0);
        self.values[index] + (next - self.values[index]) * (place - index as f64)
    }

    /// ∫ S(t) e^{−λt} dt from the onset.
    pub fn at_pole(&self, pole: Complex64) -> Complex64 {
        if pole.im.abs() > TAU * 1.5 * self.band {
            return Complex64::ZERO;
        }
        let turn = (-pole * self.step).exp();
        let sum = self.values.iter().rev().fold(Complex64::ZERO, |sum, value| sum * turn + value);
        sum * (-pole * self.start).exp() * self.step
    }

    /// Ŝ(ω) e^{iωμ} at ω = 0, `spacing`, 2 `spacing`, … [rad/s], seen from the time μ after the onset \[s\];
    /// 0 beyond 3/2 of the band.
    #[inline(always)]
    pub fn spectra(&self, spacing: f64, middle: f64, re: &mut [f64], im: &mut [f64]) {
        let last = TAU * 1.5 * self.band;
        let groups = re.chunks_mut(LANES).zip(im.chunks_mut(LANES));
        for (group, (re, im)) in groups.enumerate() {
            let omega: [f64; LANES] = std::array::from_fn(|lane| (group * LANES + lane) as f64 * spacing);
            if omega[0] > last {
                re.fill(0.0);
                im.fill(0.0);
                continue;
            }
            // Horner's rule in e^{−iωT}.
            let turns = omega.map(|w| (w * self.step).sin_cos());
            let (mut sum_re, mut sum_im) = ([0.0; LANES], [0.0; LANES]);
            for value in self.values.iter().rev() {
                for lane in 0..LANES {
                    let (sin, cos) = turns[lane];
                    let next = sum_re[lane] * cos + sum_im[lane] * sin + value;
                    sum_im[lane] = sum_im[lane] * cos - sum_re[lane] * sin;
                    sum_re[lane] = next;
                }
            }
            for lane in 0..re.len() {
                let (sin, cos) = (omega[lane] * (middle - self.start)).sin_cos();
                re[lane] = self.step * (sum_re[lane] * cos - sum_im[lane] * sin);
                im[lane] = self.step * (sum_re[lane] * sin + sum_im[lane] * cos);
            }
        }
    }
}

/// ∫ of the filter from −∞ to a place \[samples\].
fn integrated_filter(place: f64) -> f64 {
    /// The integral and the filter itself at every 1/64 sample.
    static TABLE: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
        let count = 2 * REACH as usize * DENSITY;
        let filter = |x: f64| {
            let window = bessel_i0(BETA * (1.0 - (x / REACH).powi(2)).max(0.0).sqrt()) / bessel_i0(BETA);
            let sinc = if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
            window * sinc
        };
        let at = |i: f64| i / DENSITY as f64 - REACH;
        let mut sum = 0.0;
        let mut table: Vec<[f64; 2]> = (0..=count)
            .map(|i| {
                let entry = [sum, filter(at(i as f64))];
                // Simpson's rule over the next interval.
                let middle = filter(at(i as f64 + 0.5));
                sum += (entry[1] + 4.0 * middle + filter(at(i as f64 + 1.0))) / (6.0 * DENSITY as f64);
                entry
            })
            .collect();
        // The gain at zero frequency is 1.
        let area = table[count][0];
        table.iter_mut().for_each(|entry| *entry = entry.map(|value| value / area));
        table
    });
    let position = (place + REACH) * DENSITY as f64;
    if position <= 0.0 {
        return 0.0;
    }
    let index = position as usize;
    let Some([[from, slope], [to, end_slope]]) = TABLE.get(index..index + 2).map(|pair| [pair[0], pair[1]])
    else {
        return 1.0;
    };
    let (p, q) = (position - index as f64, 1.0 - position + index as f64);
    let bend = (q * slope - p * end_slope) / DENSITY as f64;
    q * q * (1.0 + 2.0 * p) * from + p * p * (1.0 + 2.0 * q) * to + p * q * bend
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ŝ of the steps themselves.
    fn exact(forces: &[f64], step: f64, omega: f64) -> Complex64 {
        let sinc = if omega == 0.0 { 1.0 } else { (0.5 * omega * step).sin() / (0.5 * omega * step) };
        let sum: Complex64 = forces
            .iter()
            .enumerate()
            .map(|(n, force)| force * Complex64::cis(-omega * step * (n as f64 + 0.5)))
            .sum();
        sum * sinc / forces.iter().sum::<f64>()
    }

    #[test]
    fn the_audible_part_is_kept() {
        let band = 24e3;
        let mut worst = 0.0_f64;
        // Two hits, the second sharper, on steps finer and coarser than the grid.
        for step in [0.3e-6, 1.7e-6, 9e-6, 23e-6] {
            let count = (400e-6 / step) as usize;
            let force = |t: f64| {
                let hit = |from: f64, long: f64| (PI * ((t - from) / long).clamp(0.0, 1.0)).sin().powf(1.5);
                hit(0.0, 80e-6) + 0.4 * hit(250e-6, 60e-6)
            };
            let forces: Vec<f64> = (0..count).map(|n| 1e3 * force((n as f64 + 0.5) * step)).collect();
            let (history, impulse) = ForceHistory::of_steps(&forces, step, band).unwrap();
            assert!((impulse / (step * forces.iter().sum::<f64>()) - 1.0).abs() < 1e-12);
            let spacing = TAU * 300.0;
            let (mut re, mut im) = (vec![0.0; 96], vec![0.0; 96]);
            history.spectra(spacing, 40e-6, &mut re, &mut im);
            for k in 0..=80 {
                let omega = spacing * k as f64;
                let steps = exact(&forces, step, omega);
                let found = Complex64::new(re[k], im[k]) * Complex64::cis(-omega * 40e-6);
                let pole = history.at_pole(Complex64::new(0.0, omega));
                worst = worst.max((found - steps).norm()).max((pole - steps).norm());
            }
        }
        // Residual seen: 2.3e-6, of the window.
        assert!(worst < 4e-6, "{worst:e}");
    }

    #[test]
    fn forces_without_impulse_have_no_history() {
        assert!(ForceHistory::of_steps(&[], 1e-6, 24e3).is_none());
        assert!(ForceHistory::of_steps(&[0.0, 0.0], 1e-6, 24e3).is_none());
        assert!(ForceHistory::of_steps(&[1.0, f64::NAN], 1e-6, 24e3).is_none());
        assert!(ForceHistory::restored(0.0, 0.0, vec![1.0]).is_none());
        assert!(ForceHistory::restored(0.0, 1e-5, vec![f64::INFINITY]).is_none());
    }
}
