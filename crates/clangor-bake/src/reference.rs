//! Fit of the published representation to a field at given wavenumbers: pulses along directions, expanded in
//! 1/r.
//!
//! Along each direction the pressure of the pulse ψ(t; h) is evaluated at M radii R_1 … R_M from 2 R to 4 R
//! in equal ratios, by Fourier synthesis of the spectrum of the field times that of the pulse; the papers use
//! a finite-difference simulation. Then the signals q_k are fitted in one of two ways ([`Fit`]): all samples
//! at once by a truncated singular value decomposition (\[PAN\] eq. (25)), or one wavelet coefficient at a
//! time (\[PROXY\] eq. (14)).
//!
//! Units as in [`clangor_core::reference::pan_representation`]: lengths in R, times in R/c, pressures in ρR.

mod of_model;
mod sampling;
mod series_fit;

use clangor_core::reference::pan_representation::PanField;
use clangor_core::reference::pan_representation::directions::Directions;
use clangor_core::reference::pan_representation::signals::{Signals, SparseCoefficients};
use clangor_core::reference::pan_representation::wavelet;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

pub use self::of_model::{PanForm, PanModelError, pan_model};
pub use self::sampling::{FieldSampler, half_sine_spectrum, synthesize};
use self::series_fit::{CirculantFit, pseudo_inverse};

/// Method of the fit for the signals q_k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fit {
    /// \[PAN\] eq. (25): least squares over all samples of all radii, singular values below `truncation` of
    /// the largest left out.
    ///
    /// Differs: the paper does not give its truncation. Time is periodic here, so that the Fourier transform
    /// decouples the system into one of M equations for each frequency, whose singular values together are
    /// those of the whole.
    TruncatedSvd {
        /// Smallest singular value over the largest.
        truncation: f64,
    },
    /// \[PROXY\] eq. (14): least squares for each wavelet coefficient. A coefficient is kept if at some
    /// radius it is at least `tolerance` ε of the largest at that radius.
    Wavelets {
        /// ε.
        tolerance: f64,
    },
}

/// Settings of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanOptions {
    /// h [R/c].
    pub pulse: f64,
    /// Time between samples [R/c].
    pub step: f64,
    /// Samples of each signal; a power of two for wavelets, even for the other fit.
    pub length: usize,
    /// N: powers of 1/r.
    pub terms: usize,
    /// M: radii, at least `terms` and two.
    pub radii: usize,
    /// Directions.
    pub directions: Directions,
    /// Method.
    pub fit: Fit,
}

/// Radii of the fit \[R\]: 2 to 4 in equal ratios (\[PAN\] §4.2).
pub fn fit_radii(count: usize) -> Vec<f64> {
    (0..count).map(|i| 2.0 * 2.0f64.powf(i as f64 / (count - 1) as f64)).collect()
}

impl PanOptions {
    /// t − r/c of the first sample [R/c]: the wave leaves the body up to R/c before one from the centre, the
    /// pulse begins 2h before its middle, and a margin remains for the wavelets at the beginning.
    pub fn start(&self) -> f64 {
        -1.0 - 2.0 * self.pulse - 16.0 * self.step
    }

    /// κ = kR at which the field is needed: from 0 to π/Δt.
    pub fn wavenumbers(&self) -> Vec<f64> {
        sampling::wavenumbers(self.step, self.length)
    }
}

/// Reasons why the published fit fails.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PanFitError {
    /// Invalid option.
    #[error("{what} is {value}")]
    BadOption {
        /// Name of the option.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The singular value decomposition failed.
    #[error("the singular values of the fit do not converge")]
    SingularValues,
}

/// Fits the published representation at the [`fit_radii`].
///
/// `spectra` is the field: p e^{iκ|x|}/(ρR) of z = e_1 … e_6 at x, at the [`PanOptions::wavenumbers`]; zero
/// where unknown.
///
/// # Errors
/// [`PanFitError`] for invalid options.
pub fn fit(
    options: &PanOptions,
    spectra: &(dyn Fn(DVec3) -> [Vec<Complex64>; RIGID_DOFS] + Sync),
) -> Result<PanField, PanFitError> {
    fit_at(options, &fit_radii(options.radii), spectra)
}

