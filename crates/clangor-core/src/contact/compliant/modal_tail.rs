//! Modes above the band of a modal model, in the mean: what the contact feels of them.
//!
//! ```text
//! Ȳ = (π/2) Σφ²/Δω over the last octave    φ_t² = (2/π) Ȳ 2πΔf    Δf = 1/(6τ)    decay 1/(6τ)
//! ```
//!
//! A contact shorter than the period of the highest mode loses energy to modes that are not listed. A row of
//! equal modes from f_max to max(4/τ, 1.5 f_max) has their mean mobility Ȳ [m/(N s)], and returns nothing
//! within the contact. Each contact of a body has a tail of its own along its normal, uncorrelated with
//! those of others: its shapes are zero at the other contacts. Its energy is dropped as heat.

use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Most modes of a tail. Longer contacts than 6τ(f − f_max) = 32 excite nothing there; their tail is coarser.
const MOST: usize = 32;

/// Equal modes at even distances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModalTail {
    /// Poles λ [1/s].
    pub poles: Vec<Complex64>,
    /// Displacement along the normal of each [kg^−½].
    pub shape: f64,
}

/// The tail of a body at a contact; empty if nothing vibrates in the last octave.
///
/// * `modes`: angular frequency [rad/s] and displacement along the normal [kg^−½] of each mode.
/// * `highest`: f_max, up to which all modes are given \[Hz\].
/// * `duration`: Hertz's duration τ of the rigid bodies \[s\].
pub fn modal_tail(modes: impl IntoIterator<Item = (f64, f64)>, highest: f64, duration: f64) -> ModalTail {
    let edge = TAU * highest;
    let octave = modes.into_iter().filter(|(omega, _)| *omega > 0.5 * edge && *omega <= edge);
    let mobility = FRAC_PI_2 * octave.map(|(_, phi)| phi * phi).sum::<f64>() / (0.5 * edge);
    let range = (4.0 / duration).max(1.5 * highest) - highest;
    let usable = mobility > 0.0 && mobility.is_finite() && range > 0.0 && range.is_finite() && duration > 0.0;
    if !usable {
        return ModalTail::default();
    }
    let count = (6.0 * duration * range).ceil().clamp(1.0, MOST as f64);
    let spacing = range / count;
    let pole = |i: usize| Complex64::new(-spacing, TAU * (highest + (i as f64 + 0.5) * spacing));
    ModalTail {
        poles: (0..count as usize).map(pole).collect(),
        shape: (2.0 / PI * mobility * TAU * spacing).sqrt(),
    }
}
