//! Counts of events by outcome, readable from other threads.

use std::sync::atomic::{AtomicU64, Ordering};

/// Counts of events by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Impacts, poses and ends taken.
    pub taken: u64,
    /// Events for which the ring had no room.
    pub lost: u64,
    /// Events with numbers that are not finite or out of range, of unknown objects, or too far ahead.
    pub refused: u64,
    /// Impacts that arrived too late and were rendered as soon as possible, and delays of impacts beyond the
    /// budget of a block.
    pub late: u64,
    /// Impacts with the engine's profile in place of a history that is too long, or one of too many.
    pub simplified: u64,
    /// Rendered waves of acceleration pulses.
    pub waves: u64,
    /// Waves left out because their path exceeds the reach.
    pub distant: u64,
    /// Waves, and impacts on modal objects, left out because the budget was exhausted.
    pub shed: u64,
    /// Waves left out likewise, but 80 dB below another wave of the block.
    pub masked: u64,
    /// Waves left out because the receiver is inside the body.
    pub inside: u64,
    /// Objects faded out because too many modes vibrated.
    pub shed_voices: u64,
    /// Audible modal objects.
    pub voices: u64,
    /// Vibrating modes.
    pub modes: u64,
    /// Largest pressure in the last block \[Pa\].
    pub peak: f64,
    /// Time of the sample rendered next \[s\].
    pub time: f64,
}

/// Number of fields of a [`Report`].
const COUNTS: usize = 15;

impl Report {
    fn to_numbers(self) -> [u64; COUNTS] {
        let Report { taken, lost, refused, late, waves, distant, shed, .. } = self;
        let Report { masked, inside, shed_voices, voices, modes, simplified, peak, time, .. } = self;
        let [peak, time] = [peak, time].map(f64::to_bits);
        let mut numbers = [0; COUNTS];
        numbers[..7].copy_from_slice(&[taken, lost, refused, late, waves, distant, shed]);
        numbers[7..].copy_from_slice(&[masked, inside, shed_voices, voices, modes, simplified, peak, time]);
        numbers
    }

    fn from_numbers(numbers: [u64; COUNTS]) -> Self {
        let [taken, lost, refused, late, waves, distant, shed, masked, inside, rest @ ..] = numbers;
        let [shed_voices, voices, modes, simplified, peak, time] = rest;
        let [peak, time] = [peak, time].map(f64::from_bits);
        let counts =
            Report { taken, lost, refused, late, waves, distant, shed, masked, inside, ..Report::default() };
        Report { shed_voices, voices, modes, simplified, peak, time, ..counts }
    }
}

/// A report that one thread writes and others read. Each number is consistent by itself; the numbers of one
/// reading may come from two writes.
#[derive(Debug, Default)]
pub(super) struct SharedReport([AtomicU64; COUNTS]);

impl SharedReport {
    /// Publishes a report.
    pub(super) fn write(&self, report: Report) {
        self.0.iter().zip(report.to_numbers()).for_each(|(shared, n)| shared.store(n, Ordering::Relaxed));
    }

    /// Reads the latest numbers.
    pub(super) fn read(&self) -> Report {
        Report::from_numbers(std::array::from_fn(|i| self.0[i].load(Ordering::Relaxed)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_report_is_read_unchanged() {
        let numbers = std::array::from_fn(|i| 3 + i as u64);
        let report = Report::from_numbers(numbers);
        assert_eq!(report.to_numbers(), numbers);
        let shared = SharedReport::default();
        shared.write(report);
        assert_eq!(shared.read(), report);
    }
}
