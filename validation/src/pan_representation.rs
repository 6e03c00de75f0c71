//! Errors of the published representation of acceleration noise against the field that it was fitted to.

pub mod errors;
pub mod solved_field;
