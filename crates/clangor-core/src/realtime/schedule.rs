//! Items in the order of their times.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A queue of items with a time: the earliest first; at equal times, the one added first.
pub(super) struct Schedule<T> {
    waiting: BinaryHeap<Waiting<T>>,
    most: usize,
    added: u64,
}

struct Waiting<T> {
    sample: i64,
    order: u64,
    item: T,
}

impl<T> Schedule<T> {
    /// An empty queue of this capacity.
    pub(super) fn new(most: usize) -> Self {
        Schedule { waiting: BinaryHeap::with_capacity(most), most, added: 0 }
    }

    /// Adds an item of this time \[samples\]; returns it if the queue is full.
    pub(super) fn add(&mut self, sample: i64, item: T) -> Result<(), T> {
        if self.is_full() {
            return Err(item);
        }
        self.added += 1;
        self.waiting.push(Waiting { sample, order: self.added, item });
        Ok(())
    }

    /// Takes the first item, if it comes before a time \[samples\].
    pub(super) fn next_before(&mut self, sample: i64) -> Option<T> {
        self.waiting.peek().filter(|first| first.sample < sample)?;
        self.waiting.pop().map(|first| first.item)
    }

    /// Number of items.
    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Whether it is full.
    pub(super) fn is_full(&self) -> bool {
        self.len() == self.most
    }

    /// Drops all items.
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }
}

impl<T> Ord for Waiting<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap yields its largest item first.
        (other.sample, other.order).cmp(&(self.sample, self.order))
    }
}

impl<T> PartialOrd for Waiting<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> PartialEq for Waiting<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T> Eq for Waiting<T> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_earliest_comes_first_and_no_more_than_there_is_room_for() {
        let mut schedule = Schedule::new(3);
        assert!([(5, 'a'), (2, 'b'), (5, 'c')].into_iter().all(|(t, x)| schedule.add(t, x).is_ok()));
        assert_eq!(schedule.add(1, 'd'), Err('d'));
        let taken: String = std::iter::from_fn(|| schedule.next_before(6)).collect();
        assert_eq!(taken, "bac");
        schedule.add(7, 'e').unwrap();
        assert_eq!(schedule.next_before(7), None);
    }
}
