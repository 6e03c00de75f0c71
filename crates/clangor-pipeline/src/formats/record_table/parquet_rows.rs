//! Rows of a Parquet file of any flat schema.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

use super::{Cell, Record, RecordTable, RecordTableError};

pub(super) fn read(path: &Path) -> Result<RecordTable, RecordTableError> {
    let file = File::open(path).map_err(|source| RecordTableError::Io { path: path.into(), source })?;
    let damaged = |reason: String| RecordTableError::Parquet { path: path.into(), reason };
    // The decoder has assertions that damaged files can break; what it was reading is not used again.
    match catch_unwind(AssertUnwindSafe(|| rows(file))) {
        Ok(table) => table.map_err(|error| damaged(error.to_string())),
        Err(_) => Err(damaged("its structure contradicts itself".into())),
    }
}

fn rows(file: File) -> Result<RecordTable, ParquetError> {
    let reader = SerializedFileReader::new(file)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let columns = schema.root_schema().get_fields().iter().map(|field| field.name().to_string()).collect();
    let mut table = RecordTable { columns, records: Vec::new() };
    for (row, record) in reader.get_row_iter(None)?.enumerate() {
        let cells = record?.get_column_iter().map(|(_, field)| cell(field)).collect();
        table.records.push(Record { row: row as u64, cells });
    }
    Ok(table)
}

fn cell(field: &Field) -> Cell {
    match field {
        Field::Null => Cell::Empty,
        Field::Str(text) => Cell::Text(text.clone()),
        Field::Bytes(bytes) => Cell::Text(String::from_utf8_lossy(bytes.data()).into_owned()),
        Field::Byte(n) => Cell::Number(f64::from(*n)),
        Field::Short(n) => Cell::Number(f64::from(*n)),
        Field::Int(n) => Cell::Number(f64::from(*n)),
        Field::Long(n) => Cell::Number(*n as f64),
        Field::UByte(n) => Cell::Number(f64::from(*n)),
        Field::UShort(n) => Cell::Number(f64::from(*n)),
        Field::UInt(n) => Cell::Number(f64::from(*n)),
        Field::ULong(n) => Cell::Number(*n as f64),
        Field::Float16(x) => Cell::Number(f64::from(*x)),
        Field::Float(x) => Cell::Number(f64::from(*x)),
        Field::Double(x) => Cell::Number(*x),
        other => Cell::Text(other.to_string()),
    }
}
