//! The bank of ellipsoids that stand for small bodies: built from nothing, or read.
//!
//! \[PROXY\] §5: A ≥ B ≥ C with B and C from 5 % of A to A in steps of 9.5 %, 66 ellipsoids. Fields have no unit of length,
//! so that A is 1 m here and the band ends at a given kA: that of a body of any size at some frequency.

use std::ops::ControlFlow;

use clangor::glam::DVec3;
use clangor::model::bank_file::{BankFile, BankOrigin};
use clangor::model::ellipsoid_bank::{BankEntry, BankError, EllipsoidBank};
use clangor::model::playable_model::PlayableBank;
use clangor_bake::acceleration_noise::{BakeError, BakeGeometry, BakeOptions, BakeProgress, Method, bake};

/// The bank that comes with the program; `None` if it cannot be used.
pub fn default_bank() -> Option<PlayableBank> {
    None
}

/// Least semi-axis over the longest.
const THINNEST: f64 = 0.05;
/// Steps from there to 1.
const STEPS: usize = 10;

/// How to build a bank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BankOptions {
    /// Highest kA, with A the longest semi-axis.
    pub max_wavenumber: f64,
    /// Level error asked for.
    pub accuracy: f64,
}

/// Why there is no bank.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// An ellipsoid could not be baked.
    #[error("the ellipsoid 1 : {b:.3} : {c:.3}: {source}")]
    Bake {
        /// Second semi-axis over the first.
        b: f64,
        /// Third semi-axis over the first.
        c: f64,
        /// Why.
        source: BakeError,
    },
    /// The ellipsoids make no bank.
    #[error(transparent)]
    Bank(#[from] BankError),
}

impl BuildError {
    /// Whether the caller asked to stop.
    pub fn is_interruption(&self) -> bool {
        matches!(self, BuildError::Bake { source: BakeError::Interrupted, .. })
    }
}

/// B and C over A of the ellipsoids, ascending in B, then in C.
pub fn proportions() -> Vec<(f64, f64)> {
    let at = |i: usize| THINNEST + (1.0 - THINNEST) * i as f64 / STEPS as f64;
    (0..=STEPS).flat_map(|i| (0..=i).map(move |j| (at(i), at(j)))).collect()
}

/// Bakes every ellipsoid. `progress` is told which part of the work is done, from 0 to 1.
///
/// # Errors
/// [`BuildError`].
pub fn build_bank(
    options: &BankOptions,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<BankFile, BuildError> {
    let shapes = proportions();
    let bake_options = BakeOptions {
        max_wavenumber: options.max_wavenumber,
        accuracy: options.accuracy,
        method: Method::Auto,
        near_field: false,
    };
    let mut entries = Vec::with_capacity(shapes.len());
    let mut origin = BankOrigin {
        program: format!("clangor {}", env!("CARGO_PKG_VERSION")),
        asked_accuracy: options.accuracy,
        method: String::new(),
        solves: 0,
        held_out_error: 0.0,
    };
    for (done, &(b, c)) in shapes.iter().enumerate() {
        let geometry = BakeGeometry::Ellipsoid { semi_axes: DVec3::new(1.0, b, c) };
        let mut told = |p: &BakeProgress| progress((done as f64 + p.done) / shapes.len() as f64);
        let (model, evidence) =
            bake(&geometry, &bake_options, &mut told).map_err(|source| BuildError::Bake { b, c, source })?;
        entries.push(BankEntry { b, c, field: model.field });
        origin.solves += evidence.solves as u64;
        origin.held_out_error = origin.held_out_error.max(evidence.held_out_error);
        if !origin.method.contains(&evidence.method) {
            if !origin.method.is_empty() {
                origin.method.push_str("; ");
            }
            origin.method.push_str(&evidence.method);
        }
    }
    Ok(BankFile { bank: EllipsoidBank::try_new(entries)?, origin })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_ellipsoids_are_there() {
        let all = proportions();
        assert_eq!(all.len(), 66);
        assert!(all.iter().all(|(b, c)| *b <= 1.0 && c <= b && *c >= THINNEST));
        // 0.5 m, 0.405 m and 0.2625 m in Fig. 5: 1 : 0.81 : 0.525.
        assert!(all.iter().any(|(b, c)| (b - 0.81).abs() < 1e-12 && (c - 0.525).abs() < 1e-12));
        assert_eq!(all.last(), Some(&(1.0, 1.0)));
    }
}
