//! Mathematics that more than one module needs.

pub(crate) mod bessel;
pub(crate) mod complex_root;
pub mod disjoint_sets;
pub(crate) mod elliptic;
pub(crate) mod hankel;
pub mod radial;
pub mod random;
pub mod spherical_harmonics;
