//! Checks of numbers and arrays that every kind of sound model file makes.

use crate::sound_model::files::tensor_file::{TensorFileError, check_finite};

/// Least and greatest bounding radius \[m\].
pub(crate) const RADII: std::ops::RangeInclusive<f64> = 1e-7..=1e4;

/// Rejects a number that is not positive and finite.
pub(crate) fn positive(what: &str, number: f64) -> Result<(), TensorFileError> {
    if number > 0.0 && number.is_finite() {
        return Ok(());
    }
    Err(TensorFileError::value(what, format!("is {number}, not a finite number above 0")))
}

/// Rejects an array of the wrong length, or with numbers that are not finite.
pub(crate) fn check_count(name: &str, numbers: &[f32], count: usize) -> Result<(), TensorFileError> {
    if numbers.len() != count {
        return Err(TensorFileError::Shape {
            name: name.into(),
            found: format!("of {} numbers", numbers.len()),
            expected: format!("of {count}"),
        });
    }
    check_finite(name, numbers)
}
