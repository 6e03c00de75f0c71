//! Regressions: mistakes that were made once, and bad input, stay handled.

mod limits;
