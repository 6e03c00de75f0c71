//! Band-limited forces as input of resonators, integrated exactly over each sample.
//!
//! A resonator of pole λ that is driven by the force g(t) steps over the interval from t_k to t_k +
//! T by
//!
//! ```text
//! w(t_k + T) = e^{λT} w(t_k) + b_k,   b_k = ∫ e^{λ(t_k + T − t)} g(t) dt
//! ```
//!
//! A contact lasts about as long as a sample. Therefore g is first limited to the band of the output by
//! [`lowpass`]. Its gain is 1 below the limit, so the ringing after the contact is unchanged, and nothing
//! aliases. On an interval of middle t_m, with u from −1 to 1, a spectrum Ĝ(ω) and the Legendre polynomials
//! P_l have
//!
//! ```text
//! g(t_m + uT/2) = Σ_l γ_l P_l(u),   γ_l = (2l+1) (1/2π) ∫ Ĝ(ω) i^l j_l(ωT/2) e^{iωt_m} dω
//! b_k = Σ_l γ_l φ_l,   φ_l = T e^{λT/2} (−1)^l i_l(λT/2)
//! ```
//!
//! The γ_l are one inverse FFT each; φ_l belongs to the resonator. Omitted terms l ≥ [`TERMS`] contain j_l of
//! both frequencies, 1e-7 at the end of the band.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_fourier::{ComplexToReal, Planner};
use num_complex::Complex64;

use crate::contact::ForceShape;
use crate::math::radial::regular;
use crate::synthesis::lowpass::{self, REACH};

/// Legendre polynomials on a sample.
pub(super) const TERMS: usize = 6;

/// A band-limited force, from sample to sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ForceSamples {
    /// g at the samples [1/s].
    pub(super) values: Vec<f64>,
    /// γ_l between each sample and the next [1/s].
    pub(super) terms: Vec<[f64; TERMS]>,
}

/// φ_l of a pole, for a sample of T \[s\].
pub(super) fn term_weights(pole: Complex64, sample_time: f64) -> [Complex64; TERMS] {
    let half = 0.5 * sample_time * pole;
    let mut bessel = Vec::with_capacity(TERMS);
    // i_l(a) = a^l u_l(−a²), where j_l(z) = z^l u_l(z²).
    regular(-half * half, TERMS - 1, &mut bessel);
    let scale = sample_time * half.exp();
    let mut power = Complex64::ONE;
    std::array::from_fn(|l| {
        let weight = scale * power * bessel[l];
        power *= -half;
        weight
    })
}

/// Computes band-limited forces for one sample rate and band.
pub(super) struct Shaper {
    rate: f64,
    /// Half-amplitude frequency of the band limit \[Hz\], and half the width of its transition.
    centre: f64,
    half_width: f64,
    planner: Planner,
    tables: BTreeMap<usize, Arc<Tables>>,
    /// Real and imaginary parts of a force before the band limit.
    unlimited: [Vec<f64>; 2],
    spectrum: Vec<Complex64>,
    bins: Vec<Complex64>,
    scratch: Vec<Complex64>,
    time: Vec<f64>,
}

/// Tables shared by all pulses of one length.
struct Tables {
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Gain of the band limit at the bins.
    gains: Vec<f64>,
    /// (2l+1) i^l j_l(ωT/2) e^{iωT/2} at the bins.
    terms: [Vec<Complex64>; TERMS],
}

impl Shaper {
    /// For a sample rate, the half-amplitude frequency of the band limit and half the width of its transition
    /// \[Hz\].
    pub(super) fn new(rate: f64, centre: f64, half_width: f64) -> Self {
        Shaper {
            rate,
            centre,
            half_width,
            planner: Planner::new(),
            tables: BTreeMap::new(),
            unlimited: Default::default(),
            spectrum: Vec::new(),
            bins: Vec::new(),
            scratch: Vec::new(),
            time: Vec::new(),
        }
    }

    /// Half-length of the band-limited impulse \[samples\].
    pub(super) fn reach(&self) -> i64 {
        (REACH as f64 * lowpass::HALF_WIDTH * self.rate / self.half_width).ceil() as i64
    }

