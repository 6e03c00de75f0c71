//! Errors of the published representation of acceleration noise relative to the fitted field.

pub mod errors;
pub mod solved_field;
