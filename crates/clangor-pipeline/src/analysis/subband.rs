//! Decaying tones in a narrow band of a signal.
//!
//! The band is moved to 0 Hz, filtered and thinned out; what is left is a sum of few decaying oscillations:
//!
//! ```text
//! y[n] = Σ_m h[m] x[n₀ + nD − m] e^{−iω₀(n₀ + nD − m)/r} = Σ_k a_k z_kⁿ,   z_k = e^{(i(ω_k − ω₀) − δ_k) D/r}
//! ```
//!
//! with the rate r and a low pass h that ends at half the new rate r/D. The windows of L consecutive y span
//! the space of the vectors (1, z_k, z_k², …). A basis U of it, from the eigenvectors of Σ w wᴴ above the
//! noise, obeys U₊ = U₋ Ψ without its first and its last row, and the z_k are the eigenvalues of Ψ (ESPRIT:
//! Roy and Kailath, IEEE Trans. ASSP 37, 1989; in bands: Laroche, J. Acoust. Soc. Am. 94, 1993). The
//! amplitudes follow by least squares.
//!
//! Not for tones that change their frequency, and not for the impact itself: samples before `first` are never
//! used.

use std::f64::consts::{PI, TAU};

use faer::linalg::solvers::{Solve, SolveLstsq};
use faer::{Mat, Side};
use num_complex::Complex64;

/// Most samples of a band, and the part of them that a window has.
const MOST_SAMPLES: usize = 144;
const WINDOW: f64 = 0.4;
/// Fewest samples of a band.
const FEWEST_SAMPLES: usize = 24;
/// Length of the low pass in periods of the half width; stops 74 dB from three half widths on (Blackman).
const FILTER: f64 = 2.75;
/// Least eigenvalue of a tone over the median of the lower half, which is noise, and over the largest.
const ABOVE_NOISE: f64 = 30.0;
const LEAST: f64 = 1e-9;
/// Most tones of a band.
const MOST_TONES: usize = 12;

/// A band of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Band {
    /// Its middle \[Hz\].
    pub(super) centre: f64,
    /// Tones within this distance of the middle are found \[Hz\].
    pub(super) half_width: f64,
}

/// A tone x(t) = a e^{−δt} cos(ωt + φ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BandTone {
    /// \[Hz\].
    pub(super) frequency: f64,
    /// δ [1/s].
    pub(super) decay: f64,
    /// a at the first sample that was asked for, in the unit of the samples.
    pub(super) amplitude: f64,
    /// Energy over that of what the tones do not explain.
    pub(super) clarity: f64,
}

/// The tones of a band, and what limits them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct BandTones {
    /// By frequency.
    pub(super) tones: Vec<BandTone>,
    /// Time over which they were observed \[s\].
    pub(super) duration: f64,
    /// Time that is left for a narrower band \[s\].
    pub(super) available: f64,
}

impl Band {
    /// Time between the first sample of the signal and the first of the band \[s\]: half the filter.
    pub(super) fn delay(&self) -> f64 {
        0.5 * FILTER / self.half_width
    }

    /// The tones from sample `first` of a signal of `rate` \[Hz\] on; none where the signal is too short.
    pub(super) fn tones(&self, samples: &[f64], rate: f64, first: usize) -> BandTones {
        let thinned = ((rate / (4.0 * self.half_width)) as usize).max(1);
        let half = (self.delay() * rate) as usize;
        let available = samples.len().saturating_sub(first + 2 * half);
        let count = (available / thinned).min(MOST_SAMPLES);
        let step = thinned as f64 / rate;
        let empty = BandTones {
            duration: step * count as f64,
            available: available as f64 / rate,
            ..BandTones::default()
        };
        if count < FEWEST_SAMPLES {
            return empty;
        }
        let signal = self.thin_out(&samples[first..], rate, (half, thinned, count));
        let poles = poles(&signal);
        let (amplitudes, rest) = amplitudes(&signal, &poles);
        let inside = |tone: &BandTone| (tone.frequency - self.centre).abs() <= self.half_width;
        let mut tones: Vec<BandTone> = poles
            .iter()
            .zip(amplitudes)
            .map(|(z, a)| {
                let (decay, turn) = (-z.norm().ln() / step, z.arg() / (TAU * step));
                let energy: f64 = (0..count).map(|n| (a * z.powi(n as i32)).norm_sqr()).sum();
                BandTone {
                    frequency: self.centre + turn,
                    decay,
                    // Each half of a real tone has half the amplitude; the filter delays the first sample.
                    amplitude: 2.0 * a.norm() * (decay * half as f64 / rate).exp(),
                    clarity: energy / rest.max(f64::MIN_POSITIVE),
                }
            })
            .filter(inside)
            .collect();
        tones.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        BandTones { tones, ..empty }
    }