    /// Reserves memory for pulses of up to this length \[samples\], so that computing their forces allocates
    /// nothing.
    pub(super) fn reserve(&mut self, samples: usize) {
        let lengths = std::iter::successors(Some(2), |length| Some(2 * length));
        for length in lengths.take_while(|length| *length <= samples.next_power_of_two()) {
            let tables = self.tables(length);
            self.spectrum.reserve(tables.gains.len());
            self.unlimited.iter_mut().for_each(|part| part.reserve(tables.gains.len()));
            self.transformed(&tables, None);
        }
    }

    /// The band-limited force of a pulse of unit impulse that begins at `onset` \[samples\] and lasts
    /// `duration` \[s\]; returns its first sample.
    pub(super) fn pulse(
        &mut self,
        shape: &ForceShape,
        onset: f64,
        duration: f64,
        force: &mut ForceSamples,
    ) -> i64 {
        let extent = shape.extent(duration);
        let middle = onset + 0.5 * duration * self.rate;
        let from_middle = [extent.0, extent.1].map(|t| t - 0.5 * duration);
        let spectra = |spacing: f64, re: &mut [f64], im: &mut [f64]| match shape {
            ForceShape::Profile(profile) => {
                re.iter_mut().enumerate().for_each(|(k, re)| {
                    *re = profile.centred_spectrum(spacing * k as f64, duration);
                });
                im.fill(0.0);
            }
            ForceShape::History(history) => history.spectra(spacing, 0.5 * duration, re, im),
        };
        self.force(middle, from_middle, spectra, force)
    }

    /// The band-limited force of a unit impulse at a time \[samples\], and its first sample.
    pub(super) fn impulse(&mut self, at: f64) -> (i64, ForceSamples) {
        let mut force = ForceSamples::default();
        let flat = |_: f64, re: &mut [f64], im: &mut [f64]| {
            re.fill(1.0);
            im.fill(0.0);
        };
        (self.force(at, [0.0, 0.0], flat, &mut force), force)
    }

    /// The band-limited force around a `middle` \[samples\]. It acts between two times relative to the middle
    /// \[s\]. `spectra` writes its spectrum, seen from the middle, at multiples of a spacing [rad/s].
    fn force(
        &mut self,
        middle: f64,
        [begin, end]: [f64; 2],
        spectra: impl Fn(f64, &mut [f64], &mut [f64]),
        force: &mut ForceSamples,
    ) -> i64 {
        let first = (middle + begin * self.rate).floor() as i64 - self.reach();
        let last = (middle + end * self.rate).ceil() as i64 + self.reach();
        let count = (last - first + 1) as usize;
        let length = (count + 1).next_power_of_two();
        let tables = self.tables(length);
        let spacing = std::f64::consts::TAU * self.rate / length as f64;
        let shift = (first as f64 - middle) / self.rate;
        self.spectrum.clear();
        let rotation = Complex64::cis(spacing * shift);
        let mut turn = Complex64::ONE;
        let [re, im] = &mut self.unlimited;
        re.resize(tables.gains.len(), 0.0);
        im.resize(tables.gains.len(), 0.0);
        spectra(spacing, re, im);
        for ((gain, re), im) in tables.gains.iter().zip(re).zip(im) {
            let scale = gain * self.rate / length as f64;
            self.spectrum.push(Complex64::new(*re, *im) * scale * turn);
            turn *= rotation;
        }
        force.values.clear();
        force.values.extend_from_slice(&self.transformed(&tables, None)[..count]);
        force.terms.clear();
        force.terms.resize(count, [0.0; TERMS]);
        for (l, factors) in tables.terms.iter().enumerate() {
            let column = self.transformed(&tables, Some(factors));
            force.terms.iter_mut().zip(column).for_each(|(row, value)| row[l] = *value);
        }
        first
    }

