//! Reading a table.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use clangor_core::body::Life;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::{BLOCK_ROWS, Order, parquet_error, parquet_type};
use crate::formats::timeline_file::columns::{Column, Field, TableRow};
use crate::formats::timeline_file::error::{RowProblem, TimelineError};
use crate::formats::timeline_file::hash::read_error;

/// Reads a table.
pub(in crate::formats::timeline_file) struct TableReader<R: TableRow> {
    path: PathBuf,
    file: SerializedFileReader<File>,
    columns: Vec<Column<R>>,
    /// Place of each column in the file.
    places: Vec<usize>,
    group: usize,
    readers: Vec<ColumnReader>,
    left_in_group: usize,
    block: Vec<R>,
    scratch: Scratch,
    rows: u64,
    order: Order,
    lives: Vec<Life>,
}

/// Buffers for one column's share of a block.
#[derive(Default)]
struct Scratch {
    f64: Vec<f64>,
    f32: Vec<f32>,
    i32: Vec<i32>,
    i64: Vec<i64>,
    levels: Vec<i16>,
}

impl<R: TableRow> TableReader<R> {
    /// Opens the file and checks its columns and number of rows.
    pub(in crate::formats::timeline_file) fn open(
        path: &Path,
        promised: u64,
        lives: Vec<Life>,
        slack: f64,
    ) -> Result<Self, TimelineError> {
        guarded(path, || Self::open_unguarded(path, promised, lives, slack))
    }

    fn open_unguarded(
        path: &Path,
        promised: u64,
        lives: Vec<Life>,
        slack: f64,
    ) -> Result<Self, TimelineError> {
        let file = File::open(path).map_err(|source| read_error(path, source))?;
        let file = SerializedFileReader::new(file).map_err(|e| parquet_error(path, &e))?;
        let metadata = file.metadata().file_metadata();
        let in_file = metadata.schema_descr();
        let mut places = Vec::new();
        let find =
            |column: &Column<R>| in_file.columns().iter().position(|c| column.is_named(&c.path().string()));
        let is_there = |column: &Column<R>| !column.is_optional() || find(column).is_some();
        let columns: Vec<Column<R>> = R::columns().into_iter().filter(is_there).collect();
        for column in &columns {
            let place = find(column);
            let place =
                place.ok_or(TimelineError::MissingColumn { path: path.into(), column: column.name })?;
            let found = in_file.column(place);
            let (physical, _, expected) = parquet_type(&column.field);
            if found.physical_type() != physical || found.max_rep_level() != 0 || found.max_def_level() > 1 {
                let found = format!("{:?}", found.physical_type());
                return Err(TimelineError::ColumnType {
                    path: path.into(),
                    column: column.name,
                    expected,
                    found,
                });
            }
            places.push(place);
        }
        let found = u64::try_from(metadata.num_rows()).unwrap_or(0);
        if found != promised {
            return Err(TimelineError::RowCount { path: path.into(), promised, found });
        }
        Ok(TableReader {
            path: path.into(),
            file,
            columns,
            places,
            group: 0,
            readers: Vec::new(),
            left_in_group: 0,
            block: Vec::new(),
            scratch: Scratch::default(),
            rows: 0,
            order: Order { latest: f64::NEG_INFINITY, slack },
            lives,
        })
    }

    /// The rows read last.
    pub(in crate::formats::timeline_file) fn block(&self) -> &[R] {
        &self.block
    }

    /// Whether the table has the optional column of this name.
    pub(in crate::formats::timeline_file) fn has_column(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column.name == name)
    }

    /// Reads the next rows; none at the end and after an error.
    pub(in crate::formats::timeline_file) fn next_block(&mut self) -> Result<(), TimelineError> {
        let path = self.path.clone();
        let result = guarded(&path, || self.read_block());
        if result.is_err() {
            self.block.clear();
        }
        result
    }

    fn read_block(&mut self) -> Result<(), TimelineError> {
        self.block.clear();
        while self.left_in_group == 0 {
            if self.group == self.file.num_row_groups() {
                return Ok(());
            }
            self.open_group().map_err(|e| parquet_error(&self.path, &e))?;
        }
        let rows = self.left_in_group.min(BLOCK_ROWS);
        self.block.resize(rows, R::BLANK);
        for (column, reader) in self.columns.iter().zip(&mut self.readers) {
            fill(column, reader, &mut self.block, &mut self.scratch).map_err(|fault| match fault {
                Fault::Parquet(e) => parquet_error(&self.path, &e),
                Fault::Row(index, problem) => {
                    TimelineError::Row { path: self.path.clone(), row: self.rows + index as u64, problem }
                }
            })?;
        }
        for (index, row) in self.block.iter().enumerate() {
            self.order.check(row.time()).and_then(|()| row.check(&self.lives)).map_err(|problem| {
                TimelineError::Row { path: self.path.clone(), row: self.rows + index as u64, problem }
            })?;
        }
        self.left_in_group -= rows;
        self.rows += rows as u64;
        Ok(())
    }

    fn open_group(&mut self) -> Result<(), ParquetError> {
        let group = self.file.get_row_group(self.group)?;
        self.readers = self.places.iter().map(|p| group.get_column_reader(*p)).collect::<Result<_, _>>()?;
        self.left_in_group = usize::try_from(group.metadata().num_rows())
            .map_err(|_| ParquetError::General("a row group has a negative number of rows".into()))?;
        self.group += 1;
        Ok(())
    }
}

