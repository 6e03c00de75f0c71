//! Rows in the order of their times, although a contact is known only when it is over.
//!
//! A contact among several bodies lasts as long as its materials are soft: 0.2 ms between pool balls, a
//! millisecond and more on a cushion. Its rows have the time of its onset, so poses and rows of later times
//! wait until nothing earlier can follow. Memory is bounded by what happens during one contact.

use clangor_core::timeline::{ContactRow, PoseRow, TimelineSink};

enum Row {
    Contact(ContactRow),
    Pose(PoseRow),
}

impl Row {
    fn time(&self) -> f64 {
        match self {
            Row::Contact(row) => row.time,
            Row::Pose(row) => row.time,
        }
    }
}

/// Rows that wait for earlier ones.
pub(super) struct TimeOrder {
    /// Whether rows wait at all.
    waits: bool,
    held: Vec<Row>,
    /// Time of the earliest row that is held \[s\].
    earliest: f64,
}

impl Default for TimeOrder {
    fn default() -> Self {
        TimeOrder { waits: false, held: Vec::new(), earliest: f64::INFINITY }
    }
}

impl TimeOrder {
    /// Takes a contact row.
    pub(super) fn contact(&mut self, row: &ContactRow, sink: &mut dyn TimelineSink) -> std::io::Result<()> {
        if self.waits {
            self.hold(Row::Contact(*row));
            return Ok(());
        }
        sink.contact(row)
    }

    /// Takes a pose.
    pub(super) fn pose(&mut self, row: &PoseRow, sink: &mut dyn TimelineSink) -> std::io::Result<()> {
        if self.waits {
            self.hold(Row::Pose(*row));
            return Ok(());
        }
        sink.pose(row)
    }

    fn hold(&mut self, row: Row) {
        self.earliest = self.earliest.min(row.time());
        self.held.push(row);
    }

    /// Writes what is earlier than a time \[s\] before which no row may follow; later rows wait from now on.
    /// Rows of the same time keep their order.
    pub(super) fn release(&mut self, before: f64, sink: &mut dyn TimelineSink) -> std::io::Result<()> {
        self.waits = true;
        if self.earliest >= before {
            return Ok(());
        }
        self.held.sort_by(|a, b| a.time().total_cmp(&b.time()));
        let over = self.held.partition_point(|row| row.time() < before);
        self.earliest = self.held.get(over).map_or(f64::INFINITY, Row::time);
        self.held.drain(..over).try_for_each(|row| match row {
            Row::Contact(row) => sink.contact(&row),
            Row::Pose(row) => sink.pose(&row),
        })
    }
}
