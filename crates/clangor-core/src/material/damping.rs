//! Damping of vibration in a material: the damping ratio ξ of a mode of angular frequency ω = 2πf, in
//!
//! ```text
//! q̈ + 2 ξ ω q̇ + ω² q = Q,   T60 = 3 ln 10 / (ξ ω)
//! loss factor η:   ξ = η/2
//! T60:             ξ = 3 ln 10 / (ω T60)
//! Rayleigh:        C = α M + β K + g M K⁺ M,   ξ = (α/ω + β ω + g/ω³)/2
//! ```
//!
//! The term with the pseudo-inverse of the stiffness is that of \[PAN\], which damps low modes most. α, β and
//! g belong to the material: a body of another size has other ω and therefore other ξ.
//!
//! Tables against frequency are interpolated in the logarithms of both, and constant outside. Decay times
//! measured on single modes apply to modes within [`MODE_MATCH`] of their frequency. A pair of modes of one
//! frequency has one T60.

use std::f64::consts::{LN_10, TAU};

/// Largest relative distance of a mode from the frequency of a measured decay: half a semitone.
pub const MODE_MATCH: f64 = 0.03;

/// Damping of a material. Frequencies are in hertz and in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub enum Damping {
    /// Loss factor η \[-\], the same at every frequency: T60 = 6 ln 10 / (2π η f).
    LossFactor(f64),
    /// Time to decay by 60 dB \[s\], the same at every frequency.
    T60(f64),
    /// Rayleigh's damping and the inverse-stiffness term of \[PAN\].
    Rayleigh {
        /// α [1/s], of the mass.
        alpha: f64,
        /// β \[s\], of the stiffness.
        beta: f64,
        /// g [1/s³], of the inverse stiffness.
        g: f64,
    },
    /// Loss factors [Hz, -].
    LossFactorTable(Vec<[f64; 2]>),
    /// Times to decay by 60 dB [Hz, s].
    T60Table(Vec<[f64; 2]>),
    /// Times to decay by 60 dB of the modes near some frequencies [Hz, s].
    Modes {
        /// The modes.
        t60: Vec<[f64; 2]>,
        /// Damping of all other modes.
        otherwise: Box<Damping>,
    },
}

/// Error in the numbers of a damping model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DampingError {
    /// A number outside the valid range.
    #[error("{what} is {value}")]
    Value {
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A table without rows.
    #[error("the table of {what} is empty")]
    Empty {
        /// Quantity of the table.
        what: &'static str,
    },
    /// Frequencies that are not in ascending order.
    #[error("{frequency} Hz follows {previous} Hz, but frequencies must ascend")]
    Order {
        /// Frequency out of order \[Hz\].
        frequency: f64,
        /// The one before it \[Hz\].
        previous: f64,
    },
}

impl Damping {
    /// ξ of a mode of this frequency \[Hz\].
    ///
    /// A mode with ξ of 1 or more does not oscillate.
    pub fn damping_ratio(&self, frequency: f64) -> f64 {
        let omega = TAU * frequency;
        let of_time = |t60: f64| 3.0 * LN_10 / (omega * t60);
        match self {
            Damping::LossFactor(eta) => 0.5 * eta,
            Damping::T60(t60) => of_time(*t60),
            Damping::Rayleigh { alpha, beta, g } => 0.5 * (alpha / omega + beta * omega + g / omega.powi(3)),
            Damping::LossFactorTable(rows) => 0.5 * interpolated(rows, frequency),
            Damping::T60Table(rows) => of_time(interpolated(rows, frequency)),
            Damping::Modes { t60, otherwise } => {
                nearest_row(t60, frequency).map_or_else(|| otherwise.damping_ratio(frequency), of_time)
            }
        }
    }

    /// Time in which a mode of this frequency \[Hz\] decays by 60 dB \[s\]; infinite without damping.
    pub fn t60(&self, frequency: f64) -> f64 {
        3.0 * LN_10 / (TAU * frequency * self.damping_ratio(frequency))
    }

    /// Frequencies \[Hz\] of measured decays that none of the modes of these frequencies \[Hz\] has.
    pub fn unmatched(&self, frequencies: &[f64]) -> Vec<f64> {
        let Damping::Modes { t60, .. } = self else { return Vec::new() };
        let measured = t60.iter().map(|row| row[0]);
        measured.filter(|at| !frequencies.iter().any(|f| distance(*at, *f) <= MODE_MATCH)).collect()
    }

    /// Rejects numbers that are not positive, zeros where zero is invalid, and frequencies that are not in
    /// ascending order.
    ///
    /// # Errors
    /// [`DampingError`].
    pub fn check(&self) -> Result<(), DampingError> {
        match self {
            Damping::LossFactor(eta) => not_negative("the loss factor", *eta),
            Damping::T60(t60) => positive("T60", *t60),
            Damping::Rayleigh { alpha, beta, g } => {
                not_negative("alpha", *alpha)?;
                not_negative("beta", *beta)?;
                not_negative("g", *g)
            }
            Damping::LossFactorTable(rows) => check_rows("loss factors", "a loss factor", rows),
            Damping::T60Table(rows) => check_rows("T60", "T60", rows),
            Damping::Modes { t60, otherwise } => {
                check_rows("T60", "T60", t60)?;
                otherwise.check()
            }
        }
    }
}

