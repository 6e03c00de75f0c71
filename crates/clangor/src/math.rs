//! Special functions that more than one module needs.

pub(crate) mod bessel;