/// Turns a panic of the decoder into an error: it has assertions that damaged tables without a hash can
/// break. What it was reading is not used again.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, TimelineError>) -> Result<T, TimelineError> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| {
        let reason = "its structure contradicts itself".into();
        Err(TimelineError::Parquet { path: path.into(), reason })
    })
}

/// What can go wrong with a column of a block.
enum Fault {
    Parquet(ParquetError),
    Row(usize, RowProblem),
}

impl From<ParquetError> for Fault {
    fn from(error: ParquetError) -> Self {
        Fault::Parquet(error)
    }
}

/// Sets the field behind a column in every row of a block.
fn fill<R: TableRow>(
    column: &Column<R>,
    reader: &mut ColumnReader,
    block: &mut [R],
    scratch: &mut Scratch,
) -> Result<(), Fault> {
    let Scratch { f64, f32, i32, i64, levels } = scratch;
    let (rows, name) = (block.len(), column.name);
    match (&column.field, reader) {
        (Field::F64(_, set), ColumnReader::DoubleColumnReader(reader)) => {
            read_values(name, reader, rows, f64, levels)?;
            for (index, (row, value)) in block.iter_mut().zip(&*f64).enumerate() {
                finite(name, index, *value)?;
                set(row, *value);
            }
        }
        (Field::F32(_, set), ColumnReader::FloatColumnReader(reader)) => {
            read_values(name, reader, rows, f32, levels)?;
            for (index, (row, value)) in block.iter_mut().zip(&*f32).enumerate() {
                finite(name, index, f64::from(*value))?;
                set(row, f64::from(*value));
            }
        }
        (Field::OptionalF32(_, set), ColumnReader::FloatColumnReader(reader)) => {
            read_present(name, reader, rows, f32, levels)?;
            let mut values = f32.iter();
            for (index, row) in block.iter_mut().enumerate() {
                // A required column has no levels.
                let is_null = levels.get(index) == Some(&0);
                let value = if is_null { None } else { values.next().copied() };
                let value = value.filter(|value| !value.is_nan() && *value != 0.0);
                set(row, value.map(f64::from));
            }
        }
        (Field::U32(_, set), ColumnReader::Int32ColumnReader(reader)) => {
            read_values(name, reader, rows, i32, levels)?;
            for (row, value) in block.iter_mut().zip(&*i32) {
                set(row, value.cast_unsigned());
            }
        }
        (Field::Kind(_, set), ColumnReader::Int32ColumnReader(reader)) => {
            read_values(name, reader, rows, i32, levels)?;
            for (index, (row, code)) in block.iter_mut().zip(&*i32).enumerate() {
                if !u8::try_from(*code).is_ok_and(|code| set(row, code)) {
                    return Err(Fault::Row(index, RowProblem::Kind { code: *code }));
                }
            }
        }
        (Field::U64(_, set), ColumnReader::Int64ColumnReader(reader)) => {
            read_values(name, reader, rows, i64, levels)?;
            for (row, value) in block.iter_mut().zip(&*i64) {
                set(row, value.cast_unsigned());
            }
        }
        _ => return Err(ParquetError::General(format!("column {name} changes its type")).into()),
    }
    Ok(())
}

fn finite(column: &'static str, index: usize, value: f64) -> Result<(), Fault> {
    if value.is_finite() { Ok(()) } else { Err(Fault::Row(index, RowProblem::NotFinite { column, value })) }
}

/// Reads exactly `rows` values.
fn read_values<T: DataType>(
    column: &'static str,
    reader: &mut ColumnReaderImpl<T>,
    rows: usize,
    values: &mut Vec<T::T>,
    levels: &mut Vec<i16>,
) -> Result<(), Fault> {
    if read_present(column, reader, rows, values, levels)? != rows {
        let index = levels.iter().position(|level| *level == 0).unwrap_or(0);
        return Err(Fault::Row(index, RowProblem::Null { column }));
    }
    Ok(())
}

/// Reads the values of `rows` rows that are not null, and how many these are.
fn read_present<T: DataType>(
    column: &'static str,
    reader: &mut ColumnReaderImpl<T>,
    rows: usize,
    values: &mut Vec<T::T>,
    levels: &mut Vec<i16>,
) -> Result<usize, Fault> {
    values.clear();
    levels.clear();
    let (records, present, _) = reader.read_records(rows, Some(levels), None, values)?;
    if records != rows {
        return Err(ParquetError::General(format!("column {column} is shorter than others")).into());
    }
    Ok(present)
}
