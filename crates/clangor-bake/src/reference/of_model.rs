//! The published representation of a baked field: PAN's grids of directions, or PROXY's octant of wavelets.
//!
//! The shortest pulse is limited by the band of the field: h = 5/κ, whose spectrum is at 1 % of its peak at
//! the highest κ. Three longer pulses of 2h, 4h and 8h complete it (\[PAN\] fig. 9), sampled at steps in
//! proportion. N = 2 powers of 1/r are fitted to M = 5 radii, as published.

use clangor_core::reference::pan_representation::directions::Directions;
use clangor_core::reference::pan_representation::{PanError, PanModel};
use clangor_core::sound_model::acceleration::model::AccelerationModel;

use super::{FieldSampler, Fit, PanFitError, PanOptions, fit};

/// Choice of the published form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PanForm {
    /// \[PAN\]: a grid in angles, all samples.
    Angles {
        /// Divisions of the polar angle.
        rows: usize,
        /// Divisions of the azimuth.
        columns: usize,
    },
    /// \[PROXY\]: one octant of a body with three planes of symmetry, the wavelet coefficients above a
    /// tolerance ε.
    Octant {
        /// ε.
        tolerance: f64,
    },
}

/// Reasons why a field has no published form.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PanModelError {
    /// The field lacks the three mirror symmetries.
    #[error(
        "the octant needs a body with three planes of symmetry along its axes, and {part:.1e} of this field \
         is not symmetric; use a grid in angles"
    )]
    Asymmetric {
        /// Fraction of the field, relative L2.
        part: f64,
    },
    /// The fit failed.
    #[error(transparent)]
    Fit(#[from] PanFitError),
    /// The result cannot be evaluated.
    #[error(transparent)]
    Model(#[from] PanError),
}

/// Longest pulse over the shortest, as a power of two.
const OCTAVES: i32 = 3;
/// Times between samples for each pulse.
const SAMPLES_PER_PULSE: f64 = 12.5;
/// Smallest singular value over the largest of PAN's fit.
const TRUNCATION: f64 = 1e-3;
/// Largest asymmetric fraction of a field that counts as symmetric.
const MOST_ASYMMETRY: f64 = 1e-3;

/// Fits the published representation to a model.
///
/// # Errors
/// [`PanModelError`].
pub fn pan_model(model: &AccelerationModel, form: PanForm) -> Result<PanModel, PanModelError> {
    let field = &model.field;
    let (directions, how) = match form {
        PanForm::Angles { rows, columns } => {
            (Directions::Angles { rows, columns }, Fit::TruncatedSvd { truncation: TRUNCATION })
        }
        PanForm::Octant { tolerance } => {
            let part = asymmetry(model);
            if part > MOST_ASYMMETRY {
                return Err(PanModelError::Asymmetric { part });
            }
            (Directions::OCTANT_45, Fit::Wavelets { tolerance })
        }
    };
    let fields = (0..=OCTAVES)
        .map(|octave| {
            let pulse = 5.0 / field.max_wavenumber * 2f64.powi(octave);
            let step = pulse / SAMPLES_PER_PULSE;
            // From the earliest arrival from the body to the end of the response, with a margin for the ends
            // of the fit.
            let seconds = field.ring_time + 2.0 + 4.0 * pulse + 64.0 * step;
            let length = ((seconds / step).ceil() as usize).next_power_of_two();
            let options = PanOptions { pulse, step, length, terms: 2, radii: 5, directions, fit: how };
            let sampler = FieldSampler::new(field, &options.wavenumbers());
            fit(&options, &|x| sampler.spectra(x))
        })
        .collect::<Result<_, _>>()?;
    Ok(PanModel::new(model.radius, fields)?)
}

/// Fraction of a field, relative L2 of its coefficients, that violates the parities of a body with three
/// planes of symmetry.
fn asymmetry(model: &AccelerationModel) -> f64 {
    let field = &model.field;
    let (mut odd, mut all) = (0.0, 0.0);
    let rows = field.real.chunks(field.nodes.len()).zip(field.imaginary.chunks(field.nodes.len()));
    for (term, (real, imaginary)) in field.terms.iter().zip(rows) {
        // The monopole of such a body is zero, whatever its factor.
        let square: f64 = real.iter().chain(imaginary).map(|q| f64::from(*q).powi(2)).sum();
        all += square;
        if parity(term.n, term.m) != ODD[usize::from(term.degree)] {
            odd += square;
        }
    }
    (odd / f64::max(all, f64::MIN_POSITIVE)).sqrt()
}

/// Whether each motion is odd in x, y, z.
const ODD: [[bool; 3]; 6] = [
    [true, false, false],
    [false, true, false],
    [false, false, true],
    [false, true, true],
    [true, false, true],
    [true, true, false],
];

/// Whether Y_nm is odd in x, y, z.
fn parity(n: u8, m: i8) -> [bool; 3] {
    // cos mφ is odd in x for odd m and even in y; sin mφ is odd in y, and in x for even m.
    let (odd_order, sine) = (m % 2 != 0, m < 0);
    [odd_order != sine, sine, (n + m.unsigned_abs()) % 2 == 1]
}
