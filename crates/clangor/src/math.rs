//! Mathematics that more than one module needs.

pub(crate) mod bessel;
pub mod random;
