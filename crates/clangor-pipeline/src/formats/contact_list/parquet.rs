//! Contacts of a Parquet file, whose columns are those of CSV.

use std::path::Path;

use super::csv::{COLUMNS, parse_entry};
use super::{ContactListError, Entry, LineFault, Parsed};
use crate::formats::record_table::{Cell, RecordTableError, RowSink, read_rows};

/// The outer error is that of the file, the inner one that of a row.
pub(super) fn parse(path: &Path) -> Result<Parsed, ContactListError> {
    let known = COLUMNS.map(|(name, _)| name);
    let mut rows = Rows { known, entries: Vec::new() };
    match read_rows(path, &mut rows) {
        Ok(()) => Ok(Ok(rows.entries)),
        Err(Fault::Row(row, fault)) => Ok(Err((row, fault))),
        Err(Fault::Table(error)) => Err(error.into()),
    }
}

struct Rows {
    known: [&'static str; COLUMNS.len()],
    entries: Vec<(usize, Entry)>,
}

enum Fault {
    Table(RecordTableError),
    Row(usize, LineFault),
}

impl From<RecordTableError> for Fault {
    fn from(error: RecordTableError) -> Self {
        Fault::Table(error)
    }
}

impl RowSink for Rows {
    type Error = Fault;

    fn known(&self) -> &[&'static str] {
        &self.known
    }

    fn is_ignored(&self, _: &str) -> bool {
        false
    }

    fn columns(&mut self, _: &[bool]) -> Result<(), Fault> {
        Ok(())
    }

    fn row(&mut self, row: u64, cells: &[Cell]) -> Result<(), Fault> {
        let text = |cell: &Cell| match cell {
            Cell::Empty => String::new(),
            Cell::Number(number) => number.to_string(),
            Cell::Text(text) => text.clone(),
        };
        let (row, values) = (row as usize, cells.iter().map(text).collect::<Vec<_>>());
        self.entries.push((row, parse_entry(&COLUMNS, &values).map_err(|fault| Fault::Row(row, fault))?));
        Ok(())
    }
}
