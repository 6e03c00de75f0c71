//! Impulses of lasting contacts that wait for the next sample of the log.

use clangor_core::timeline::ContactRow;

/// Impulses of a ball's lasting contacts since the last sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Pending {
    /// Plane (or `LINK` + number of the link in the island) and row.
    pub(super) rows: Vec<(usize, ContactRow)>,
    /// Time up to which they are summed \[s\].
    pub(super) until: f64,
}

impl Pending {
    /// The row of a contact, made by `new` if there is none yet.
    pub(super) fn row(&mut self, key: usize, new: impl FnOnce() -> ContactRow) -> &mut ContactRow {
        let at = self.rows.iter().position(|(k, _)| *k == key).unwrap_or_else(|| {
            self.rows.push((key, new()));
            self.rows.len() - 1
        });
        &mut self.rows[at].1
    }
}
