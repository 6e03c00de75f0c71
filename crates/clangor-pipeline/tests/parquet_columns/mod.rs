//! Parquet files of double columns.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::DoubleType;
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
