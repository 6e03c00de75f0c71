//! Spectra of clicks of spheres.
//!
//! The transfer of a sphere and the spectrum of the force are rational in ω apart from one cosine, the delay
//! is a rotation. Cosine and rotation advance by a constant angle per bin, so neither needs a sine or cosine
//! per bin.

use super::spectrum::{ArrivingForce, Grid, Rotation, Spectrum};
use crate::sound_model::acceleration::sphere_radiation::SphereTransfer;

/// Bins that advance together.
const SPHERE_LANES: usize = 4;

/// Adds a wave to a spectrum.
#[inline(always)]
pub(super) fn add(spectrum: &mut Spectrum, grid: &Grid, force: &ArrivingForce, transfer: &SphereTransfer) {
    let step = std::f64::consts::TAU * grid.spacing_hz;
    let delay = Rotation::new(-step * force.middle);
    if force.is_half_sine() {
        add_half_sine(spectrum, grid, force, transfer, delay);
    } else {
        add_any(spectrum, grid, force, transfer, delay);
    }
}

/// Any force, with its spectrum evaluated bin by bin.
#[inline(always)]
fn add_any(
    spectrum: &mut Spectrum,
    grid: &Grid,
    force: &ArrivingForce,
    transfer: &SphereTransfer,
    mut delay: Rotation<SPHERE_LANES>,
) {
    for first in (0..grid.omega.len()).step_by(SPHERE_LANES) {
        for lane in 0..SPHERE_LANES {
            let k = first + lane;
            let (re, im) = transfer.undelayed(grid.omega[k]);
            let (force_re, force_im) = force.at(k, grid.omega[k]);
            let turned_re = re * delay.cos[lane] - im * delay.sin[lane];
            let turned_im = re * delay.sin[lane] + im * delay.cos[lane];
            spectrum.re[k] += force_re * turned_re - force_im * turned_im;
            spectrum.im[k] += force_re * turned_im + force_im * turned_re;
        }
        delay.advance();
    }
}

/// The half-sine, its cosine by rotation and its denominator multiplied into that of the transfer, so
/// that a bin costs one division.
#[inline(always)]
fn add_half_sine(
    spectrum: &mut Spectrum,
    grid: &Grid,
    force: &ArrivingForce,
    transfer: &SphereTransfer,
    mut delay: Rotation<SPHERE_LANES>,
) {
    let step = std::f64::consts::TAU * grid.spacing_hz;
    let mut half_angle = Rotation::<SPHERE_LANES>::new(0.5 * step * force.duration);
    let pole = std::f64::consts::PI / force.duration;
    let inverse_pole_square = 1.0 / (pole * pole);
    let SphereTransfer { real: [a0, a1], imaginary: [b0, b1], denominator: [d0, d1], .. } = *transfer;

    // The bin next to ω = π/τ, where cos(ωτ/2) / (1 − (ωτ/π)²) is 0/0, uses the formula with the limit.
    let singular = (pole / step).round();
    let singular = (singular < grid.omega.len() as f64).then_some(singular as usize);
    let kept = singular.map(|k| (spectrum.re[k], spectrum.im[k]));

    let omega = grid.omega.as_chunks::<SPHERE_LANES>().0;
    let re_out = spectrum.re.as_chunks_mut::<SPHERE_LANES>().0;
    let im_out = spectrum.im.as_chunks_mut::<SPHERE_LANES>().0;
    for ((omega, re_out), im_out) in omega.iter().zip(re_out).zip(im_out) {
        // Sums first, stores after, so that the compiler can see that the lanes are independent.
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
        let (amplitude, _) = force.at(k, grid.omega[k]);
        let (re, im) = transfer.undelayed(grid.omega[k]);
        let (sin, cos) = (delay.angle * k as f64).sin_cos();
        spectrum.re[k] = re_before + amplitude * (re * cos - im * sin);
        spectrum.im[k] = im_before + amplitude * (re * sin + im * cos);
    }
}
