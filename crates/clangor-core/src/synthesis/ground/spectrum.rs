//! Spectra of impacts on the ground, on the grid of a block.
//!
//! Amplitudes are smooth in log ω, hence close to a parabola over a few bins, except for the lowest.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use super::direction::Direction;
use super::source::{GroundSource, ReceiverDirection};
use crate::synthesis::spectrum::{ArrivingForce, Grid, LANES, Rotation, Spectrum};

/// First bin from which amplitudes are interpolated by parabolas over [`LANES`] bins.
const SMOOTH_FROM: usize = 8 * LANES;

/// A ground under an impact at one point, received at another.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GroundTransfer {
    /// The ground.
    pub(crate) source: Arc<GroundSource>,
    /// Impulse into it [N s].
    pub(crate) impulse: f64,
    /// The listener \[m\] from the point of impact, y up.
    pub(crate) place: DVec3,
}

/// A number for each of the bins that advance together.
type Lanes = [f64; LANES];

/// Adds an impact; the middle of the `arriving` force is its time at the ground, before any delay.
#[inline(always)]
pub(crate) fn add(spectrum: &mut Spectrum, grid: &Grid, arriving: &ArrivingForce, transfer: &GroundTransfer) {
    let GroundTransfer { source, impulse, place } = transfer;
    let (Some(heard), Some(last)) = (ReceiverDirection::at(source, *place), grid.bins.checked_sub(1)) else {
        return;
    };
    if last == 0 {
        return;
    }
    // Waves in the direction of the listener.
    let direction = heard.kept_direction(source, grid.omega[1], grid.omega[last]);
    let step = TAU * grid.spacing_hz;
    let late = arriving.middle;
    // Delay of each wave: a rotation that advances by a constant angle per bin.
    let mut turns: Vec<Rotation<LANES>> = direction
        .trains
        .iter()
        .map(|train| Rotation::new(-step * (late + train.arrival * heard.delay)))
        .collect();
    let mut force = Force { arriving, half_angle: Rotation::new(0.5 * step * arriving.duration) };
    let mut amplitudes = Amplitudes::new(&direction);
    let scale = impulse * source.scale();
    let omegas = grid.omega.as_chunks::<LANES>().0;
    let re_out = spectrum.re.as_chunks_mut::<LANES>().0;
    let im_out = spectrum.im.as_chunks_mut::<LANES>().0;
    for (chunk, ((omega, re_out), im_out)) in omegas.iter().zip(re_out).zip(im_out).enumerate() {
        amplitudes.fill(&direction, &omega.map(|w| w * heard.delay), chunk * LANES >= SMOOTH_FROM);
        // Σ amplitude × e^{−iωt} over the waves.
        let (mut re, mut im): (Lanes, Lanes) = ([0.0; LANES], [0.0; LANES]);
        for ((a_re, a_im), turn) in amplitudes.now.iter().zip(&mut turns) {
            for lane in 0..LANES {
                re[lane] += a_re[lane] * turn.cos[lane] - a_im[lane] * turn.sin[lane];
                im[lane] += a_re[lane] * turn.sin[lane] + a_im[lane] * turn.cos[lane];
            }
            turn.advance();
        }
        // ρ/(2πμ) ω² F(ω) times that sum.
        let (force_re, force_im) = force.next(chunk * LANES, omega);
        for lane in 0..LANES {
            let gain = scale * omega[lane] * omega[lane];
            re_out[lane] += gain * (force_re[lane] * re[lane] - force_im[lane] * im[lane]);
            im_out[lane] += gain * (force_re[lane] * im[lane] + force_im[lane] * re[lane]);
        }
    }
}

/// Amplitudes of all waves at the bins that advance together.
struct Amplitudes {
    now: Vec<(Lanes, Lanes)>,
    /// Amplitudes at the first of the next bins, where they are on parabolas.
    next: Vec<Complex64>,
}

impl Amplitudes {
    fn new(direction: &Direction) -> Self {
        Amplitudes { now: vec![([0.0; LANES], [0.0; LANES]); direction.trains.len()], next: Vec::new() }
    }

    /// Advances to these x.
    #[inline(always)]
    fn fill(&mut self, direction: &Direction, x: &Lanes, smooth: bool) {
        if !smooth {
            for (lane, x) in x.iter().enumerate() {
                for (own, amplitude) in self.now.iter_mut().zip(direction.amplitudes(*x)) {
                    (own.0[lane], own.1[lane]) = (amplitude.re, amplitude.im);
                }
            }
            return;
        }
        if self.next.is_empty() {
            self.next.extend(direction.amplitudes(x[0]));
        }
        let beyond = x[0] + (x[1] - x[0]) * LANES as f64;
        let ends = direction.amplitudes(x[LANES / 2]).zip(direction.amplitudes(beyond));
        for ((own, next), (middle, end)) in self.now.iter_mut().zip(&mut self.next).zip(ends) {
            let begin = std::mem::replace(next, end);
            let (slope, bend) = (end - begin, 4.0 * middle - 2.0 * (begin + end));
            for lane in 0..LANES {
                let part = lane as f64 / LANES as f64;
                let bent = part * (1.0 - part);
                own.0[lane] = begin.re + slope.re * part + bend.re * bent;
                own.1[lane] = begin.im + slope.im * part + bend.im * bent;
            }
        }
    }
}

/// The spectrum of the force from the middle of the impact.
struct Force<'a> {
    arriving: &'a ArrivingForce<'a>,
    half_angle: Rotation<LANES>,
}

impl Force<'_> {
    /// Real and imaginary part at the next bins.
    #[inline(always)]
    fn next(&mut self, first: usize, omega: &Lanes) -> (Lanes, Lanes) {
        let Force { arriving, half_angle } = self;
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        if !arriving.is_half_sine() {
            for lane in 0..LANES {
                (re[lane], im[lane]) = arriving.at(first + lane, omega[lane]);
            }
            return (re, im);
        }
        for lane in 0..LANES {
            let below = 1.0 - (omega[lane] * arriving.duration / PI).powi(2);
            // Near ω = π/τ it is 0/0.
            let singular = below.abs() < 1e-3;
            re[lane] = if singular {
                arriving.at(first + lane, omega[lane]).0
            } else {
                half_angle.cos[lane] / below
            };
        }
        half_angle.advance();
        (re, im)
    }
}
