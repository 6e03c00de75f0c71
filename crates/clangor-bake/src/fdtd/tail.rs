//! Continuation of signals that have not decayed when a run ends: a sum of decaying oscillations.
//!
//! After the pulse, when the direct waves have passed, every recorded signal is a sum over the resonances of
//! the air around the body, the same for all signals apart from their amplitudes:
//!
//! ```text
//! x_c[n] = Σ_j a_cj z_jⁿ,     n = n₀ … N − 1
//! ```
//!
//! The windows of L consecutive samples, of all signals, span the same space as the vectors (1, z_j, z_j²,
//! …). A basis U of it, from the eigenvectors of Σ w wᵀ whose eigenvalues rise above the rounding of the run,
//! obeys U₊ = U₋ Ψ without its first and its last row, and the z_j are the eigenvalues of Ψ (ESPRIT: Roy and
//! Kailath, IEEE Trans. ASSP 37, 1989). The amplitudes follow by least squares, and the rest of the spectrum
//! in closed form:
//!
//! ```text
//! Σ_{n ≥ N} x_c[n] e^{−iφn} = e^{−iφN} Σ_j a_cj z_j^N / (1 − z_j e^{−iφ})
//! ```
//!
//! Not for resonances that overlap within 1/(length of the run) and differ in shape by less than the noise.

use faer::linalg::solvers::{Solve, SolveLstsq};
use faer::{Mat, Side};
use num_complex::Complex64;

/// Samples needed for a fit; shorter signals have none.
const FEWEST: usize = 30;
/// Samples of the longest window, and those used of the longest signal.
const LONGEST_WINDOW: usize = 500;
const MOST_SAMPLES: usize = 2 * LONGEST_WINDOW;
/// Least ratio of the eigenvalue of a resonance to those of the noise.
const ABOVE_NOISE: f64 = 30.0;
/// Least eigenvalue of a resonance, relative to the largest.
const LEAST: f64 = 1e-13;
/// Signals below this fraction of the total energy are not used to find poles.
const SILENT: f64 = 1e-12;
/// Remainder after the samples above which a slow oscillation counts as drift.
const DRIFT: f64 = 0.5;

/// The continuation of the signals of all motions.
#[derive(Clone, Debug, Default)]
pub(super) struct Tail {
    /// First sample that is not recorded, N.
    start: usize,
    /// z_j, one of each conjugate pair.
    poles: Vec<Complex64>,
    /// Of each motion, the amplitudes at N of every signal, pole after pole: x[n] = Re Σ a z^{n−N}.
    amplitudes: Vec<Vec<Complex64>>,
}

impl Tail {
    /// Continues signals in free decay from sample `first` on. Each motion has its samples one after the
    /// other, each with all `channels`; `weights` bring motions to the same units.
    pub(super) fn fit(signals: &[Vec<f64>], channels: usize, first: usize, weights: &[f64]) -> Self {
        let start = signals.first().map_or(0, |s| s.len() / channels);
        let first = first.max(start.saturating_sub(MOST_SAMPLES));
        let nothing = Tail { start, ..Tail::default() };
        if start < first + FEWEST {
            return nothing;
        }
        let rows: Vec<Vec<f64>> = signals
            .iter()
            .flat_map(|signal| (0..channels).map(move |c| column(&signal[first * channels..], channels, c)))
            .collect();
        let scales = weights.iter().flat_map(|w| std::iter::repeat_n(*w, channels));
        // Many signals compensate for few windows of each; the length limits the number of resonances.
        let length = (2 * (start - first) / 3).min(LONGEST_WINDOW);
        let poles = find_poles(&windows(&rows, scales, length), start - first);
        if poles.is_empty() {
            return nothing;
        }
        let amplitudes = amplitudes(&rows, &poles);
        let amplitudes = amplitudes
            .chunks(channels)
            .map(|motion| {
                (0..poles.len()).flat_map(|j| motion.iter().map(move |a: &Vec<Complex64>| a[j])).collect()
            })
            .collect();
        Tail { start, poles, amplitudes }
    }

    /// z_j of the resonances, one of each conjugate pair.
    pub(super) fn poles(&self) -> &[Complex64] {
        &self.poles
    }

    /// Adds Σ_{n ≥ N} x[n] e^{−iφn} of each signal of a motion to `sums`; φ may have a negative imaginary
    /// part.
    pub(super) fn add_spectrum(&self, motion: usize, phase: Complex64, sums: &mut [Complex64]) {
        let Some(amplitudes) = self.amplitudes.get(motion) else { return };
        let turn = (-Complex64::I * phase).exp();
        let delay = 0.5 * (-Complex64::I * phase * self.start as f64).exp();
        for (z, of_pole) in self.poles.iter().zip(amplitudes.chunks(amplitudes.len() / self.poles.len())) {
            let (direct, mirrored) = (delay / (1.0 - z * turn), delay / (1.0 - z.conj() * turn));
            for (sum, a) in sums.iter_mut().zip(of_pole) {
                *sum += a * direct + a.conj() * mirrored;
            }
        }
    }
}

