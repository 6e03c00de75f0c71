//! Writing a table.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clangor_core::body::{BodyId, Life};
use parquet::basic::{Compression, Encoding, Repetition, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::errors::ParquetError;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};

use super::{BLOCK_ROWS, Order, parquet_error, parquet_type};
use crate::formats::timeline_file::columns::{Column, Field, TableRow};
use crate::formats::timeline_file::description::TableFields;
use crate::formats::timeline_file::error::{RowProblem, TimelineError};
use crate::formats::timeline_file::hash::HashedFile;

/// Rows of a row group: 64 MB of columns, few enough to keep in memory and enough to compress well.
const GROUP_ROWS: usize = 1 << 18;
/// Rows of a page.
const PAGE_ROWS: usize = 1 << 17;
/// 3 % smaller than level 1 for a second of processor time in 17 million rows.
const ZSTD_LEVEL: i32 = 3;

/// The values of a column on their way to the file.
enum Values {
    F64(Vec<f64>),
    F32(Vec<f32>),
    /// The values that are there, and for each row 1 or 0 for none.
    OptionalF32(Vec<f32>, Vec<i16>),
    I32(Vec<i32>),
    I64(Vec<i64>),
}

/// Writes a table.
pub(in crate::formats::timeline_file) struct TableWriter<R: TableRow> {
    path: PathBuf,
    file: SerializedFileWriter<BufWriter<HashedFile>>,
    columns: Vec<Column<R>>,
    /// Optional columns that the file does not have.
    left_out: Vec<Column<R>>,
    block: Vec<R>,
    values: Vec<Values>,
    grouped: usize,
    rows: u64,
    order: Order,
    lives: Vec<Life>,
}

impl<R: TableRow> TableWriter<R> {
    /// Creates the file, without optional columns. `slack` is how far rows may be out of order \[s\].
    pub(in crate::formats::timeline_file) fn create(
        path: &Path,
        lives: Vec<Life>,
        slack: f64,
    ) -> Result<Self, TimelineError> {
        Self::create_with(path, lives, slack, &[])
    }

    /// Creates the file with these optional columns.
    pub(in crate::formats::timeline_file) fn create_with(
        path: &Path,
        lives: Vec<Life>,
        slack: f64,
        optional: &[&str],
    ) -> Result<Self, TimelineError> {
        let is_kept = |column: &Column<R>| !column.is_optional() || optional.contains(&column.name);
        let (columns, left_out): (Vec<_>, Vec<_>) = R::columns().into_iter().partition(is_kept);
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
            if !matches!(column.field, Field::F32(..) | Field::OptionalF32(..)) {
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
        let path = path.into();
        Ok(TableWriter { path, file, columns, left_out, block, values, grouped: 0, rows: 0, order, lives })
    }

    /// Appends a row.
    pub(in crate::formats::timeline_file) fn push(&mut self, row: &R) -> Result<(), TimelineError> {
        let checked = self.order.check(row.time()).and_then(|()| row.check(&self.lives));
        checked.map_err(|problem| self.refused(problem))?;
        if let Some(column) = self.left_out.iter().find(|column| column.is_needed_by(row)) {
            return Err(self.refused(RowProblem::NoColumn { column: column.name }));
        }
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
    pub(in crate::formats::timeline_file) fn rows(&self) -> u64 {
        self.rows
    }

    /// Takes note of a death, and of the births that come of it.
    pub(in crate::formats::timeline_file) fn replace(&mut self, parent: BodyId, pieces: &[Life]) {
        if let (Some(parent), Some(piece)) = (self.lives.get_mut(parent.index()), pieces.first()) {
            parent.death = piece.birth;
        }
        self.lives.extend_from_slice(pieces);
    }

    /// Writes what is left and synchronises the file.
    pub(in crate::formats::timeline_file) fn finish(mut self) -> Result<TableFields, TimelineError> {
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
                // The rows' own check has seen to the range.
                (Field::OptionalF32(get, _), Values::OptionalF32(values, levels)) => {
                    values.extend(self.block.iter().filter_map(|row| Some(get(row)? as f32)));
                    levels.extend(self.block.iter().map(|row| i16::from(get(row).is_some())));
                    None
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

    /// The error of a next row with a problem.
    pub(in crate::formats::timeline_file) fn refused(&self, problem: RowProblem) -> TimelineError {
        TimelineError::Row { path: self.path.clone(), row: self.rows, problem }
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
            (ColumnWriter::FloatColumnWriter(out), Values::OptionalF32(values, levels)) => {
                out.write_batch(values, Some(levels), None)?;
                values.clear();
                levels.clear();
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
        Field::OptionalF32(..) => Values::OptionalF32(Vec::new(), Vec::new()),
        Field::U32(..) | Field::Kind(..) => Values::I32(Vec::new()),
        Field::U64(..) => Values::I64(Vec::new()),
    }
}

fn schema<R>(columns: &[Column<R>]) -> Result<Type, ParquetError> {
    let fields = columns
        .iter()
        .map(|column| {
            let (physical, logical, _) = parquet_type(&column.field);
            let optional = column.is_optional();
            Type::primitive_type_builder(column.name, physical)
                .with_repetition(if optional { Repetition::OPTIONAL } else { Repetition::REQUIRED })
                .with_logical_type(logical)
                .build()
                .map(Arc::new)
        })
        .collect::<Result<_, _>>()?;
    Type::group_type_builder("schema").with_fields(fields).build()
}

fn write_error(path: &Path, source: std::io::Error) -> TimelineError {
    TimelineError::Io { action: "write", path: path.into(), source }
}