/// The same at other radii \[R\]; \[PROXY\] gives only their number. A repeated radius has double weight.
///
/// # Errors
/// [`PanFitError`] for invalid options, a different number of radii than in the options, or a radius below 1.
pub fn fit_at(
    options: &PanOptions,
    radii: &[f64],
    spectra: &(dyn Fn(DVec3) -> [Vec<Complex64>; RIGID_DOFS] + Sync),
) -> Result<PanField, PanFitError> {
    check(options)?;
    if radii.len() != options.radii {
        return Err(PanFitError::BadOption { what: "the number of radii", value: radii.len() as f64 });
    }
    if let Some(&radius) = radii.iter().find(|r| !(**r >= 1.0 && r.is_finite())) {
        return Err(PanFitError::BadOption { what: "a radius of the fit", value: radius });
    }
    let vectors = options.directions.vectors();
    let start = options.start();
    let pulse = sampling::pulse_spectrum(options);
    let signals = match options.fit {
        // Wavelets: transform the signals at the radii, then one least-squares fit per coefficient.
        Fit::Wavelets { tolerance } => {
            let inverse = pseudo_inverse(radii, options.terms)?;
            let pairs: Vec<Vec<(u16, Vec<f32>)>> = vectors
                .par_iter()
                .flat_map_iter(|v| {
                    let shells = shell_spectra(*v, radii, spectra);
                    let fitted: Vec<_> = (0..RIGID_DOFS)
                        .map(|degree| {
                            let coefficients: Vec<Vec<f64>> = shells
                                .iter()
                                .map(|shell| {
                                    let mut x = synthesize(&shell[degree], &pulse, options.step, start);
                                    wavelet::forward(&mut x);
                                    x
                                })
                                .collect();
                            compressed(&coefficients, &inverse, tolerance)
                        })
                        .collect();
                    fitted
                })
                .collect();
            Signals::Wavelets(packed(&pairs))
        }
        Fit::TruncatedSvd { truncation } => {
            // Truncated SVD: one system per frequency, for all samples.
            let system = CirculantFit::new(options, radii, truncation)?;
            let samples: Vec<Vec<f32>> = vectors
                .par_iter()
                .map(|v| {
                    let shells = shell_spectra(*v, radii, spectra);
                    let mut all = Vec::with_capacity(RIGID_DOFS * options.terms * options.length);
                    for degree in 0..RIGID_DOFS {
                        for q in system.solve(&shells, degree, &pulse) {
                            let x = synthesize(&q, &vec![1.0; q.len()], options.step, start);
                            all.extend(x.iter().map(|x| *x as f32));
                        }
                    }
                    all
                })
                .collect();
            Signals::Samples(samples.concat())
        }
    };
    Ok(PanField {
        pulse: options.pulse,
        step: options.step,
        start,
        length: options.length,
        terms: options.terms,
        directions: options.directions,
        signals,
    })
}

fn check(options: &PanOptions) -> Result<(), PanFitError> {
    let bad = |what, value| Err(PanFitError::BadOption { what, value });
    let positive = |x: f64| x > 0.0 && x.is_finite();
    if !positive(options.pulse) {
        return bad("the pulse", options.pulse);
    }
    if !positive(options.step) {
        return bad("the time between samples", options.step);
    }
    let wavelets = matches!(options.fit, Fit::Wavelets { .. });
    let length_fits = if wavelets {
        options.length.is_power_of_two() && options.length <= usize::from(u16::MAX) + 1
    } else {
        options.length.is_multiple_of(2)
    };
    if options.length < 2 || !length_fits {
        return bad("the length of the signals", options.length as f64);
    }
    if options.terms == 0 {
        return bad("the number of terms", 0.0);
    }
    if options.radii < options.terms.max(2) {
        return bad("the number of radii", options.radii as f64);
    }
    if !options.directions.is_valid() {
        return bad("the number of directions", options.directions.count() as f64);
    }
    let tolerance = match options.fit {
        Fit::Wavelets { tolerance } => tolerance,
        Fit::TruncatedSvd { truncation } => truncation,
    };
    if !(0.0..1.0).contains(&tolerance) {
        return bad("the tolerance of the fit", tolerance);
    }
    Ok(())
}

/// For each radius, the six spectra.
fn shell_spectra(
    direction: DVec3,
    radii: &[f64],
    spectra: &(dyn Fn(DVec3) -> [Vec<Complex64>; RIGID_DOFS] + Sync),
) -> Vec<[Vec<Complex64>; RIGID_DOFS]> {
    radii.iter().map(|r| spectra(direction * *r)).collect()
}

/// Indices of the kept coefficients, with their N values.
fn compressed(shells: &[Vec<f64>], inverse: &[Vec<f64>], tolerance: f64) -> Vec<(u16, Vec<f32>)> {
    let least: Vec<f64> =
        shells.iter().map(|c| tolerance * c.iter().fold(0.0, |m: f64, x| m.max(x.abs()))).collect();
    // A degree of freedom that radiates nothing stores nothing.
    let silent = least.iter().all(|l| *l <= f64::MIN_POSITIVE) && tolerance > 0.0;
    (0..if silent { 0 } else { shells[0].len() })
        .filter(|&j| shells.iter().zip(&least).any(|(c, least)| c[j].abs() >= *least))
        .map(|j| {
            let value = |row: &Vec<f64>| row.iter().zip(shells).map(|(w, c)| w * c[j]).sum::<f64>() as f32;
            (j as u16, inverse.iter().map(value).collect())
        })
        .collect()
}

fn packed(pairs: &[Vec<(u16, Vec<f32>)>]) -> SparseCoefficients {
    let mut sparse = SparseCoefficients { first: vec![0], ..SparseCoefficients::default() };
    for entries in pairs {
        for (place, values) in entries {
            sparse.places.push(*place);
            sparse.values.extend(values);
        }
        sparse.first.push(sparse.places.len() as u32);
    }
    sparse
}