fn positive(what: &'static str, value: f64) -> Result<(), DampingError> {
    let good = value > 0.0 && value.is_finite();
    good.then_some(()).ok_or(DampingError::Value { what, value })
}

fn not_negative(what: &'static str, value: f64) -> Result<(), DampingError> {
    let good = value >= 0.0 && value.is_finite();
    good.then_some(()).ok_or(DampingError::Value { what, value })
}

fn check_rows(table: &'static str, what: &'static str, rows: &[[f64; 2]]) -> Result<(), DampingError> {
    if rows.is_empty() {
        return Err(DampingError::Empty { what: table });
    }
    for [frequency, value] in rows {
        positive("a frequency", *frequency)?;
        positive(what, *value)?;
    }
    match rows.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
        Some(pair) => Err(DampingError::Order { frequency: pair[1][0], previous: pair[0][0] }),
        None => Ok(()),
    }
}

/// Interpolation at a frequency by a power law between the rows of a table.
fn interpolated(rows: &[[f64; 2]], frequency: f64) -> f64 {
    let next = rows.partition_point(|row| row[0] <= frequency);
    match (next.checked_sub(1).and_then(|before| rows.get(before)), rows.get(next)) {
        (Some(before), Some(after)) => {
            let s = (frequency / before[0]).ln() / (after[0] / before[0]).ln();
            before[1] * (after[1] / before[1]).powf(s)
        }
        (Some(end), None) | (None, Some(end)) => end[1],
        (None, None) => 0.0,
    }
}

/// |a − b| relative to `at`.
fn distance(at: f64, frequency: f64) -> f64 {
    (frequency / at - 1.0).abs()
}

/// The value of the nearest row within the tolerance.
fn nearest_row(rows: &[[f64; 2]], frequency: f64) -> Option<f64> {
    let near = rows.iter().map(|[at, value]| (distance(*at, frequency), *value));
    near.filter(|(d, _)| *d <= MODE_MATCH).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_gives_the_decay_that_it_names() {
        let f = 1000.0;
        // 60 dB in half a second, in four equivalent forms. Residual seen: 1e-16.
        let t60 = 0.5;
        let rate = 3.0 * LN_10 / t60;
        let omega = TAU * f;
        let table = |value: f64| vec![[500.0, 0.5 * value], [2000.0, 2.0 * value]];
        let kinds = [
            Damping::T60(t60),
            Damping::LossFactor(2.0 * rate / omega),
            Damping::Rayleigh { alpha: 2.0 * rate, beta: 0.0, g: 0.0 },
            Damping::Rayleigh { alpha: 0.0, beta: 2.0 * rate / (omega * omega), g: 0.0 },
            Damping::Rayleigh { alpha: 0.0, beta: 0.0, g: 2.0 * rate * omega * omega },
            Damping::T60Table(table(t60)),
            Damping::LossFactorTable(table(2.0 * rate / omega)),
            Damping::Modes { t60: vec![[980.0, t60], [1100.0, 9.0]], otherwise: Box::new(Damping::T60(7.0)) },
            Damping::Modes { t60: vec![[960.0, 9.0]], otherwise: Box::new(Damping::T60(t60)) },
        ];
        for damping in kinds {
            assert!((damping.t60(f) / t60 - 1.0).abs() < 1e-14, "{damping:?}: {}", damping.t60(f));
            assert_eq!(damping.check(), Ok(()));
        }
    }

    #[test]
    fn tables_are_constant_outside_and_numbers_are_checked() {
        let damping = Damping::T60Table(vec![[100.0, 2.0], [1000.0, 0.5]]);
        assert!((damping.t60(10.0) - 2.0).abs() < 1e-14 && (damping.t60(1e5) - 0.5).abs() < 1e-14);
        let modes = Damping::Modes { t60: vec![[440.0, 1.0], [900.0, 1.0]], otherwise: Box::new(damping) };
        assert_eq!(modes.unmatched(&[430.0, 1200.0]), vec![900.0]);
        let bad = [
            Damping::T60(0.0),
            Damping::LossFactor(f64::NAN),
            Damping::Rayleigh { alpha: -1.0, beta: 0.0, g: 0.0 },
            Damping::T60Table(Vec::new()),
            Damping::LossFactorTable(vec![[100.0, 0.1], [100.0, 0.2]]),
            Damping::Modes { t60: vec![[1.0, 1.0]], otherwise: Box::new(Damping::T60(-1.0)) },
        ];
        bad.into_iter().for_each(|damping| assert!(damping.check().is_err(), "{damping:?}"));
    }
}
