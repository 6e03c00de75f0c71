//! How much a block may compute, so that it always ends in time.

/// Work allowed in 128 samples; longer blocks may do as much more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Waves of clicks, of which each receiver and reflection is one. About 5 µs each on a desktop processor.
    pub waves: usize,
    /// Impacts on ringing objects, about 20 µs each. More wait for the next blocks, up to 30 ms.
    pub impacts: usize,
    /// Modes that ring, times the ways and receivers by which each is heard.
    pub mode_paths: usize,
    /// Coefficients of transfers that follow the motion of bodies and receivers, about 1 ns each; objects
    /// that begin to ring may take four times as many.
    pub transfers: usize,
}

impl Default for Budget {
    /// For one core of a desktop processor, little more than half busy at worst.
    fn default() -> Self {
        Budget { waves: 100, impacts: 16, mode_paths: 12_000, transfers: 100_000 }
    }
}

impl Budget {
    /// For so many samples.
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
