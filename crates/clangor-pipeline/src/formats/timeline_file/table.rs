//! A table of rows as Parquet, written and read a few thousand rows at a time.
//!
//! zstd over byte-stream-split floats and plain integers and times. Dictionaries, delta packing and plain
//! floats were measured on a settling pile and are larger: the rows of a step repeat those of the step
//! before, which zstd finds best where values keep whole bytes.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clangor_core::body::{BodyId, Life};
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};

use super::columns::{Column, Field, TableRow};
use super::description::TableFields;
use super::hash::{HashedFile, read_error};
use super::{RowProblem, TimelineError};

/// Rows of a row group: 64 MB of columns, few enough to keep in memory and enough to compress well.
const GROUP_ROWS: usize = 1 << 18;
/// Rows of a page.
const PAGE_ROWS: usize = 1 << 17;
/// Rows that are turned between row and column order at once: they fit the second-level cache.
const BLOCK_ROWS: usize = 1 << 10;

/// 3 % smaller than level 1 for a second of processor time in 17 million rows.
const ZSTD_LEVEL: i32 = 3;

/// The values of a column on their way to the file.
enum Values {
    F64(Vec<f64>),
    F32(Vec<f32>),
    I32(Vec<i32>),
    I64(Vec<i64>),
}

/// Checks that rows come in order of time, but for `slack`.
struct Order {
    latest: f64,
    slack: f64,
}

impl Order {
    fn check(&mut self, time: f64) -> Result<(), RowProblem> {
        if time < self.latest - self.slack {
            return Err(RowProblem::Order { time, latest: self.latest });
        }
        self.latest = self.latest.max(time);
        Ok(())
    }
}

/// Writes a table.
pub(super) struct TableWriter<R: TableRow> {
    path: PathBuf,
    file: SerializedFileWriter<BufWriter<HashedFile>>,
    columns: Vec<Column<R>>,
    block: Vec<R>,
    values: Vec<Values>,
    grouped: usize,
    rows: u64,
    order: Order,
    lives: Vec<Life>,
}

impl<R: TableRow> TableWriter<R> {
    /// Creates the file. `slack` is how far rows may be out of order \[s\].
    pub(super) fn create(path: &Path, lives: Vec<Life>, slack: f64) -> Result<Self, TimelineError> {
        let columns = R::columns();
        let level = ZstdLevel::try_new(ZSTD_LEVEL).map_err(|e| parquet_error(path, &e))?;
        let mut properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(level))
            .set_encoding(Encoding::BYTE_STREAM_SPLIT)
            .set_dictionary_enabled(false)
            .set_statistics_enabled(EnabledStatistics::None)
            .set_data_page_row_count_limit(PAGE_ROWS)
            .set_data_page_size_limit(8 * PAGE_ROWS);
        for column in &columns {
            let path = ColumnPath::from(column.name);
            if !matches!(column.field, Field::F32(..)) {
                properties = properties
                    .set_column_encoding(path.clone(), Encoding::PLAIN)
                    .set_column_statistics_enabled(path, EnabledStatistics::Chunk);
            }
        }
        let schema = Arc::new(schema(&columns).map_err(|e| parquet_error(path, &e))?);
        let file = File::create_new(path).map_err(|e| write_error(path, e))?;
        let file = SerializedFileWriter::new(
            BufWriter::new(HashedFile::new(file)),
            schema,
            Arc::new(properties.build()),
        )
        .map_err(|e| parquet_error(path, &e))?;
        let values = columns.iter().map(|c| empty(&c.field)).collect();
        let order = Order { latest: f64::NEG_INFINITY, slack };
        let block = Vec::with_capacity(BLOCK_ROWS);
        Ok(TableWriter { path: path.into(), file, columns, block, values, grouped: 0, rows: 0, order, lives })
    }

    /// Appends a row.
    pub(super) fn push(&mut self, row: &R) -> Result<(), TimelineError> {
        let checked = self.order.check(row.time()).and_then(|()| row.check(&self.lives));
        checked.map_err(|problem| self.row_error(self.rows, problem))?;
        self.block.push(row.stored());
        self.rows += 1;
        if self.block.len() == BLOCK_ROWS {
            self.turn_block()?;
            if self.grouped >= GROUP_ROWS {
                self.write_group()?;
            }
        }
        Ok(())
    }

    /// Rows so far.
    pub(super) fn rows(&self) -> u64 {
        self.rows
    }

    /// Takes note of a death, and of the births that come of it.
    pub(super) fn replace(&mut self, parent: BodyId, pieces: &[Life]) {
        if let (Some(parent), Some(piece)) = (self.lives.get_mut(parent.index()), pieces.first()) {
            parent.death = piece.birth;
        }
        self.lives.extend_from_slice(pieces);
    }

    /// Writes what is left and synchronises the file.
    pub(super) fn finish(mut self) -> Result<TableFields, TimelineError> {
        self.turn_block()?;
        if self.grouped > 0 {
            self.write_group()?;
        }
        let out = self.file.into_inner().map_err(|e| parquet_error(&self.path, &e))?;
        let file = out.into_inner().map_err(|e| write_error(&self.path, e.into_error()))?;
        let hash = file.finish().map_err(|e| write_error(&self.path, e))?;
        Ok(TableFields { rows: self.rows, hash: Some(hash) })
    }

    /// Moves the block of rows into the columns.
    fn turn_block(&mut self) -> Result<(), TimelineError> {
        let first = self.rows - self.block.len() as u64;
        for (column, values) in self.columns.iter().zip(&mut self.values) {
            let bad = match (&column.field, values) {
                (Field::F64(get, _), Values::F64(values)) => {
                    values.extend(self.block.iter().map(get));
                    values[self.grouped..].iter().position(|v| !v.is_finite())
                }
                (Field::F32(get, _), Values::F32(values)) => {
                    values.extend(self.block.iter().map(|row| get(row) as f32));
                    values[self.grouped..].iter().position(|v| !v.is_finite())
                }
                (Field::U32(get, _), Values::I32(values)) => {
                    values.extend(self.block.iter().map(|row| get(row).cast_signed()));
                    None
                }
                (Field::Kind(get, _), Values::I32(values)) => {
                    values.extend(self.block.iter().map(|row| i32::from(get(row))));
                    None
                }
                (Field::U64(get, _), Values::I64(values)) => {
                    values.extend(self.block.iter().map(|row| get(row).cast_signed()));
                    None
                }
                _ => unreachable!("`empty` made the values after the field"),
            };
            if let Some(index) = bad {
                let value = match column.field {
                    Field::F64(get, _) | Field::F32(get, _) => get(&self.block[index]),
                    _ => f64::NAN,
                };
                let problem = RowProblem::NotFinite { column: column.name, value };
                let row = first + index as u64;
                return Err(TimelineError::Row { path: self.path.clone(), row, problem });
            }
        }
        self.grouped += self.block.len();
        self.block.clear();
        Ok(())
    }

    fn write_group(&mut self) -> Result<(), TimelineError> {
        write_group(&mut self.file, &mut self.values).map_err(|e| parquet_error(&self.path, &e))?;
        self.grouped = 0;
        Ok(())
    }

    fn row_error(&self, row: u64, problem: RowProblem) -> TimelineError {
        TimelineError::Row { path: self.path.clone(), row, problem }
    }
}

