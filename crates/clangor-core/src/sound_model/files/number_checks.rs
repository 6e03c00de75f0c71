//! Checks of numbers and arrays that every kind of sound model file makes.

use crate::quantity::{self, Quantity, readable};
use crate::sound_model::files::tensor_file::TensorFileError;

/// Least and greatest bounding radius \[m\].
pub(crate) const RADII: std::ops::RangeInclusive<f64> = 1e-7..=1e4;

/// Rejects a number outside the range of its quantity.
pub(crate) fn within(what: &str, number: f64, range: &Quantity) -> Result<(), TensorFileError> {
    if range.admits(number) {
        return Ok(());
    }
    let expected = if number.is_finite() { range.expected() } else { "finite".into() };
    Err(TensorFileError::value(what, format!("is {}, not {expected}", readable(number))))
}

/// Rejects an array with numbers outside the range of their quantity.
pub(crate) fn all_within<T: Copy + Into<f64>>(
    name: &str,
    numbers: &[T],
    range: &Quantity,
) -> Result<(), TensorFileError> {
    let outside = numbers.iter().enumerate().find(|(_, number)| !range.admits((**number).into()));
    outside.map_or(Ok(()), |(at, number)| {
        within(&format!("number {at} of the array \"{name}\""), (*number).into(), range)
    })
}

/// Rejects an array of the wrong length, or with numbers that are no components of a field.
pub(crate) fn check_count(name: &str, numbers: &[f32], count: usize) -> Result<(), TensorFileError> {
    if numbers.len() != count {
        return Err(TensorFileError::Shape {
            name: name.into(),
            found: format!("of {} numbers", numbers.len()),
            expected: format!("of {count}"),
        });
    }
    all_within(name, numbers, &quantity::COMPONENT)
}
