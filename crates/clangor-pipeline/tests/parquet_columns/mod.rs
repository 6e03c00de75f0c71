//! Parquet files of double columns.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::{ByteArray, DoubleType, FixedLenByteArray};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

/// Rows in a batch.
const BATCH: usize = 1 << 20;

/// Writes columns of these names and values.
pub(crate) fn write_columns(path: &Path, columns: &[(&str, Vec<f64>)], compression: Compression) {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    write(path, (&names, 1), compression, &|_, column, put| put(&columns[column].1));
}

/// Writes groups of rows that are all alike: how many, and the value of each column.
pub(crate) fn write_alike(path: &Path, names: &[&str], groups: &[(usize, &[f64])], compression: Compression) {
    write(path, (names, groups.len()), compression, &|group, column, put| {
        let (rows, values) = groups[group];
        let batch = vec![values[column]; BATCH.min(rows)];
        let mut left = rows;
        while left > 0 {
            let count = left.min(batch.len());
            put(&batch[..count]);
            left -= count;
        }
    });
}

/// Writes a file with these fields and without rows.
pub(crate) fn write_no_rows(path: &Path, fields: &str) {
    let schema = Arc::new(parse_message_type(&format!("message rows {{ {fields} }}")).unwrap());
    let properties = Arc::new(WriterProperties::builder().build());
    SerializedFileWriter::new(fs::File::create(path).unwrap(), schema, properties).unwrap().close().unwrap();
}

/// Writes poses of a ball at rest with these fields: whole numbers as the first one, its name, its position.
pub(crate) fn write_decimals(path: &Path, fields: &str, numbers: &[i64]) {
    let schema = Arc::new(parse_message_type(&format!("message rows {{ {fields} }}")).unwrap());
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(fs::File::create(path).unwrap(), schema, properties).unwrap();
    let mut rows = writer.next_row_group().unwrap();
    let mut at = 0;
    while let Some(mut column) = rows.next_column().unwrap() {
        match column.untyped() {
            ColumnWriter::Int32ColumnWriter(column) => {
                let values: Vec<i32> = numbers.iter().map(|number| *number as i32).collect();
                column.write_batch(&values, None, None).unwrap();
            }
            ColumnWriter::Int64ColumnWriter(column) => {
                column.write_batch(numbers, None, None).unwrap();
            }
            ColumnWriter::ByteArrayColumnWriter(column) => {
                let text = |number: &i64| match at {
                    0 => ByteArray::from(number.to_be_bytes()[5..].to_vec()),
                    _ => ByteArray::from("ball"),
                };
                let values: Vec<ByteArray> = numbers.iter().map(text).collect();
                column.write_batch(&values, None, None).unwrap();
            }
            ColumnWriter::FixedLenByteArrayColumnWriter(column) => {
                let whole = |number: &i64| i128::from(*number).to_be_bytes().to_vec();
                let values: Vec<FixedLenByteArray> =
                    numbers.iter().map(|number| ByteArray::from(whole(number)).into()).collect();
                column.write_batch(&values, None, None).unwrap();
            }
            ColumnWriter::DoubleColumnWriter(column) => {
                column.write_batch(&vec![0.5; numbers.len()], None, None).unwrap();
            }
            _ => panic!("no such column"),
        }
        column.close().unwrap();
        at += 1;
    }
    rows.close().unwrap();
    writer.close().unwrap();
}

/// What puts the values of a column of a group into the file.
type Fill<'a> = dyn Fn(usize, usize, &mut dyn FnMut(&[f64])) + 'a;

/// Writes groups of named columns.
fn write(path: &Path, (names, groups): (&[&str], usize), compression: Compression, fill: &Fill<'_>) {
    let fields: String = names.iter().map(|name| format!("required double {name};")).collect();
    let schema = Arc::new(parse_message_type(&format!("message rows {{ {fields} }}")).unwrap());
    let properties = Arc::new(WriterProperties::builder().set_compression(compression).build());
    let mut writer = SerializedFileWriter::new(fs::File::create(path).unwrap(), schema, properties).unwrap();
    for group in 0..groups {
        let mut rows = writer.next_row_group().unwrap();
        for at in 0..names.len() {
            let mut column = rows.next_column().unwrap().unwrap();
            fill(group, at, &mut |values| {
                column.typed::<DoubleType>().write_batch(values, None, None).unwrap();
            });
            column.close().unwrap();
        }
        rows.close().unwrap();
    }
    writer.close().unwrap();
}
