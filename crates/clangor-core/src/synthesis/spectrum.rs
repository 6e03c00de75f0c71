//! Spectra of clicks on an FFT grid.
//!
//! P(ω_k) = (real transfer terms) · (force spectrum) · e^{−iω_k T}: the first two are rational in ω apart
//! from one cosine, the last is a rotation. Both advance by a constant angle per bin, so neither needs a sine
//! or cosine per bin; several bins advance together, which the compiler turns into vector instructions. The
//! transfer terms here are those of spheres; those of fields are [`field_spectrum`](super::field_spectrum).

use pulp::Simd;
use realfft::ComplexToReal;
use realfft::num_complex::Complex;

use super::field_spectrum::{FieldPlayer, FieldTransfer};
use super::ground::spectrum::GroundTransfer;
use super::{ground, lowpass};
use crate::contact::force_profile::ForceProfile;
use crate::propagation::PathLoss;
use crate::reference::slab::SlabTransfer;
use crate::sound_model::acceleration::sphere_radiation::SphereTransfer;

/// Bins of a field that advance together.
pub(crate) const LANES: usize = 8;
/// Bins of a sphere that advance together.
const SPHERE_LANES: usize = 4;

/// One wave that reaches a receiver: direct, or from the mirrored source.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wave {
    /// What sounds.
    pub(crate) transfer: Transfer,
    /// How the force runs.
    pub(crate) profile: ForceProfile,
    /// Duration τ of the force \[s\].
    pub(crate) duration: f64,
    /// When the middle of the collision is heard \[s\].
    pub(crate) middle: f64,
}

/// From the profile of the force to the pressure, but for the delay.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Transfer {
    /// Of a sphere, times the velocity change; its delay is not used.
    Sphere(SphereTransfer),
    /// Of a field.
    Field(FieldTransfer),
    /// Of the ground, with its delays.
    Ground(GroundTransfer),
    /// Of a slab.
    Slab(SlabTransfer),
}

/// The frequencies of one block length with their gains, padded to whole lanes.
pub(crate) struct Grid {
    /// Distance of the bins \[Hz\].
    pub(crate) spacing_hz: f64,
    /// Bins that are not zero.
    pub(crate) bins: usize,
    /// Angular frequencies [rad/s].
    pub(crate) omega: Vec<f64>,
    gain: Vec<f64>,
}

impl Grid {
    /// The grid of a block of `length` samples at `rate` \[Hz\], with all sound up to `max_frequency` \[Hz\].
    pub(crate) fn new(length: usize, rate: f64, max_frequency: Option<f64>) -> Self {
        let limit = max_frequency.map_or(lowpass::CENTRE, |f| f / rate + lowpass::HALF_WIDTH);
        let mut gain = lowpass::gains(length, limit.min(lowpass::CENTRE));
        let bins = gain.len();
        gain.resize(bins.next_multiple_of(LANES), 0.0);
        let spacing_hz = rate / length as f64;
        let omega = (0..gain.len()).map(|k| std::f64::consts::TAU * spacing_hz * k as f64).collect();
        Grid { spacing_hz, bins, omega, gain }
    }

    /// Gain of the band limit at a bin.
    pub(crate) fn gain(&self, bin: usize) -> f64 {
        self.gain[bin]
    }

    /// ∫ p² dt [Pa² s] of a click whose spectrum (before the band limit) is given.
    #[inline(always)]
    pub(crate) fn energy(&self, spectrum: &Spectrum) -> f64 {
        let mut sum = [0.0; LANES];
        let re = spectrum.re.as_chunks::<LANES>().0;
        let im = spectrum.im.as_chunks::<LANES>().0;
        let gain = self.gain.as_chunks::<LANES>().0;
        for ((re, im), gain) in re.iter().zip(im).zip(gain) {
            for lane in 0..LANES {
                sum[lane] += (re[lane] * re[lane] + im[lane] * im[lane]) * (gain[lane] * gain[lane]);
            }
        }
        // Negative frequencies mirror the positive ones; zero frequency stands alone.
        let zero = spectrum.re[0] * spectrum.re[0];
        self.spacing_hz * (2.0 * sum.iter().sum::<f64>() - zero)
    }
}

