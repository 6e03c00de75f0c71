//! Errors of a published field relative to the field it was fitted to.

use clangor_bake::reference::{half_sine_spectrum, synthesize};
use clangor_core::glam::DVec3;
use clangor_core::reference::pan_representation::PanField;
use clangor_core::reference::pan_representation::pulse::pulse_spectrum;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use num_complex::Complex64;

/// Force that drives the body.
#[derive(Clone, Copy)]
pub enum Push {
    /// One pulse ψ of the field.
    Pulse,
    /// A half-sine made of pulses.
    HalfSine {
        /// τ [R/c].
        duration: f64,
        /// Onset after the first pulse [R/c].
        onset: f64,
    },
}

/// Directions over the sphere by the golden angle, off every grid.
pub fn directions(count: usize) -> Vec<DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let (sin, cos) = (golden * i as f64 + 0.3).sin_cos();
            DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
        })
        .collect()
}

/// Pressures of one motion at a point, by the published field and exactly, at the samples of the field.
pub fn signals(
    field: &PanField,
    push: Push,
    exact: &[Complex64],
    degree: usize,
    x: DVec3,
) -> (Vec<f64>, Vec<f64>) {
    let spacing = std::f64::consts::TAU / (field.length as f64 * field.step);
    let wavenumbers = (0..=field.length / 2).map(|m| m as f64 * spacing);
    let mut z = [0.0; RIGID_DOFS];
    z[degree] = 1.0;
    let response = field.response(&z, x, f64::INFINITY);
    match push {
        // Exact reference: synthesis of the pulse spectrum.
        Push::Pulse => {
            let gains: Vec<f64> = wavenumbers.map(|k| pulse_spectrum(k, field.pulse)).collect();
            (response.samples, synthesize(exact, &gains, field.step, field.start))
        }
        Push::HalfSine { duration, onset } => {
            // Sum of shifted pulses, and its exact reference.
            let weights: Vec<f64> = (0..=((onset + duration) / field.pulse) as usize)
                .map(|k| (k as f64 * field.pulse - onset).max(0.0) / duration)
                .map(|x| (std::f64::consts::PI * x).sin())
                .collect();
            let sum = response.shifted_sum(&weights, field.pulse);
            let skip = ((field.start - sum.start) / field.step).round() as usize;
            let spectrum: Vec<Complex64> = exact
                .iter()
                .zip(wavenumbers)
                .map(|(p, k)| p * half_sine_spectrum(k, duration) * Complex64::from_polar(1.0, -k * onset))
                .collect();
            let ones = vec![1.0; spectrum.len()];
            let reference = synthesize(&spectrum, &ones, field.step, field.start);
            (sum.samples[skip..skip + field.length].to_vec(), reference)
        }
    }
}

/// For each motion, squares of the error and of the signal, summed over directions at a distance.
fn sums(
    field: &PanField,
    spectra: &dyn Fn(DVec3) -> [Vec<Complex64>; RIGID_DOFS],
    push: Push,
    directions: &[DVec3],
    distance: f64,
) -> [[f64; 2]; RIGID_DOFS] {
    let mut sums = [[0.0; 2]; RIGID_DOFS];
    for v in directions {
        let exact = spectra(*v * distance);
        for (degree, sum) in sums.iter_mut().enumerate() {
            let (x, reference) = signals(field, push, &exact[degree], degree, *v * distance);
            for (x, r) in x.iter().zip(&reference) {
                sum[0] += (x - r) * (x - r);
                sum[1] += r * r;
            }
        }
    }
    sums
}

/// Relative L2 error of each motion over directions at a distance; a motion below 1e-6 of the loudest counts
/// as silent.
pub fn errors(
    field: &PanField,
    spectra: &dyn Fn(DVec3) -> [Vec<Complex64>; RIGID_DOFS],
    push: Push,
    directions: &[DVec3],
    distance: f64,
) -> [Option<f64>; RIGID_DOFS] {
    let sums = sums(field, spectra, push, directions, distance);
    let loudest = sums.iter().map(|s| s[1]).fold(0.0, f64::max);
    sums.map(|[difference, size]| (size > 1e-12 * loudest).then(|| (difference / size).sqrt()))
}

/// Errors of one pulse at the stored directions.
pub struct PulseErrors {
    /// Of each motion against itself.
    pub own: [Option<f64>; RIGID_DOFS],
    /// Of each motion against the loudest, rotations at equal surface speed.
    pub level: [f64; RIGID_DOFS],
    /// Size of each motion over that of the loudest.
    pub loudness: [f64; RIGID_DOFS],
}

/// Errors of the pulse of a field at a distance.
pub fn pulse_errors(
    field: &PanField,
    spectra: &dyn Fn(DVec3) -> [Vec<Complex64>; RIGID_DOFS],
    directions: &[DVec3],
    distance: f64,
) -> PulseErrors {
    let sums = sums(field, spectra, Push::Pulse, directions, distance);
    let loudest = sums.iter().map(|s| s[1]).fold(0.0, f64::max);
    PulseErrors {
        own: sums.map(|[difference, size]| (size > 1e-12 * loudest).then(|| (difference / size).sqrt())),
        level: sums.map(|s| (s[0] / loudest).sqrt()),
        loudness: sums.map(|s| (s[1] / loudest).sqrt()),
    }
}

/// The worst of some motions.
pub fn worst(errors: &[Option<f64>]) -> f64 {
    errors.iter().flatten().copied().fold(0.0, f64::max)
}
