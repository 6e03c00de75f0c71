//! Spectra of sound pressure on an FFT grid, and the operations that all sources need.
//!
//! P(ω_k) = (transfer) · (force spectrum) · gain · e^{−iω_k T}. The gain is that of the band limit
//! ([`lowpass`]), the delay a [`Rotation`] that advances by a constant angle per bin, so that no bin needs a
//! sine or cosine; [`LANES`] bins advance together, which the compiler turns into vector instructions. The
//! transfers are those of [`wave`](super::wave).

use clangor_fourier::ComplexToReal;
use num_complex::Complex;

use super::lowpass;
use crate::contact::force_profile::ForceProfile;
use crate::propagation::PathLoss;

/// Bins that advance together.
pub(crate) const LANES: usize = 8;

/// The spectrum of a force of unit impulse, seen from its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ForceSpectrum<'a> {
    /// A closed form, which is real.
    Profile(ForceProfile),
    /// Values at the bins of the grid.
    Bins {
        /// Real parts.
        re: &'a [f64],
        /// Imaginary parts.
        im: &'a [f64],
    },
}

/// The force of a wave as it arrives in a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ArrivingForce<'a> {
    /// Its spectrum.
    pub(crate) spectrum: ForceSpectrum<'a>,
    /// Duration τ of the force \[s\].
    pub(crate) duration: f64,
    /// Arrival time of its middle, from the first sample of the block \[s\]. Where the transfer contains the
    /// delay: the time of its middle at the source.
    pub(crate) middle: f64,
}

impl ArrivingForce<'_> {
    /// Real and imaginary part of the spectrum, seen from the middle, at a bin of this ω [rad/s].
    #[inline(always)]
    pub(crate) fn at(&self, bin: usize, omega: f64) -> (f64, f64) {
        match self.spectrum {
            ForceSpectrum::Profile(profile) => (profile.centred_spectrum(omega, self.duration), 0.0),
            ForceSpectrum::Bins { re, im } => (re[bin], im[bin]),
        }
    }

    /// Whether it is a half-sine, whose spectrum is rational but for a cosine.
    pub(crate) fn is_half_sine(&self) -> bool {
        self.spectrum == ForceSpectrum::Profile(ForceProfile::HalfSine)
    }
}

/// The frequencies of one block length with their gains, padded to whole lanes.
pub(crate) struct Grid {
    /// Distance of the bins \[Hz\].
    pub(crate) spacing_hz: f64,
    /// Number of bins that are not zero.
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

/// Losses of a path at each frequency of a [`Grid`].
pub(crate) struct Losses {
    loss: PathLoss,
    /// Reflectance of the walls \[-\], and attenuation in air [1/m].
    bins: Vec<(f64, f64)>,
}

impl Losses {
    /// `None` without losses.
    pub(crate) fn on(grid: &Grid, loss: PathLoss) -> Option<Self> {
        let at = |omega: &f64| loss.at(omega / std::f64::consts::TAU);
        (!loss.is_none()).then(|| Losses { loss, bins: grid.omega.iter().map(at).collect() })
    }

    /// Attenuates a wave over a path of `distance` \[m\].
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
    /// Sets it to zero on this grid.
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

    /// The samples \[Pa\] of this spectrum within the band; `bins` and `scratch` are working memory.
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
        // The pressure is real, so its mean is real; rounding may have left a negative zero.
        bins[0].im = 0.0;
        scratch.resize(inverse.get_scratch_len(), Complex::ZERO);
        inverse.process_with_scratch(bins, samples, scratch).expect("buffers of the plan's own lengths");
    }
}

/// e^{i k angle} for N consecutive k, advanced by a multiplication.
pub(crate) struct Rotation<const N: usize> {
    pub(crate) angle: f64,
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
