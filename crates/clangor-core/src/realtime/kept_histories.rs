//! Force histories that the engine may refer to, kept by the controller.
//!
//! The audio thread must not free a history. It gets a copy, of which the controller holds a reference until
//! the engine has none left. The copy is the engine's own, so that a sender who keeps its histories does not
//! count. The engine also owns the list, in case that it outlives the controller.

use std::sync::{Arc, Mutex, PoisonError};

use crate::contact::ForceHistory;

/// Largest number of histories in the engine at once.
const MOST: usize = 4096;
/// Least number of histories at which those that the engine has left are looked for.
const LEAST: usize = 64;

/// See the module.
#[derive(Clone, Default)]
pub(super) struct KeptHistories(Arc<Mutex<List>>);

/// Histories in the order of their addresses.
#[derive(Default)]
struct List {
    entries: Vec<Entry>,
    /// Number of entries at which those that the engine has left are looked for next.
    full: usize,
}

struct Entry {
    /// The sender's history; held, so that no other one gets its address.
    source: Arc<ForceHistory>,
    copy: Arc<ForceHistory>,
}

impl KeptHistories {
    /// The copy of a history for the engine, the same for all events with this history; `None` if the engine
    /// has too many.
    pub(super) fn sent(&self, source: &Arc<ForceHistory>) -> Option<Arc<ForceHistory>> {
        // Only the sender's threads lock; the audio thread never does.
        self.0.lock().unwrap_or_else(PoisonError::into_inner).sent(source)
    }
}

impl List {
    fn sent(&mut self, source: &Arc<ForceHistory>) -> Option<Arc<ForceHistory>> {
        if self.entries.len() >= self.full.max(LEAST) {
            // Only the engine makes further references of a copy: none is made after the last one is gone.
            self.entries.retain(|entry| Arc::strong_count(&entry.copy) > 1);
            self.full = (2 * self.entries.len()).min(MOST);
        }
        let address = Arc::as_ptr(source);
        match self.entries.binary_search_by_key(&address, |entry| Arc::as_ptr(&entry.source)) {
            Ok(at) => Some(Arc::clone(&self.entries[at].copy)),
            Err(_) if self.entries.len() >= MOST => None,
            Err(at) => {
                let copy = Arc::new(ForceHistory::clone(source));
                let entry = Entry { source: Arc::clone(source), copy: Arc::clone(&copy) };
                self.entries.insert(at, entry);
                Some(copy)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histories_are_kept_until_the_engine_has_left_them() {
        let history = |k: usize| Arc::new(ForceHistory::restored(0.0, 1e-5, vec![1.0 + k as f64]).unwrap());
        let kept = KeptHistories::default();
        let sources: Vec<_> = (0..MOST + 1).map(history).collect();
        let mut copies: Vec<_> = sources[..MOST].iter().map(|source| kept.sent(source).unwrap()).collect();
        // The same copy for a history that is there, and no room for another one.
        assert!(Arc::ptr_eq(&kept.sent(&sources[7]).unwrap(), &copies[7]));
        assert!(kept.sent(&sources[MOST]).is_none());
        let watched = Arc::downgrade(&copies[9]);
        drop(copies.remove(9));
        assert_eq!(watched.strong_count(), 1);
        let last = kept.sent(&sources[MOST]).unwrap();
        assert_eq!((watched.strong_count(), Arc::strong_count(&sources[9])), (0, 1));
        drop(kept);
        assert_eq!((Arc::strong_count(&last), Arc::strong_count(&copies[0])), (1, 1));
    }
}
