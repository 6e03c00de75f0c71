//! Contacts of a Parquet file, whose columns are those of CSV.

use std::path::Path;

use super::csv::{COLUMNS, parse_entry, remedy};
use super::{ContactListError, Entries, LineFault, Parsed};
use crate::formats::record_table::{Cell, PANDAS_INDEX, RecordTableError, RowSink, read_rows};

/// The outer error is that of the file, the inner one that of a row.
pub(super) fn parse(path: &Path) -> Result<Parsed, ContactListError> {
    let known = COLUMNS.map(|(name, _)| name);
    let mut rows = Rows { path, known, entries: Entries::default() };
    match read_rows(path, &mut rows) {
        Ok(()) => Ok(Ok(rows.entries)),
        Err(Fault::Row(row, fault)) => Ok(Err((row, fault))),
        Err(Fault::Table(error)) => Err(error.into()),
    }
}

struct Rows<'a> {
    path: &'a Path,
    known: [&'static str; COLUMNS.len()],
    entries: Entries,
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

impl RowSink for Rows<'_> {
    type Error = Fault;

    fn known(&self) -> &[&'static str] {
        &self.known
    }

    fn is_ignored(&self, _: &str) -> bool {
        false
    }

    fn columns(&mut self, names: &[String], present: &[bool]) -> Result<(), Fault> {
        self.entries.columns =
            self.known.into_iter().zip(present).filter_map(|(n, is)| is.then_some(n)).collect();
        match names.iter().find(|name| !self.known.contains(&name.as_str()) && *name != PANDAS_INDEX) {
            Some(column) => {
                let (remedy, document) = (remedy(column, names), self.document());
                let (path, column) = (self.path.into(), column.clone());
                Err(RecordTableError::Unknown { path, column, document, remedy }.into())
            }
            None => Ok(()),
        }
    }

    fn row(&mut self, row: u64, cells: &[Cell]) -> Result<(), Fault> {
        let text = |cell: &Cell| match cell {
            Cell::Empty => String::new(),
            Cell::Number(number) => number.to_string(),
            Cell::Text(text) => text.clone(),
        };
        let (row, values) = (row as usize, cells.iter().map(text).collect::<Vec<_>>());
        self.entries
            .rows
            .push((row, parse_entry(&COLUMNS, &values).map_err(|fault| Fault::Row(row, fault))?));
        Ok(())
    }
}
