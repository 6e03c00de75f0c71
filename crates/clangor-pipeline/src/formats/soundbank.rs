//! The bank of ellipsoids that stand for small bodies: built from nothing, or read.
//!
//! \[PROXY\] §5: A ≥ B ≥ C with B and C from 5 % of A to A in steps of 9.5 %, 66 ellipsoids. Fields have no
//! unit of length, so that A is 1 m here and the band ends at a given kA: that of a body of any size at some
//! frequency.

use std::ops::ControlFlow;

use clangor_bake::acceleration::{BakeError, BakeProgress};
use clangor_bake::soundbank::acceleration;
use clangor_core::sound_model::acceleration::model_evaluator::BankEvaluator;
use clangor_core::sound_model::files::ellipsoid_bank_file::{BankFile, BankOrigin};

/// What `clangor bank build` made, as it comes with the program.
const DEFAULT_BANK: &[u8] = include_bytes!("../../../../data/ellipsoid_bank.safetensors");

/// The bank that comes with the program; `None` if it cannot be used.
pub fn default_bank() -> Option<BankEvaluator> {
    let file = BankFile::decode(DEFAULT_BANK).ok()?;
    BankEvaluator::try_new(file.bank).ok()
}

/// How to build a bank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipsoidBankOptions {
    /// Highest kA, with A the longest semi-axis.
    pub max_wavenumber: f64,
    /// Level error asked for.
    pub accuracy: f64,
}

/// Bakes every ellipsoid. `progress` is told which part of the work is done, from 0 to 1.
///
/// # Errors
/// [`BakeError`].
pub fn build_bank(
    options: &EllipsoidBankOptions,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<BankFile, BakeError> {
    let mut on_progress = |p: &BakeProgress| progress(p.done);
    let (bank, evidence) =
        acceleration::build_bank(options.max_wavenumber, options.accuracy, &mut on_progress)?;
    let mut methods: Vec<&str> = evidence.iter().map(|e| e.method.as_str()).collect();
    methods.dedup();
    let origin = BankOrigin {
        program: format!("clangor {}", env!("CARGO_PKG_VERSION")),
        asked_accuracy: options.accuracy,
        method: methods.join("; "),
        solves: evidence.iter().map(|e| e.solves as u64).sum(),
        held_out_error: evidence.iter().map(|e| e.held_out_error).fold(0.0, f64::max),
    };
    Ok(BankFile { bank, origin })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bank_that_is_shipped_can_be_played() {
        let file = BankFile::decode(DEFAULT_BANK).expect("a bank");
        assert_eq!(file.bank.entries().len(), 66);
        assert!(file.origin.held_out_error <= file.origin.asked_accuracy);
        assert!(default_bank().is_some());
        assert!(DEFAULT_BANK.len() < 2_000_000, "{} bytes", DEFAULT_BANK.len());
    }
}
