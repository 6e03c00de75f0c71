//! Origin and accuracy of the sound model in a file.

use serde::{Deserialize, Serialize};

use crate::quantity;
use crate::sound_model::files::number_checks::within;
use crate::sound_model::files::tensor_file::TensorFileError;

/// Origin and accuracy of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Program and version.
    pub program: String,
    /// Hash of geometry and options.
    pub inputs: String,
    /// Level error requested.
    pub asked_accuracy: f64,
    /// Solver, as text.
    pub method: String,
    /// Number of unknowns of the largest system, or of cells.
    pub unknowns: u64,
    /// Number of frequencies solved.
    pub solves: u64,
    /// Largest level error of the rational fit at frequencies outside the fit.
    pub held_out_error: f64,
    /// Notes for the user.
    pub warnings: Vec<String>,
}

/// Rejects invalid evidence.
pub(crate) fn check_origin(origin: &Origin) -> Result<(), TensorFileError> {
    within("the accuracy asked for", origin.asked_accuracy, &quantity::ACCURACY)?;
    if !(origin.held_out_error >= 0.0 && origin.held_out_error.is_finite()) {
        return Err(TensorFileError::value("the held-out error", "is not a finite number from 0"));
    }
    Ok(())
}
