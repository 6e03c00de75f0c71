//! Tables that other programs write: separated values (`.csv`), JSON lines (`.jsonl`) and Parquet
//! (`.parquet`), as rows of texts and numbers.
//!
//! A vector in JSON becomes columns with the endings `_x`, `_y`, `_z` and `_w`. Parquet is read with the
//! codecs uncompressed, Snappy, gzip, LZ4 (raw), Zstandard and Brotli, and with any widths of numbers.

mod parquet_rows;

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use crate::formats::calendar_times::SECONDS;
use crate::formats::column_names::meant;
use crate::formats::separated_values::{SeparatedValues, values_of};

/// Column of the numbers of rows that pandas writes to Parquet, and that other files get from there.
pub(super) const PANDAS_INDEX: &str = "__index_level_0__";
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

/// Most rows of a table that is kept in memory: poses of an hour of 23 bodies at 240 Hz, which take 4 GB.
pub const MAX_ROWS: u64 = 20_000_000;
/// Longest line of a text \[bytes\].
const MAX_LINE: u64 = 1 << 20;

/// Takes the rows of a table, one at a time: no table is kept in memory.
pub(crate) trait RowSink {
    /// What can go wrong with a row.
    type Error: From<RecordTableError>;

    /// Most rows that are taken.
    fn most_rows(&self) -> u64 {
        MAX_ROWS
    }

    /// Names of the columns that are wanted, each cell in their order.
    fn known(&self) -> &[&'static str];

    /// Whether a column that is not wanted may be there.
    fn is_ignored(&self, name: &str) -> bool;

    /// The page that lists the columns.
    fn document(&self) -> &'static str {
        "docs/format/timeline.md"
    }

    /// The names of the table's columns, and which of [`known`](Self::known) are there; of JSON lines, those
    /// of the first.
    fn columns(&mut self, names: &[String], present: &[bool]) -> Result<(), Self::Error>;

    /// A row: the line of a text from 1, or the row of a Parquet file from 0.
    fn row(&mut self, row: u64, cells: &[Cell]) -> Result<(), Self::Error>;
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
    /// A column that means nothing.
    #[error("{path}: column {column} is unknown; {document} lists the columns{remedy}")]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// The page that lists the columns.
        document: &'static str,
        /// The column that is likely meant, or nothing.
        remedy: String,
    },
    /// A column given twice.
    #[error("{path}: column {column} comes twice")]
    Twice {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// A column that holds dates or times of a clock.
    #[error("{path}: column {column} holds dates or times, no numbers{SECONDS}")]
    Calendar {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// A column that holds lists or records.
    #[error(
        "{path}: column {column} holds neither numbers nor texts; write one plain column for each component"
    )]
    ColumnType {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// A table that is too long.
    #[error("{path} has more than {most} rows; divide it, or leave out bodies and frames")]
    TooManyRows {
        /// The file.
        path: PathBuf,
        /// Most rows.
        most: u64,
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

/// Gives the rows of a table to `sink`; the extension tells the format.
///
/// # Errors
/// [`RecordTableError`] names the file and the line; and those of the sink.
pub(crate) fn read_rows<S: RowSink>(path: &Path, sink: &mut S) -> Result<(), S::Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "parquet" => parquet_rows::read(path, sink),
        "csv" => csv(path, sink),
        "jsonl" => jsonl(path, sink),
        _ => Err(RecordTableError::Extension { path: path.into() }.into()),
    }
}

/// Places of the columns of a file among those that are wanted. The sink learns which are there.
fn places<S: RowSink>(path: &Path, names: &[String], sink: &mut S) -> Result<Vec<Option<usize>>, S::Error> {
    let mut present = vec![false; sink.known().len()];
    let mut places = Vec::with_capacity(names.len());
    let mut unknown = None;
    for name in names {
        let place = sink.known().iter().position(|known| known == name);
        if let Some(place) = place {
            if std::mem::replace(&mut present[place], true) {
                return Err(RecordTableError::Twice { path: path.into(), column: name.clone() }.into());
            }
        } else if name != PANDAS_INDEX && !sink.is_ignored(name) {
            unknown = unknown.or(Some(name));
        }
        places.push(place);
    }
    // A missing column is reported first: an unknown one may be its misspelt name.
    sink.columns(names, &present)?;
    match unknown {
        Some(column) => Err(unknown_column(path, column, names, sink)),
        None => Ok(places),
    }
}

fn unknown_column<S: RowSink>(path: &Path, column: &str, names: &[String], sink: &S) -> S::Error {
    let free = sink.known().iter().copied().filter(|known| !names.iter().any(|name| name == known));
    let (remedy, column, document) = (meant(column, free), column.to_owned(), sink.document());
    RecordTableError::Unknown { path: path.into(), column, document, remedy }.into()
}

