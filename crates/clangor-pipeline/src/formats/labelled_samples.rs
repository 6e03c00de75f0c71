//! Parquet files of labelled samples: plain columns, and columns of lists of numbers.
//!
//! zstd over byte-stream-split floats. A list column is `LIST` of required elements, which pyarrow, pandas,
//! DuckDB and Hugging Face's `datasets` read as `list<float>`. The same rows make the same bytes.

use std::fs::File;
use std::io::BufWriter;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type, TypePtr};

use crate::formats::atomic_file::{AtomicFile, OutputError};

/// Sound compresses by a few per cent at any level.
const ZSTD_LEVEL: i32 = 1;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColumnKind {
    /// 64-bit integers.
    Integer,
    /// Truth values.
    Flag,
    /// 64-bit floats, or nothing.
    Number,
    /// Texts, or nothing.
    Text,
    /// Lists of 64-bit floats.
    Numbers,
    /// Lists of 32-bit floats.
    Samples,
}

/// The values of a column in a group of rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ColumnValues {
    Integer(Vec<i64>),
    Flag(Vec<bool>),
    Number(Vec<Option<f64>>),
    Text(Vec<Option<String>>),
    Numbers(Vec<Vec<f64>>),
    Samples(Vec<Vec<f32>>),
}

/// Why labelled samples could not be written or read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LabelledSamplesError {
    /// The file cannot be put in place.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The file cannot be opened.
    #[error("cannot read {path}: {source}")]
    Open {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The encoder or decoder failed.
    #[error("{path}: {reason}")]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What it met.
        reason: String,
    },
}

/// Writes a file, a group of rows at a time; it appears under its name once it is finished.
pub(crate) struct LabelledSamplesWriter {
    path: PathBuf,
    file: SerializedFileWriter<BufWriter<AtomicFile>>,
}

impl LabelledSamplesWriter {
    /// Starts a file with these columns, and texts under names in its footer.
    pub(crate) fn create(
        path: &Path,
        columns: &[(&str, ColumnKind)],
        metadata: &[(&str, String)],
    ) -> Result<Self, LabelledSamplesError> {
        let failed = |error: ParquetError| parquet_error(path, &error);
        let level = ZstdLevel::try_new(ZSTD_LEVEL).map_err(failed)?;
        let entries = metadata.iter().map(|(key, text)| KeyValue::new((*key).into(), text.clone()));
        let mut properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(level))
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_key_value_metadata(Some(entries.collect()));
        for (name, kind) in columns {
            if matches!(kind, ColumnKind::Numbers | ColumnKind::Samples) {
                let column = ColumnPath::new([*name, "list", "element"].map(String::from).to_vec());
                properties = properties
                    .set_column_dictionary_enabled(column.clone(), false)
                    .set_column_statistics_enabled(column.clone(), EnabledStatistics::None)
                    .set_column_encoding(column, Encoding::BYTE_STREAM_SPLIT);
            }
        }
        let schema = schema(columns).map_err(failed)?;
        let out = BufWriter::with_capacity(1 << 16, AtomicFile::create(path)?);
        let file = SerializedFileWriter::new(out, schema, Arc::new(properties.build())).map_err(failed)?;
        Ok(LabelledSamplesWriter { path: path.into(), file })
    }

    /// Appends a group of rows, one entry for each column.
    pub(crate) fn write(&mut self, columns: &[ColumnValues]) -> Result<(), LabelledSamplesError> {
        let written = write_group(&mut self.file, columns);
        written.map_err(|error| parquet_error(&self.path, &error))
    }

    /// Completes the file and puts it in place.
    pub(crate) fn finish(self) -> Result<(), LabelledSamplesError> {
        let out = self.file.into_inner().map_err(|error| parquet_error(&self.path, &error))?;
        let file = out.into_inner().map_err(|error| LabelledSamplesError::Parquet {
            path: self.path.clone(),
            reason: error.error().to_string(),
        })?;
        Ok(file.commit()?)
    }
}

/// The text under a name in the footer of a file; `None` without it.
pub(crate) fn read_metadata(path: &Path, key: &str) -> Result<Option<String>, LabelledSamplesError> {
    let file = File::open(path).map_err(|source| LabelledSamplesError::Open { path: path.into(), source })?;
    // The decoder has assertions that damaged files can break.
    let decoded = catch_unwind(AssertUnwindSafe(|| SerializedFileReader::new(file)));
    let reader = match decoded {
        Ok(read) => read.map_err(|error| parquet_error(path, &error))?,
        Err(_) => {
            let reason = "its structure contradicts itself".into();
            return Err(LabelledSamplesError::Parquet { path: path.into(), reason });
        }
    };
    let entries = reader.metadata().file_metadata().key_value_metadata();
    let found = entries.and_then(|entries| entries.iter().find(|entry| entry.key == key));
    Ok(found.and_then(|entry| entry.value.clone()))
}