    /// Inverse transform of the spectrum times factors.
    fn transformed(&mut self, tables: &Tables, factors: Option<&Vec<Complex64>>) -> &[f64] {
        let length = tables.inverse.len();
        self.bins.clear();
        match factors {
            None => self.bins.extend_from_slice(&self.spectrum),
            Some(factors) => self.bins.extend(self.spectrum.iter().zip(factors).map(|(x, f)| x * f)),
        }
        self.bins.resize(length / 2 + 1, Complex64::ZERO);
        // The mean is real; rounding may have left an imaginary part.
        self.bins[0].im = 0.0;
        self.scratch.resize(tables.inverse.get_scratch_len(), Complex64::ZERO);
        self.time.resize(length, 0.0);
        tables
            .inverse
            .process_with_scratch(&mut self.bins, &mut self.time, &mut self.scratch)
            .expect("buffers of the plan's own lengths");
        &self.time
    }

    fn tables(&mut self, length: usize) -> Arc<Tables> {
        let (planner, spacing) = (&mut self.planner, self.rate / length as f64);
        let make = || {
            let gains = lowpass::transition(|k| (spacing * k as f64 - self.centre) / self.half_width);
            let mut terms: [Vec<Complex64>; TERMS] = Default::default();
            let mut bessel = Vec::new();
            for k in 0..gains.len() {
                let half = std::f64::consts::PI * k as f64 / length as f64;
                regular(Complex64::new(half * half, 0.0), TERMS - 1, &mut bessel);
                let mut power = Complex64::cis(half);
                for (l, column) in terms.iter_mut().enumerate() {
                    column.push((2 * l + 1) as f64 * bessel[l] * power);
                    power *= Complex64::new(0.0, half);
                }
            }
            Arc::new(Tables { inverse: planner.inverse(length), gains, terms })
        };
        Arc::clone(self.tables.entry(length).or_insert_with(make))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::ForceProfile;

    /// Steps a resonator through a force and compares its final state with the closed form at the pole.
    fn residual(rate: f64, frequency: f64, duration: f64, shape: &ForceShape) -> f64 {
        let onset = 7.3;
        let mut force = ForceSamples::default();
        let mut shaper = Shaper::new(rate, 0.45 * rate, rate / 30.0);
        let first = shaper.pulse(shape, onset, duration, &mut force);
        let pole = Complex64::new(-40.0, std::f64::consts::TAU * frequency);
        let step = (pole / rate).exp();
        let weights = term_weights(pole, 1.0 / rate);
        let state = force.terms.iter().fold(Complex64::ZERO, |w, terms| {
            step * w + terms.iter().zip(weights).map(|(g, phi)| g * phi).sum::<Complex64>()
        });
        let elapsed = (first as f64 + force.terms.len() as f64 - onset) / rate;
        let exact = (pole * elapsed).exp() * shape.at_pole(pole, duration);
        (state / exact - 1.0).norm()
    }

    #[test]
    fn what_rings_after_a_pulse_is_its_transform_at_the_pole() {
        for rate in [44_100.0, 48_000.0, 192_000.0] {
            for part in [0.001, 0.02, 0.1, 0.25, 0.35, 0.41] {
                for tau in [12e-6, 50e-6, 400e-6] {
                    for profile in [ForceProfile::Hertz, ForceProfile::HalfSine, ForceProfile::Gaussian] {
                        // Beyond the main lobe of a pulse there is too little response to compare.
                        if part * rate * tau < 1.2 {
                            let error = residual(rate, part * rate, tau, &profile.into());
                            assert!(error < 1e-6, "{rate} {part} {tau} {profile:?}: {error:e}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_transform_is_smooth_where_its_formula_is_singular() {
        let tau = 5e-5;
        let at = |f: f64| ForceProfile::HalfSine.at_pole(Complex64::new(0.0, f / tau), tau);
        let pi = std::f64::consts::PI;
        assert!((at(pi) - 0.5 * (at(pi - 1e-3) + at(pi + 1e-3))).norm() < 1e-6);
        assert!((at(pi * (1.0 + 1e-7)) - at(pi)).norm() < 1e-6);
    }
}
