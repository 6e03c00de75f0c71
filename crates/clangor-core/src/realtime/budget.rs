//! Limits of the work of a block, so that each block ends in time.
//!
//! Impacts come in bursts. A device may ask for blocks of a few samples, whose share of the work is less than
//! one burst. Work not done in one block is therefore a [`Credit`] for the next ones. A block of less
//! than 128 samples may so take as long as one of 128: the buffers of the device must hold that long.

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
    /// At worst about two thirds of one core of a desktop processor, by the times of [`Budget`]. A disc that
    /// settles was seen to send 69 events in 256 samples: of several points, with a force over time each.
    fn default() -> Self {
        Budget { waves: 100, impacts: 48, mode_paths: 12_000, transfers: 100_000 }
    }
}

/// Length of the blocks to which the numbers of a [`Budget`] apply \[samples\].
const BLOCK: usize = 128;

impl Budget {
    /// The budget of a block of this length \[samples\].
    pub(super) fn of(&self, frames: usize) -> Budget {
        let share = |work: usize| work.saturating_mul(frames).div_ceil(BLOCK);
        Budget {
            waves: share(self.waves),
            impacts: share(self.impacts),
            mode_paths: self.mode_paths,
            transfers: share(self.transfers),
        }
    }
}

/// Work that bursts may cause now: what earlier blocks left, at most that of 128 samples or of one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Credit {
    pub(super) waves: usize,
    impacts: usize,
    /// Transfer coefficients of objects that start to vibrate.
    transfers: usize,
    /// Whether an object has started to vibrate in this block.
    woken: bool,
}

impl Credit {
    /// The credit of an engine that has not rendered yet.
    pub(super) fn of(budget: &Budget) -> Self {
        let Budget { waves, impacts, transfers, .. } = *budget;
        Credit { waves, impacts, transfers: 4 * transfers, woken: false }
    }

    /// Begins a block, of this many samples.
    pub(super) fn add(&mut self, budget: &Budget, frames: usize) {
        let (share, most) = (Credit::of(&budget.of(frames)), Credit::of(&budget.of(frames.max(BLOCK))));
        self.waves = (self.waves + share.waves).min(most.waves);
        self.impacts = (self.impacts + share.impacts).min(most.impacts);
        self.transfers = (self.transfers + share.transfers).min(most.transfers);
        self.woken = false;
    }

    /// Whether one more impact, which sets `transfers` coefficients, fits. The first object that starts to
    /// vibrate in a block always does.
    pub(super) fn allows(&self, transfers: usize) -> bool {
        self.impacts > 0 && (transfers <= self.transfers || !self.woken)
    }

    /// Uses up the work of an impact, in impacts with a closed profile, and its `transfers`.
    pub(super) fn spend(&mut self, impacts: usize, transfers: usize) {
        self.impacts = self.impacts.saturating_sub(impacts);
        self.transfers = self.transfers.saturating_sub(transfers);
        self.woken |= transfers > 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_blocks_save_their_work_for_a_burst() {
        let budget = Budget { impacts: 16, waves: 100, ..Budget::default() };
        let mut credit = Credit::of(&budget);
        for _ in 0..3 {
            // A burst takes what 128 samples may cause, and no more.
            for _ in 0..16 {
                assert!(credit.allows(0));
                credit.spend(1, 0);
            }
            assert!(!credit.allows(0));
            for _ in 0..128 {
                credit.add(&budget, 1);
            }
        }
        // Nothing is saved beyond that; a long block has its own work.
        credit.add(&budget, 128);
        assert_eq!((credit.impacts, credit.waves), (16, 100));
        credit.add(&budget, 512);
        assert_eq!((credit.impacts, credit.waves), (64, 400));
        credit.add(&budget, 128);
        assert_eq!((credit.impacts, credit.waves), (16, 100));
    }
}