    /// The band at 0 Hz, filtered, and one sample of `thinned` kept.
    fn thin_out(&self, x: &[f64], rate: f64, sizes: (usize, usize, usize)) -> Vec<Complex64> {
        let (half, thinned, count) = sizes;
        let cutoff = 2.0 * self.half_width / rate;
        let mut filter: Vec<f64> = (0..=2 * half)
            .map(|m| {
                let at = m as f64 - half as f64;
                let sinc = if at == 0.0 { 2.0 * cutoff } else { (TAU * cutoff * at).sin() / (PI * at) };
                let phase = PI * m as f64 / half.max(1) as f64;
                sinc * (0.42 - 0.5 * phase.cos() + 0.08 * (2.0 * phase).cos())
            })
            .collect();
        let sum: f64 = filter.iter().sum();
        filter.iter_mut().for_each(|h| *h /= sum);
        let turn = TAU * self.centre / rate;
        // The phase of the filter's own oscillation; that of the sample n thinned follows once for each.
        let taps: Vec<Complex64> =
            filter.iter().enumerate().map(|(m, h)| h * Complex64::cis(-turn * m as f64)).collect();
        (0..count)
            .map(|n| {
                let start = n * thinned;
                let sum: Complex64 = taps.iter().zip(&x[start..]).map(|(h, x)| h * x).sum();
                sum * Complex64::cis(-(turn * start as f64) % TAU)
            })
            .collect()
    }
}

/// The decaying z_k of a signal.
fn poles(signal: &[Complex64]) -> Vec<Complex64> {
    let length = ((WINDOW * signal.len() as f64) as usize).max(2);
    let covariance = Mat::<Complex64>::from_fn(length, length, |i, j| {
        (0..=signal.len() - length).map(|n| signal[n + i] * signal[n + j].conj()).sum()
    });
    let Ok(eigen) = covariance.self_adjoint_eigen(Side::Lower) else { return Vec::new() };
    let values = eigen.S().column_vector();
    let value = |i: usize| values[i].re;
    // Ascending; the lower half is noise, or the leakage of the filter.
    let noise = value(length / 4).abs();
    let least = (ABOVE_NOISE * noise).max(LEAST * value(length - 1));
    let rank = (length / 2..length).filter(|i| value(*i) > least).count().min(MOST_TONES);
    if rank == 0 {
        return Vec::new();
    }
    let basis = eigen.U().subcols(length - rank, rank);
    let (without_last, without_first) = (basis.subrows(0, length - 1), basis.subrows(1, length - 1));
    let square = without_last.adjoint() * without_last;
    let shift = square.partial_piv_lu().solve(without_last.adjoint() * without_first);
    let Ok(values) = shift.eigenvalues() else { return Vec::new() };
    let mut poles: Vec<Complex64> =
        values.into_iter().filter(|z| z.norm() < 1.0 && z.norm() > 1e-3).collect();
    poles.sort_by(|a, b| a.arg().total_cmp(&b.arg()).then(a.norm().total_cmp(&b.norm())));
    poles
}

/// Amplitudes of the poles at the first sample, and the energy of what they leave.
fn amplitudes(signal: &[Complex64], poles: &[Complex64]) -> (Vec<Complex64>, f64) {
    if poles.is_empty() {
        return (Vec::new(), signal.iter().map(Complex64::norm_sqr).sum());
    }
    let powers = Mat::from_fn(signal.len(), poles.len(), |n, k| poles[k].powi(n as i32));
    let right = Mat::from_fn(signal.len(), 1, |n, _| signal[n]);
    let found = powers.qr().solve_lstsq(&right);
    let rest = &right - &powers * &found;
    let energy = (0..signal.len()).map(|n| rest[(n, 0)].norm_sqr()).sum();
    ((0..poles.len()).map(|k| found[(k, 0)]).collect(), energy)
}
