//! Memory of matrices that are no longer used, for the next ones: fresh memory of a hundred megabytes for
//! each wavenumber costs a tenth of the time of its solution. As much as systems are solved at the same time,
//! until the solver is dropped.

use std::sync::{Mutex, PoisonError};

use num_complex::Complex32;

/// The unused memory; a clone has none.
#[derive(Debug, Default)]
pub(super) struct Spares(Mutex<Vec<Vec<Complex32>>>);

impl Clone for Spares {
    fn clone(&self) -> Self {
        Spares::default()
    }
}

impl Spares {
    /// A matrix of so many entries, of any values.
    pub(super) fn take(&self, entries: usize) -> Vec<Complex32> {
        let mut unused = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = unused.iter().position(|matrix| matrix.len() == entries);
        known.map_or_else(|| vec![Complex32::ZERO; entries], |place| unused.swap_remove(place))
    }

    /// Keeps the memory of a matrix.
    pub(super) fn keep(&self, matrix: Vec<Complex32>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(matrix);
    }
}
