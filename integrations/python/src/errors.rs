//! Errors of Clangor as Python exceptions, with the same text.

use std::error::Error;

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(clangor, ClangorError, PyException, "What cannot be simulated, baked, rendered or read.");

/// An exception with the text of an error.
pub(crate) fn raised(error: impl Error) -> PyErr {
    ClangorError::new_err(error.to_string())
}