/// One signal of interleaved ones.
fn column(signals: &[f64], channels: usize, channel: usize) -> Vec<f64> {
    signals.iter().skip(channel).step_by(channels).copied().collect()
}

/// Σ w wᵀ over all windows w of a length, of all signals times their scales.
fn windows(signals: &[Vec<f64>], scales: impl Iterator<Item = f64>, length: usize) -> Mat<f64> {
    let energy = |x: &[f64], scale: f64| scale * scale * x.iter().map(|v| v * v).sum::<f64>();
    let scaled: Vec<(&Vec<f64>, f64)> = signals.iter().zip(scales).collect();
    let total: f64 = scaled.iter().map(|(x, s)| energy(x, *s)).sum();
    let mut sum = Mat::<f64>::zeros(length, length);
    let mut diagonal = vec![0.0; length];
    for (x, scale) in scaled {
        if energy(x, scale) <= SILENT * total {
            continue;
        }
        let square = scale * scale;
        let last = x.len() - length;
        for b in 0..length {
            diagonal[b] = square * (0..=last).map(|n| x[n] * x[n + b]).sum::<f64>();
        }
        // Each diagonal from its first element: the next subtracts one product and adds one.
        for (b, start) in diagonal.iter().enumerate() {
            let mut value = *start;
            for a in 0..length - b {
                sum[(a + b, a)] += value;
                if a + b + 1 < length {
                    value += square * (x[last + 1 + a] * x[last + 1 + a + b] - x[a] * x[a + b]);
                }
            }
        }
    }
    sum
}

/// The decaying z_j of the windows, one of each conjugate pair, observed over `samples`.
fn find_poles(windows: &Mat<f64>, samples: usize) -> Vec<Complex64> {
    let length = windows.nrows();
    let Ok(eigen) = windows.self_adjoint_eigen(Side::Lower) else { return Vec::new() };
    let values = eigen.S().column_vector();
    // The smallest eigenvalues are noise. A run with more resonances than that is too short.
    let noise = values[length / 8].abs();
    let least = (ABOVE_NOISE * noise).max(LEAST * values[length - 1]);
    let rank = (length / 8..length).filter(|i| values[*i] > least).count();
    if rank == 0 {
        return Vec::new();
    }
    let basis = eigen.U().subcols(length - rank, rank);
    let (without_last, without_first) = (basis.subrows(0, length - 1), basis.subrows(1, length - 1));
    let square = without_last.transpose() * without_last;
    let shift = square.partial_piv_lu().solve(without_last.transpose() * without_first);
    let Ok(values) = shift.eigenvalues() else { return Vec::new() };
    let decays = |z: &Complex64| z.norm() < 1.0;
    // Less than half a turn within the run, and hardly decaying: reflections of the absorbing layer, and
    // rounding.
    let is_drift = |z: &Complex64| {
        z.arg() * (samples as f64) < std::f64::consts::PI && z.norm().powi(samples as i32) > DRIFT
    };
    let mut poles: Vec<Complex64> = values.into_iter().filter(|z| z.im >= 0.0).collect();
    poles.retain(|z| decays(z) && !is_drift(z) && z.norm() > 0.0);
    poles.sort_by(|a, b| a.arg().total_cmp(&b.arg()).then(a.norm().total_cmp(&b.norm())));
    poles
}