fn write_group<W: Write + Send>(
    file: &mut SerializedFileWriter<W>,
    values: &mut [Values],
) -> Result<(), ParquetError> {
    let mut group = file.next_row_group()?;
    for values in values {
        let Some(mut column) = group.next_column()? else { break };
        match (column.untyped(), values) {
            (ColumnWriter::DoubleColumnWriter(out), Values::F64(values)) => {
                out.write_batch(values, None, None)?;
                values.clear();
            }
            (ColumnWriter::FloatColumnWriter(out), Values::F32(values)) => {
                out.write_batch(values, None, None)?;
                values.clear();
            }
            (ColumnWriter::Int32ColumnWriter(out), Values::I32(values)) => {
                out.write_batch(values, None, None)?;
                values.clear();
            }
            (ColumnWriter::Int64ColumnWriter(out), Values::I64(values)) => {
                out.write_batch(values, None, None)?;
                values.clear();
            }
            _ => return Err(ParquetError::General("a column differs from the schema".into())),
        }
        column.close()?;
    }
    group.close()?;
    Ok(())
}

fn empty<R>(field: &Field<R>) -> Values {
    match field {
        Field::F64(..) => Values::F64(Vec::new()),
        Field::F32(..) => Values::F32(Vec::new()),
        Field::U32(..) | Field::Kind(..) => Values::I32(Vec::new()),
        Field::U64(..) => Values::I64(Vec::new()),
    }
}

/// Storage and meaning of a field in Parquet's terms, and in words.
fn parquet_type<R>(field: &Field<R>) -> (Physical, Option<LogicalType>, &'static str) {
    let unsigned = |bit_width| Some(LogicalType::integer(bit_width, false));
    match field {
        Field::F64(..) => (Physical::DOUBLE, None, "a 64-bit float"),
        Field::F32(..) => (Physical::FLOAT, None, "a 32-bit float"),
        Field::U32(..) => (Physical::INT32, unsigned(32), "a 32-bit integer"),
        Field::Kind(..) => (Physical::INT32, unsigned(8), "an integer of at most 32 bits"),
        Field::U64(..) => (Physical::INT64, unsigned(64), "a 64-bit integer"),
    }
}

fn schema<R>(columns: &[Column<R>]) -> Result<Type, ParquetError> {
    let fields = columns
        .iter()
        .map(|column| {
            let (physical, logical, _) = parquet_type(&column.field);
            Type::primitive_type_builder(column.name, physical)
                .with_repetition(Repetition::REQUIRED)
                .with_logical_type(logical)
                .build()
                .map(Arc::new)
        })
        .collect::<Result<_, _>>()?;
    Type::group_type_builder("schema").with_fields(fields).build()
}

/// Reads a table.
pub(super) struct TableReader<R: TableRow> {
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
    pub(super) fn open(
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
        let columns = R::columns();
        for column in &columns {
            let place = in_file.columns().iter().position(|c| column.is_named(&c.path().string()));
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
    pub(super) fn block(&self) -> &[R] {
        &self.block
    }

    /// Reads the next rows; none at the end and after an error.
    pub(super) fn next_block(&mut self) -> Result<(), TimelineError> {
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
    values.clear();
    levels.clear();
    let (records, present, _) = reader.read_records(rows, Some(levels), None, values)?;
    if records != rows {
        return Err(ParquetError::General(format!("column {column} is shorter than others")).into());
    }
    if present != rows {
        let index = levels.iter().position(|level| *level == 0).unwrap_or(0);
        return Err(Fault::Row(index, RowProblem::Null { column }));
    }
    Ok(())
}

fn parquet_error(path: &Path, error: &ParquetError) -> TimelineError {
    TimelineError::Parquet { path: path.into(), reason: error.to_string() }
}

fn write_error(path: &Path, source: std::io::Error) -> TimelineError {
    TimelineError::Io { action: "write", path: path.into(), source }
}