/// The lines of a text that are neither empty nor a remark, with their numbers.
struct Lines<'a> {
    path: &'a Path,
    file: BufReader<File>,
    line: Vec<u8>,
    number: u64,
    /// Bytes before this line.
    before: usize,
    /// Most lines.
    most: u64,
}

impl<'a> Lines<'a> {
    fn open(path: &'a Path, most: u64) -> Result<Self, RecordTableError> {
        let file = File::open(path).map_err(|source| RecordTableError::Io { path: path.into(), source })?;
        Ok(Lines { path, file: BufReader::new(file), line: Vec::new(), number: 0, before: 0, most })
    }

    fn next(&mut self) -> Result<Option<(u64, &str)>, RecordTableError> {
        let path = self.path;
        loop {
            self.before += self.line.len();
            self.line.clear();
            let read = (&mut self.file).take(MAX_LINE).read_until(b'\n', &mut self.line);
            if read.map_err(|source| RecordTableError::Io { path: path.into(), source })? == 0 {
                return Ok(None);
            }
            self.number += 1;
            if self.line.len() as u64 == MAX_LINE {
                let reason = format!("the line is longer than {MAX_LINE} bytes");
                return Err(RecordTableError::Line { path: path.into(), line: self.number, reason });
            }
            if self.number > self.most {
                return Err(RecordTableError::TooManyRows { path: path.into(), most: self.most });
            }
            let text = str::from_utf8(&self.line).map_err(|error| RecordTableError::NotText {
                path: path.into(),
                at: self.before + error.valid_up_to(),
            })?;
            // Editors of one system put a mark before the text.
            let text = if self.number == 1 { text.strip_prefix('\u{FEFF}').unwrap_or(text) } else { text };
            if !text.trim().is_empty() && !text.starts_with('#') {
                break;
            }
        }
        let text = str::from_utf8(&self.line).unwrap_or_default();
        let text = if self.number == 1 { text.strip_prefix('\u{FEFF}').unwrap_or(text) } else { text };
        Ok(Some((self.number, text.strip_suffix('\n').map_or(text, |t| t.strip_suffix('\r').unwrap_or(t)))))
    }
}

fn csv<S: RowSink>(path: &Path, sink: &mut S) -> Result<(), S::Error> {
    let mut lines = Lines::open(path, sink.most_rows())?;
    let mut header: Option<(SeparatedValues, Vec<Option<usize>>)> = None;
    let mut cells = vec![Cell::Empty; sink.known().len()];
    while let Some((row, line)) = lines.next()? {
        let wrong = |reason: String| RecordTableError::Line { path: path.into(), line: row, reason };
        let Some((lines, places)) = &mut header else {
            let (lines, names) =
                SeparatedValues::of_header(line).map_err(|fault| wrong(fault.to_string()))?;
            header = Some((lines, places(path, &names, sink)?));
            continue;
        };
        let values = lines.next(line, row).map_err(|fault| wrong(fault.to_string()))?;
        if values.len() != places.len() {
            let (found, expected) = (values_of(values.len()), places.len());
            return Err(wrong(format!("{found}, but the header has {expected} columns")).into());
        }
        for (value, place) in values.into_iter().zip(places.iter()) {
            if let Some(place) = place {
                cells[*place] = cell(value);
            }
        }
        sink.row(row, &cells)?;
    }
    Ok(())
}

/// The column decides whether a text is a number: a body may be called `01`.
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

fn jsonl<S: RowSink>(path: &Path, sink: &mut S) -> Result<(), S::Error> {
    let mut lines = Lines::open(path, sink.most_rows())?;
    let mut is_first = true;
    let mut cells = vec![Cell::Empty; sink.known().len()];
    while let Some((row, line)) = lines.next()? {
        let fields: serde_json::Map<String, serde_json::Value> =
            serde_json::from_str(line).map_err(|error| RecordTableError::Line {
                path: path.into(),
                line: row,
                reason: format!("at column {}: the line is no JSON object", error.column()),
            })?;
        let (names, values): (Vec<String>, Vec<Cell>) =
            fields.into_iter().flat_map(|(name, value)| flattened(name, value)).unzip();
        if std::mem::take(&mut is_first) {
            places(path, &names, sink)?;
        }
        cells.fill(Cell::Empty);
        for (name, value) in names.iter().zip(values) {
            match sink.known().iter().position(|known| known == name) {
                Some(place) => cells[place] = value,
                None if name == PANDAS_INDEX || sink.is_ignored(name) => {}
                None => return Err(unknown_column(path, name, &names, sink)),
            }
        }
        sink.row(row, &cells)?;
    }
    Ok(())
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