fn parquet_error(path: &Path, error: &ParquetError) -> LabelledSamplesError {
    LabelledSamplesError::Parquet { path: path.into(), reason: error.to_string() }
}

fn schema(columns: &[(&str, ColumnKind)]) -> Result<TypePtr, ParquetError> {
    let fields = columns.iter().map(|(name, kind)| field(name, *kind));
    let fields = fields.collect::<Result<_, _>>()?;
    Ok(Arc::new(Type::group_type_builder("schema").with_fields(fields).build()?))
}

fn field(name: &str, kind: ColumnKind) -> Result<TypePtr, ParquetError> {
    const REQUIRED: Repetition = Repetition::REQUIRED;
    const OPTIONAL: Repetition = Repetition::OPTIONAL;
    let plain = |name: &str, physical, repetition, logical| -> Result<TypePtr, ParquetError> {
        let builder = Type::primitive_type_builder(name, physical).with_repetition(repetition);
        Ok(Arc::new(builder.with_logical_type(logical).build()?))
    };
    let list = |physical| -> Result<TypePtr, ParquetError> {
        let element = plain("element", physical, REQUIRED, None)?;
        let entries =
            Type::group_type_builder("list").with_repetition(Repetition::REPEATED).with_fields(vec![element]);
        let list = Type::group_type_builder(name)
            .with_repetition(REQUIRED)
            .with_logical_type(Some(LogicalType::List))
            .with_fields(vec![Arc::new(entries.build()?)]);
        Ok(Arc::new(list.build()?))
    };
    match kind {
        ColumnKind::Integer => plain(name, Physical::INT64, REQUIRED, None),
        ColumnKind::Flag => plain(name, Physical::BOOLEAN, REQUIRED, None),
        ColumnKind::Number => plain(name, Physical::DOUBLE, OPTIONAL, None),
        ColumnKind::Text => plain(name, Physical::BYTE_ARRAY, OPTIONAL, Some(LogicalType::String)),
        ColumnKind::Numbers => list(Physical::DOUBLE),
        ColumnKind::Samples => list(Physical::FLOAT),
    }
}

fn write_group(
    file: &mut SerializedFileWriter<BufWriter<AtomicFile>>,
    columns: &[ColumnValues],
) -> Result<(), ParquetError> {
    let mut group = file.next_row_group()?;
    for values in columns {
        let Some(mut column) = group.next_column()? else { break };
        match (column.untyped(), values) {
            (ColumnWriter::Int64ColumnWriter(out), ColumnValues::Integer(values)) => {
                out.write_batch(values, None, None)?;
            }
            (ColumnWriter::BoolColumnWriter(out), ColumnValues::Flag(values)) => {
                out.write_batch(values, None, None)?;
            }
            (ColumnWriter::DoubleColumnWriter(out), ColumnValues::Number(values)) => {
                let present: Vec<f64> = values.iter().flatten().copied().collect();
                out.write_batch(&present, Some(&presence(values)), None)?;
            }
            (ColumnWriter::ByteArrayColumnWriter(out), ColumnValues::Text(values)) => {
                let present: Vec<ByteArray> =
                    values.iter().flatten().map(|text| ByteArray::from(text.as_str())).collect();
                out.write_batch(&present, Some(&presence(values)), None)?;
            }
            (ColumnWriter::DoubleColumnWriter(out), ColumnValues::Numbers(lists)) => {
                // A row at a time, so that pages end at rows.
                for list in lists {
                    let (present, nested) = levels(list.len());
                    out.write_batch(list, Some(&present), Some(&nested))?;
                }
            }
            (ColumnWriter::FloatColumnWriter(out), ColumnValues::Samples(lists)) => {
                for list in lists {
                    let (present, nested) = levels(list.len());
                    out.write_batch(list, Some(&present), Some(&nested))?;
                }
            }
            _ => return Err(ParquetError::General("a column differs from the schema".into())),
        }
        column.close()?;
    }
    group.close()?;
    Ok(())
}

/// Definition levels of values that may be absent.
fn presence<T>(values: &[Option<T>]) -> Vec<i16> {
    values.iter().map(|value| i16::from(value.is_some())).collect()
}

/// Definition and repetition levels of a list.
fn levels(length: usize) -> (Vec<i16>, Vec<i16>) {
    let mut nested = vec![1; length.max(1)];
    nested[0] = 0;
    (vec![i16::from(length > 0); length.max(1)], nested)
}
