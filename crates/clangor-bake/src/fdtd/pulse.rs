//! The acceleration that drives a run: a Gaussian, whose spectrum ends with the band.
//!
//! Spectra are sums over the steps of the run, so the step only has to resolve the band.

use num_complex::Complex64;

use super::lattice::COURANT;

/// Width times highest wavenumber: the spectrum has fallen by 20 dB at the end of the band, by 80 dB one
/// octave on.
const WIDTH: f64 = 2.2;
/// Widths from the first step to the middle, and from there to the last.
const HALF_LENGTH: f64 = 5.5;

/// a(nΔt).
#[derive(Clone, Debug)]
pub(super) struct Pulse {
    /// Values at the steps; zero afterwards.
    pub(super) values: Vec<f64>,
}

impl Pulse {
    /// A pulse for waves of up to `phase` per step.
    pub(super) fn new(phase: f64) -> Self {
        let width = WIDTH / phase;
        let half = (HALF_LENGTH * width).ceil();
        let values = (0..=2 * half as usize).map(|n| (-0.5 * ((n as f64 - half) / width).powi(2)).exp());
        Pulse { values: values.collect() }
    }

    /// a and a'' at a step, time in h/c.
    pub(super) fn at(&self, step: usize) -> [f32; 2] {
        let value = |n: usize| self.values.get(n).copied().unwrap_or(0.0);
        let before = if step == 0 { 0.0 } else { value(step - 1) };
        let bend = value(step + 1) - 2.0 * value(step) + before;
        [value(step) as f32, (bend / (COURANT * COURANT)) as f32]
    }

    /// Σ a(nΔt) e^{−iφn}.
    pub(super) fn spectrum(&self, phase: Complex64) -> Complex64 {
        self.values.iter().enumerate().map(|(n, x)| x * (-Complex64::I * phase * n as f64).exp()).sum()
    }
}