/// Amplitudes of each signal at the sample after the last, by least squares.
fn amplitudes(signals: &[Vec<f64>], poles: &[Complex64]) -> Vec<Vec<Complex64>> {
    let samples = signals[0].len();
    // Powers of the poles.
    let powers: Vec<Vec<Complex64>> = poles
        .iter()
        .map(|z| std::iter::successors(Some(Complex64::ONE), |p| Some(p * z)).take(samples + 1).collect())
        .collect();
    // x = Re Σ a z^n has the columns Re z^n and −Im z^n. The latter vanishes if z is real.
    let columns: Vec<(usize, bool)> = poles
        .iter()
        .enumerate()
        .flat_map(|(j, z)| [(j, false), (j, true)].into_iter().take(if z.im == 0.0 { 1 } else { 2 }))
        .collect();
    let matrix = Mat::from_fn(samples, columns.len(), |n, c| {
        let (j, imaginary) = columns[c];
        if imaginary { -powers[j][n].im } else { powers[j][n].re }
    });
    let right = Mat::from_fn(samples, signals.len(), |n, c| signals[c][n]);
    // Least squares by QR, one right-hand side per signal.
    let solution = matrix.qr().solve_lstsq(right);
    (0..signals.len())
        .map(|signal| {
            let mut found = vec![Complex64::ZERO; poles.len()];
            for (c, (j, imaginary)) in columns.iter().enumerate() {
                let value = solution[(c, signal)];
                if *imaginary {
                    found[*j].im = value;
                } else {
                    found[*j].re = value;
                }
            }
            // Shift the amplitudes to the end of the record.
            found.iter().zip(&powers).map(|(a, p)| a * p[samples]).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// |z|, arg z.
    const POLES: [(f64, f64); 5] = [(0.999, 0.3), (0.996, 0.33), (0.99, 0.9), (0.97, 1.3), (0.9, 0.5)];
    const CHANNELS: usize = 7;

    fn pole(j: usize) -> Complex64 {
        Complex64::from_polar(POLES[j].0, POLES[j].1)
    }

    /// Amplitude of a pole in a channel; motion 1 excites the second pole only.
    fn amplitude(motion: usize, channel: usize, j: usize) -> Complex64 {
        if motion == 1 && j != 1 {
            return Complex64::ZERO;
        }
        Complex64::from_polar(1.0 / (1 + channel) as f64, (3 * channel + 5 * j) as f64)
    }

    /// Pseudo-rounding of relative size 1: bits of a hash.
    fn noise(n: usize, part: f64) -> f64 {
        let mut x = (n as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        part * ((x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    }

    fn signals(samples: usize, rounding: f64) -> Vec<Vec<f64>> {
        let value = |motion: usize, n: usize, c: usize| -> f64 {
            (0..POLES.len()).map(|j| (amplitude(motion, c, j) * pole(j).powi(n as i32)).re).sum()
        };
        (0..2)
            .map(|motion| {
                let at =
                    |i: usize| value(motion, i / CHANNELS, i % CHANNELS) + noise(i * (motion + 1), rounding);
                (0..samples * CHANNELS).map(at).collect()
            })
            .collect()
    }

    /// Largest error of the spectra of all signals near the poles, relative to the spectrum there.
    fn worst(samples: usize, first: usize, rounding: f64) -> f64 {
        let signals = signals(samples, rounding);
        let tail = Tail::fit(&signals, CHANNELS, first, &[1.0, 1.0]);
        let mut worst = 0.0_f64;
        for phase in [0.0, 0.2, 0.3, 0.31, 0.33, 0.5, 0.9, 1.3, 2.5].map(Complex64::from) {
            for (motion, signal) in signals.iter().enumerate() {
                let turn = |n: usize| (-Complex64::I * phase * n as f64).exp();
                let mut sums = vec![Complex64::ZERO; CHANNELS];
                for (n, sample) in signal.chunks(CHANNELS).enumerate() {
                    sums.iter_mut().zip(sample).for_each(|(s, x)| *s += x * turn(n));
                }
                tail.add_spectrum(motion, phase, &mut sums);
                for (c, sum) in sums.iter().enumerate() {
                    let exact: Complex64 = (0..POLES.len())
                        .map(|j| {
                            let (a, z) = (amplitude(motion, c, j), pole(j));
                            0.5 * (a / (1.0 - z * turn(1)) + a.conj() / (1.0 - z.conj() * turn(1)))
                        })
                        .sum();
                    worst = worst.max((sum - exact).norm() / (1.0 + exact.norm()));
                }
            }
        }
        worst
    }

    #[test]
    fn damped_oscillations_are_continued_exactly() {
        let error = worst(240, 40, 0.0);
        // Residual seen: 3e-13.
        assert!(error < 1e-9, "{error}");
    }

    #[test]
    fn rounding_hurts_no_more_than_it_must() {
        for (samples, rounding, most) in [(240, 1e-6, 1e-4), (400, 1e-4, 1e-2)] {
            let error = worst(samples, 40, rounding);
            // Residuals seen: 2.4e-5, 2.3e-3.
            assert!(error < most, "{samples} {rounding}: {error}");
        }
    }

    #[test]
    fn poles_are_found_and_no_others() {
        let signals = signals(300, 1e-6);
        let tail = Tail::fit(&signals, CHANNELS, 0, &[1.0, 1.0]);
        assert_eq!(tail.poles().len(), POLES.len(), "{:?}", tail.poles());
        for j in 0..POLES.len() {
            let nearest = tail.poles().iter().map(|z| (z - pole(j)).norm()).fold(1.0, f64::min);
            // Residuals seen: 8e-10 to 1.1e-7.
            assert!(nearest < 1e-6, "{j}: {nearest}");
        }
    }

    #[test]
    fn nothing_and_noise_have_no_tail() {
        for signal in [vec![0.0; 600 * CHANNELS], (0..600 * CHANNELS).map(|n| noise(n, 1e-7)).collect()] {
            let tail = Tail::fit(&[signal.clone(), signal], CHANNELS, 50, &[1.0, 1.0]);
            assert!(tail.poles().is_empty(), "{:?}", tail.poles());
        }
        assert!(Tail::fit(&[vec![1.0; 20]], 1, 0, &[1.0]).poles().is_empty());
    }
}