/// What is lost on the way at each frequency of a [`Grid`].
pub(crate) struct Losses {
    loss: PathLoss,
    /// What walls leave, and the attenuation in air [1/m].
    bins: Vec<(f64, f64)>,
}

impl Losses {
    /// `None` where nothing is lost.
    pub(crate) fn on(grid: &Grid, loss: PathLoss) -> Option<Self> {
        let at = |omega: &f64| loss.at(omega / std::f64::consts::TAU);
        (!loss.is_none()).then(|| Losses { loss, bins: grid.omega.iter().map(at).collect() })
    }

    /// Takes it from a wave that has come `distance` \[m\].
    pub(crate) fn apply(&self, spectrum: &mut Spectrum, distance: f64) {
        for ((re, im), bin) in spectrum.re.iter_mut().zip(&mut spectrum.im).zip(&self.bins) {
            let gain = self.loss.gain(*bin, distance);
            *re *= gain;
            *im *= gain;
        }
    }
}

/// A spectrum [Pa s] on a [`Grid`], before the band limit.
#[derive(Debug, Default)]
pub(crate) struct Spectrum {
    pub(crate) re: Vec<f64>,
    pub(crate) im: Vec<f64>,
}

impl Spectrum {
    /// Makes it zero on this grid.
    pub(crate) fn clear(&mut self, grid: &Grid) {
        for part in [&mut self.re, &mut self.im] {
            part.clear();
            part.resize(grid.omega.len(), 0.0);
        }
    }

