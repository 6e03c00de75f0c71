//! Force histories as rows: each has the time grid of its history, and up to [`SAMPLES_PER_ROW`] samples.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use super::{BODY, COUNT, FIRST, FORCE_HISTORY, HISTORY, KIND, ROW, SAMPLES, START, STEP, TIME};
use crate::contact::ForceHistory;

/// Samples in a row.
pub const SAMPLES_PER_ROW: usize = BODY - SAMPLES;
/// Most samples of a history.
const MOST_SAMPLES: usize = 1 << 16;
/// Most samples that a [`ForceTable`] keeps: 32 MiB.
const MOST_KEPT: usize = 1 << 22;

/// The number of a history, a positive integer: a hash of its content.
pub(super) fn number_of(history: &ForceHistory) -> f64 {
    let numbers = [history.start(), history.step()];
    let hash = numbers.iter().chain(history.values()).fold(0xcbf2_9ce4_8422_2325_u64, |hash, number| {
        let mixed = (hash ^ number.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 32)
    });
    // As many bits as a number of the row holds.
    (hash >> 12) as f64 + 1.0
}

/// The rows of a history for an impact of a time \[s\] on a body with this number.
pub(super) fn rows(history: &ForceHistory, time: f64, body: u32) -> impl Iterator<Item = [f64; ROW]> + '_ {
    let number = number_of(history);
    let parts = history.values().chunks(SAMPLES_PER_ROW).enumerate();
    parts.map(move |(index, samples)| {
        let mut row = [0.0; ROW];
        (row[KIND], row[TIME], row[BODY]) = (FORCE_HISTORY, time, f64::from(body));
        (row[HISTORY], row[COUNT]) = (number, history.values().len() as f64);
        (row[START], row[STEP]) = (history.start(), history.step());
        row[FIRST] = (index * SAMPLES_PER_ROW) as f64;
        row[SAMPLES..][..samples.len()].copy_from_slice(samples);
        row
    })
}

/// The latest histories by number.
#[derive(Debug, Default)]
pub(super) struct ForceTable {
    known: BTreeMap<u64, Entry>,
    /// Numbers and samples in the order of arrival.
    order: VecDeque<(u64, usize)>,
    /// Samples of all.
    samples: usize,
}

#[derive(Debug)]
enum Entry {
    Whole(Arc<ForceHistory>),
    /// The first samples of a history of so many.
    Partial(Vec<f64>, usize),
}

impl ForceTable {
    /// The history of a number.
    pub(super) fn history(&self, number: f64) -> Option<Arc<ForceHistory>> {
        match self.known.get(&number.to_bits()) {
            Some(Entry::Whole(history)) => Some(Arc::clone(history)),
            _ => None,
        }
    }

    /// Adds the samples of a row; whether they are a part of a history.
    pub(super) fn add(&mut self, row: &[f64; ROW]) -> bool {
        let [count, first] = [row[COUNT], row[FIRST]].map(|x| x as usize);
        let whole = [row[COUNT], row[FIRST], row[HISTORY]].iter().all(|x| x.fract() == 0.0 && *x >= 0.0);
        if !whole || first >= count || count > MOST_SAMPLES || first % SAMPLES_PER_ROW != 0 {
            return false;
        }
        let number = row[HISTORY].to_bits();
        if let Some(Entry::Whole(_)) = self.known.get(&number) {
            return true;
        }
        if first == 0 {
            self.begin(number, count);
        }
        // A history whose beginning or middle is missing is left out.
        let Some(Entry::Partial(values, whole)) = self.known.get_mut(&number) else { return false };
        if values.len() != first || *whole != count {
            return false;
        }
        values.extend_from_slice(&row[SAMPLES..][..SAMPLES_PER_ROW.min(count - first)]);
        if values.len() < count {
            return true;
        }
        let values = std::mem::take(values);
        match ForceHistory::restored(row[START], row[STEP], values) {
            Some(history) => self.known.insert(number, Entry::Whole(Arc::new(history))).is_some(),
            None => false,
        }
    }

    /// Begins a history, for which the oldest ones make room.
    fn begin(&mut self, number: u64, count: usize) {
        if let Some(Entry::Partial(values, _)) = self.known.get_mut(&number) {
            return values.clear();
        }
        while self.samples + count > MOST_KEPT
            && let Some((oldest, samples)) = self.order.pop_front()
        {
            self.known.remove(&oldest);
            self.samples -= samples;
        }
        self.known.insert(number, Entry::Partial(Vec::with_capacity(count), count));
        self.order.push_back((number, count));
        self.samples += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_histories_make_room() {
        let history = |k: usize| {
            let values = (0..40_000).map(|n| 1.0 + (n + k) as f64).collect();
            ForceHistory::restored(0.0, 1e-5, values).unwrap()
        };
        let mut table = ForceTable::default();
        let numbers: Vec<f64> = (0..120)
            .map(|k| {
                let history = history(k);
                assert!(rows(&history, 0.0, 0).all(|row| table.add(&row)));
                number_of(&history)
            })
            .collect();
        assert!(table.samples <= MOST_KEPT && table.known.len() == table.order.len());
        // Residual seen: 104 of 120.
        let kept = MOST_KEPT / 40_000;
        let known: Vec<bool> = numbers.iter().map(|number| table.history(*number).is_some()).collect();
        assert_eq!(known, (0..120).map(|k| k >= 120 - kept).collect::<Vec<_>>());
    }
}
