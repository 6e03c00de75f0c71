//! Tables that other programs write: comma-separated values (`.csv`), JSON lines (`.jsonl`) and Parquet
//! (`.parquet`), as rows of texts and numbers.
//!
//! A vector in JSON becomes columns with the endings `_x`, `_y`, `_z` and `_w`. Parquet is read with the
//! codecs uncompressed, Snappy, gzip, LZ4 (raw), Zstandard and Brotli, and with any widths of numbers.

mod parquet_rows;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::formats::contact_list::split_line;

/// Endings of names of vector components.
const COMPONENTS: [&str; 4] = ["_x", "_y", "_z", "_w"];

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Nothing.
    Empty,
    /// A number, finite or not.
    Number(f64),
    /// Anything else, as text.
    Text(String),
}

/// A row, and where it stands: the line of a text, or the row of a Parquet file from 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Line or row.
    pub row: u64,
    /// One for each column.
    pub cells: Vec<Cell>,
}

/// Columns and rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordTable {
    /// Names.
    pub columns: Vec<String>,
    /// In the order of the file.
    pub records: Vec<Record>,
}

/// Why a table could not be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordTableError {
    /// The operating system refused.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The extension names no format.
    #[error("{path} is no table that can be read; name it .csv, .jsonl or .parquet")]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// The bytes are not text.
    #[error("{path} is not UTF-8 text from byte {at} on; save it as UTF-8")]
    NotText {
        /// The file.
        path: PathBuf,
        /// Where the text ends.
        at: usize,
    },
    /// A line is wrong.
    #[error("{path}, line {line}: {reason}")]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong there.
        reason: String,
    },
    /// The Parquet data cannot be decoded.
    #[error("{path} is damaged or no Parquet file ({reason})")]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What the decoder met.
        reason: String,
    },
}

/// Reads a table; the extension tells the format.
///
/// # Errors
/// [`RecordTableError`] names the file and the line.
pub fn read_table(path: &Path) -> Result<RecordTable, RecordTableError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "parquet" => return parquet_rows::read(path),
        "csv" | "jsonl" => {}
        _ => return Err(RecordTableError::Extension { path: path.into() }),
    }
    let bytes = fs::read(path).map_err(|source| RecordTableError::Io { path: path.into(), source })?;
    let text = String::from_utf8(bytes)
        .map_err(|e| RecordTableError::NotText { path: path.into(), at: e.utf8_error().valid_up_to() })?;
    // Editors of one system put a mark before the text.
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(&text);
    let table = if extension == "csv" { csv(text) } else { jsonl(text) };
    table.map_err(|(line, reason)| RecordTableError::Line { path: path.into(), line, reason })
}

/// A line from 1, and what is wrong with it.
type LineError = (u64, String);

fn lines(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let numbered = text.lines().enumerate().map(|(index, line)| (index as u64 + 1, line));
    numbered.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'))
}

fn csv(text: &str) -> Result<RecordTable, LineError> {
    let mut table = RecordTable::default();
    for (row, line) in lines(text) {
        let values = split_line(line).map_err(|fault| (row, fault.to_string()))?;
        if table.columns.is_empty() {
            table.columns = values;
            continue;
        }
        if values.len() != table.columns.len() {
            let (found, expected) = (values.len(), table.columns.len());
            return Err((row, format!("there are {found} values, but the header has {expected} columns")));
        }
        table.records.push(Record { row, cells: values.into_iter().map(cell).collect() });
    }
    Ok(table)
}

/// Whether it is a number is told by its column: a body may be called `01`.
fn cell(text: String) -> Cell {
    if text.is_empty() { Cell::Empty } else { Cell::Text(text) }
}

impl Cell {
    /// The number, also where it is written as text.
    pub fn number(&self) -> Option<f64> {
        match self {
            Cell::Number(number) => Some(*number),
            Cell::Text(text) => text.parse().ok(),
            Cell::Empty => None,
        }
    }
}

fn jsonl(text: &str) -> Result<RecordTable, LineError> {
    let mut table = RecordTable::default();
    for (row, line) in lines(text) {
        let fields: serde_json::Map<String, serde_json::Value> = serde_json::from_str(line)
            .map_err(|error| (row, format!("at column {}: the line is no JSON object", error.column())))?;
        let mut cells = vec![Cell::Empty; table.columns.len()];
        for (name, value) in fields {
            for (name, cell) in flattened(name, value) {
                let place = table.columns.iter().position(|column| *column == name);
                let place = place.unwrap_or_else(|| {
                    table.columns.push(name);
                    cells.push(Cell::Empty);
                    table.columns.len() - 1
                });
                cells[place] = cell;
            }
        }
        table.records.push(Record { row, cells });
    }
    // Later lines may have brought new columns.
    let width = table.columns.len();
    table.records.iter_mut().for_each(|record| record.cells.resize(width, Cell::Empty));
    Ok(table)
}

fn flattened(name: String, value: serde_json::Value) -> Vec<(String, Cell)> {
    use serde_json::Value;
    let single = |value: Value| match value {
        Value::Null => Cell::Empty,
        Value::Number(number) => Cell::Number(number.as_f64().unwrap_or(f64::NAN)),
        Value::String(text) => Cell::Text(text),
        other => Cell::Text(other.to_string()),
    };
    match value {
        Value::Array(values) if values.len() <= COMPONENTS.len() => {
            let component = |(value, ending)| (format!("{name}{ending}"), single(value));
            values.into_iter().zip(COMPONENTS).map(component).collect()
        }
        value => vec![(name, single(value))],
    }
}