    /// Adds another spectrum on the same grid.
    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Spectrum) {
        self.re.iter_mut().zip(&other.re).for_each(|(a, b)| *a += b);
        self.im.iter_mut().zip(&other.im).for_each(|(a, b)| *a += b);
    }

    /// The samples \[Pa\] that have this spectrum within the band; `bins` and `scratch` are memory.
    pub(crate) fn transform(
        &self,
        grid: &Grid,
        inverse: &dyn ComplexToReal<f64>,
        (bins, scratch): (&mut Vec<Complex<f64>>, &mut Vec<Complex<f64>>),
        samples: &mut [f64],
    ) {
        bins.clear();
        bins.extend((0..grid.bins).map(|k| {
            let gain = grid.gain(k) * grid.spacing_hz;
            Complex::new(gain * self.re[k], gain * self.im[k])
        }));
        bins.resize(inverse.complex_len(), Complex::ZERO);
        // The pressure is real, so its mean is; rounding may have left a negative zero.
        bins[0].im = 0.0;
        scratch.resize(inverse.get_scratch_len(), Complex::ZERO);
        inverse.process_with_scratch(bins, samples, scratch).expect("buffers of the plan's own lengths");
    }

    /// Adds a wave, with times counted from `origin` \[s\].
    #[inline(always)]
    pub(crate) fn add_wave<S: Simd>(
        &mut self,
        simd: S,
        grid: &Grid,
        wave: &Wave,
        origin: f64,
        player: &mut FieldPlayer,
    ) {
        let transfer = match &wave.transfer {
            Transfer::Sphere(transfer) => transfer,
            Transfer::Field(transfer) => return player.add(simd, self, grid, wave, transfer, origin),
            Transfer::Ground(transfer) => return ground::spectrum::add(self, grid, wave, transfer, origin),
            Transfer::Slab(transfer) => {
                return crate::reference::slab::add(self, grid, wave, transfer, origin);
            }
        };
        let step = std::f64::consts::TAU * grid.spacing_hz;
        let delay = Rotation::new(-step * (wave.middle - origin));
        match wave.profile {
            ForceProfile::HalfSine => self.add_half_sine(grid, wave, transfer, delay),
            ForceProfile::Gaussian => {
                self.add_profile(grid, transfer, delay, |k| {
                    wave.profile.centred_spectrum(grid.omega[k], wave.duration)
                });
            }
        }
    }

    /// Any profile, its spectrum given bin by bin.
    #[inline(always)]
    fn add_profile(
        &mut self,
        grid: &Grid,
        transfer: &SphereTransfer,
        mut delay: Rotation<SPHERE_LANES>,
        profile: impl Fn(usize) -> f64,
    ) {
        for first in (0..grid.omega.len()).step_by(SPHERE_LANES) {
            for lane in 0..SPHERE_LANES {
                let k = first + lane;
                let (re, im) = transfer.undelayed(grid.omega[k]);
                let amplitude = profile(k);
                self.re[k] += amplitude * (re * delay.cos[lane] - im * delay.sin[lane]);
                self.im[k] += amplitude * (re * delay.sin[lane] + im * delay.cos[lane]);
            }
            delay.advance();
        }
    }

    /// The half-sine, its cosine by rotation and its denominator multiplied into that of the transfer, so
    /// that a bin costs one division.
    #[inline(always)]
    fn add_half_sine(
        &mut self,
        grid: &Grid,
        wave: &Wave,
        transfer: &SphereTransfer,
        mut delay: Rotation<SPHERE_LANES>,
    ) {
        let step = std::f64::consts::TAU * grid.spacing_hz;
        let mut half_angle = Rotation::<SPHERE_LANES>::new(0.5 * step * wave.duration);
        let pole = std::f64::consts::PI / wave.duration;
        let inverse_pole_square = 1.0 / (pole * pole);
        let SphereTransfer { real: [a0, a1], imaginary: [b0, b1], denominator: [d0, d1], .. } = *transfer;

        // The bin next to ω = π/τ, where cos(ωτ/2) / (1 − (ωτ/π)²) is 0/0, is computed by the formula that
        // knows.
        let singular = (pole / step).round();
        let singular = (singular < grid.omega.len() as f64).then_some(singular as usize);
        let kept = singular.map(|k| (self.re[k], self.im[k]));

        let omega = grid.omega.as_chunks::<SPHERE_LANES>().0;
        let re_out = self.re.as_chunks_mut::<SPHERE_LANES>().0;
        let im_out = self.im.as_chunks_mut::<SPHERE_LANES>().0;
        for ((omega, re_out), im_out) in omega.iter().zip(re_out).zip(im_out) {
            // Sums first, stores after: only then does the compiler see that the lanes are independent.
            let (mut re_sum, mut im_sum) = (*re_out, *im_out);
            for lane in 0..SPHERE_LANES {
                let w = omega[lane];
                let square = w * w;
                let denominator = (1.0 - square * inverse_pole_square) * (d0 + d1 * square * square);
                let amplitude = half_angle.cos[lane] / denominator;
                let re = amplitude * (a0 + a1 * square);
                let im = amplitude * w * (b0 + b1 * square);
                re_sum[lane] += re * delay.cos[lane] - im * delay.sin[lane];
                im_sum[lane] += re * delay.sin[lane] + im * delay.cos[lane];
            }
            (*re_out, *im_out) = (re_sum, im_sum);
            delay.advance();
            half_angle.advance();
        }

        if let (Some(k), Some((re_before, im_before))) = (singular, kept) {
            let amplitude = wave.profile.centred_spectrum(grid.omega[k], wave.duration);
            let (re, im) = transfer.undelayed(grid.omega[k]);
            let (sin, cos) = (delay.angle * k as f64).sin_cos();
            self.re[k] = re_before + amplitude * (re * cos - im * sin);
            self.im[k] = im_before + amplitude * (re * sin + im * cos);
        }
    }
}

/// e^{i k angle} for N consecutive k, advanced by a multiplication.
pub(crate) struct Rotation<const N: usize> {
    angle: f64,
    pub(crate) cos: [f64; N],
    pub(crate) sin: [f64; N],
    step: (f64, f64),
}

impl<const N: usize> Rotation<N> {
    #[inline(always)]
    pub(crate) fn new(angle: f64) -> Self {
        let (mut cos, mut sin) = ([0.0; N], [0.0; N]);
        let (s1, c1) = angle.sin_cos();
        let (mut c, mut s) = (1.0, 0.0);
        for lane in 0..N {
            (cos[lane], sin[lane]) = (c, s);
            (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
        }
        let (s, c) = (N as f64 * angle).sin_cos();
        Rotation { angle, cos, sin, step: (c, s) }
    }

    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        let (c, s) = self.step;
        let (cos, sin) = (self.cos, self.sin);
        for lane in 0..N {
            self.cos[lane] = cos[lane] * c - sin[lane] * s;
            self.sin[lane] = cos[lane] * s + sin[lane] * c;
        }
    }
}
