//! The error of factors that do not fit in memory.

/// There is no memory for the factors of a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OutOfMemory {
    /// Number of unknowns.
    pub(crate) unknowns: usize,
}
