//! Limits of the work of a block, so that each block ends in time.

/// Largest work in 128 samples; in longer blocks, in proportion to the length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Waves of acceleration pulses: one for each receiver and path. About 5 µs each on a desktop processor.
    pub waves: usize,
    /// Impacts on modal objects, about 20 µs each; one with a history of 5 ms counts for three. Further
    /// impacts are delayed by up to 30 ms.
    pub impacts: usize,
    /// Vibrating modes, times the paths and receivers of each.
    pub mode_paths: usize,
    /// Coefficients of transfers recomputed because bodies or receivers moved, about 1 ns each. Objects that
    /// start to vibrate may take four times as many.
    pub transfers: usize,
}

impl Default for Budget {
    /// Little more than half of one core of a desktop processor, at worst.
    fn default() -> Self {
        Budget { waves: 100, impacts: 16, mode_paths: 12_000, transfers: 100_000 }
    }
}

impl Budget {
    /// The budget of a block of this length \[samples\].
    pub(super) fn of(&self, frames: usize) -> Budget {
        let share = |work: usize| work.saturating_mul(frames).div_ceil(128);
        Budget {
            waves: share(self.waves),
            impacts: share(self.impacts),
            mode_paths: self.mode_paths,
            transfers: share(self.transfers),
        }
    }
}
