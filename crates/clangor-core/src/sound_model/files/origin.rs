//! How the sound model in a file was baked, and how good it is.

use serde::{Deserialize, Serialize};

use crate::sound_model::files::number_checks::positive;
use crate::sound_model::files::tensor_file::TensorFileError;

/// How a model was baked, and how good it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Program and version.
    pub program: String,
    /// Hash of geometry and options.
    pub inputs: String,
    /// Level error that was asked for.
    pub asked_accuracy: f64,
    /// Solver, in words.
    pub method: String,
    /// Unknowns of the largest system, or cells.
    pub unknowns: u64,
    /// Frequencies solved.
    pub solves: u64,
    /// Largest level error of the rational fit at frequencies that it had not seen.
    pub held_out_error: f64,
    /// What a user should know.
    pub warnings: Vec<String>,
}

/// Rejects invalid evidence.
pub(crate) fn check_origin(origin: &Origin) -> Result<(), TensorFileError> {
    positive("the accuracy asked for", origin.asked_accuracy)?;
    if !(origin.held_out_error >= 0.0 && origin.held_out_error.is_finite()) {
        return Err(TensorFileError::value("the held-out error", "is not a finite number from 0"));
    }
    Ok(())
}
