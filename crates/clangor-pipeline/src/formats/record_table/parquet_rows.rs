//! Rows of a Parquet file of any flat schema, a batch at a time.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, Type as PhysicalType};
use parquet::column::reader::ColumnReader;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::{Cell, RecordTableError, RowSink, places};

/// Rows that are decoded at once: all columns of a pose stay in the cache of a core.
const BATCH: usize = 256;

pub(super) fn read<S: RowSink>(path: &Path, sink: &mut S) -> Result<(), S::Error> {
    let file = File::open(path).map_err(|source| RecordTableError::Io { path: path.into(), source })?;
    let file = guarded(path, || SerializedFileReader::new(file))?;
    let metadata = file.metadata();
    let rows = (0..file.num_row_groups()).map(|group| metadata.row_group(group).num_rows());
    let rows = rows.fold(0_u64, |sum, rows| sum.saturating_add(u64::try_from(rows).unwrap_or(u64::MAX)));
    if rows > sink.most_rows() {
        return Err(RecordTableError::TooManyRows { path: path.into(), most: sink.most_rows() }.into());
    }
    let schema = metadata.file_metadata().schema_descr();
    let names: Vec<String> =
        schema.root_schema().get_fields().iter().map(|field| field.name().to_string()).collect();
    let places = places(path, &names, sink)?;
    // Places of the known columns among the leaves of the schema, and among the cells.
    let mut leaves = Vec::new();
    for (name, place) in names.iter().zip(places) {
        let Some(place) = place else { continue };
        let is_leaf =
            |column: &ColumnDescriptor| column.path().string() == *name && column.max_rep_level() == 0;
        let leaf = (0..schema.num_columns()).find(|leaf| is_leaf(&schema.column(*leaf)));
        let (column, path) = (name.clone(), path.to_path_buf());
        match leaf.map(|leaf| (leaf, kind(&schema.column(leaf)))) {
            Some((leaf, Kind::Plain)) => leaves.push((leaf, place)),
            Some((_, Kind::Calendar)) => return Err(RecordTableError::Calendar { path, column }.into()),
            _ => return Err(RecordTableError::ColumnType { path, column }.into()),
        }
    }
    let mut cells = vec![Cell::Empty; sink.known().len()];
    let mut row = 0;
    for group in 0..file.num_row_groups() {
        let mut columns = guarded(path, || {
            let group = file.get_row_group(group)?;
            let batch = |(leaf, place): &(usize, usize)| {
                Ok(Batch::new(&schema.column(*leaf), group.get_column_reader(*leaf)?, *place))
            };
            leaves.iter().map(batch).collect::<Result<Vec<Batch>, ParquetError>>()
        })?;
        let mut left = usize::try_from(metadata.row_group(group).num_rows()).unwrap_or(0);
        while left > 0 {
            let count = left.min(BATCH);
            guarded(path, || columns.iter_mut().try_for_each(|column| column.fill(count)))?;
            for index in 0..count {
                columns.iter_mut().for_each(|column| column.take(index, &mut cells));
                sink.row(row, &cells)?;
                row += 1;
            }
            left -= count;
        }
    }
    Ok(())
}

/// Decodes. The decoder has assertions that damaged files can break; what it was reading is not used again.
fn guarded<T>(path: &Path, decode: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, RecordTableError> {
    let damaged = |reason: String| RecordTableError::Parquet { path: path.into(), reason };
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(decoded) => decoded.map_err(|error| damaged(error.to_string())),
        Err(_) => Err(damaged("its structure contradicts itself".into())),
    }
}

/// What a column holds.
enum Kind {
    /// Numbers or texts.
    Plain,
    /// Dates, times of a clock, or durations with a type of their own.
    Calendar,
    /// Anything else, such as lists.
    Other,
}

fn kind(column: &ColumnDescriptor) -> Kind {
    use LogicalType as Logical;
    match (column.logical_type_ref(), column.converted_type()) {
        (
            Some(
                Logical::Integer { .. }
                | Logical::String
                | Logical::Enum
                | Logical::Decimal { .. }
                | Logical::Float16
                | Logical::Unknown,
            ),
            _,
        ) => Kind::Plain,
        (Some(Logical::Date | Logical::Time { .. } | Logical::Timestamp { .. }), _)
        | (
            None,
            ConvertedType::DATE
            | ConvertedType::TIME_MILLIS
            | ConvertedType::TIME_MICROS
            | ConvertedType::TIMESTAMP_MILLIS
            | ConvertedType::TIMESTAMP_MICROS
            | ConvertedType::INTERVAL,
        ) => Kind::Calendar,
        (None, _) if column.physical_type() == PhysicalType::INT96 => Kind::Calendar,
        (Some(_), _) => Kind::Other,
        (None, _) => Kind::Plain,
    }
}

/// A column with the values of one batch, those that are null left out.
struct Batch {
    reader: ColumnReader,
    /// Among the cells.
    place: usize,
    /// Level of a value that is there.
    present: i16,
    is_unsigned: bool,
    is_half: bool,
    /// By what a decimal is divided.
    unit: Option<f64>,
    levels: Vec<i16>,
    numbers: Vec<f64>,
    texts: Vec<ByteArray>,
    /// Whether every row of the batch is a number.
    is_full: bool,
    next: usize,
}

impl Batch {
    fn new(column: &ColumnDescriptor, reader: ColumnReader, place: usize) -> Self {
        let unsigned =
            [ConvertedType::UINT_8, ConvertedType::UINT_16, ConvertedType::UINT_32, ConvertedType::UINT_64];
        Batch {
            reader,
            place,
            present: column.max_def_level(),
            is_unsigned: unsigned.contains(&column.converted_type()),
            is_half: column.logical_type_ref() == Some(&LogicalType::Float16),
            unit: is_decimal(column).then(|| 10_f64.powi(column.type_scale())),
            levels: Vec::new(),
            numbers: Vec::new(),
            texts: Vec::new(),
            is_full: false,
            next: 0,
        }
    }

    /// Reads the next `rows` values.
    fn fill(&mut self, rows: usize) -> Result<(), ParquetError> {
        self.levels.clear();
        self.numbers.clear();
        self.texts.clear();
        self.next = 0;
        let levels = Some(&mut self.levels);
        let records = match &mut self.reader {
            ColumnReader::BoolColumnReader(reader) => {
                let mut values = Vec::new();
                let (records, ..) = reader.read_records(rows, levels, None, &mut values)?;
                self.texts
                    .extend(values.into_iter().map(|value| ByteArray::from(value.to_string().as_str())));
                records
            }
            ColumnReader::Int32ColumnReader(reader) => {
                let mut values = Vec::new();
                let (records, ..) = reader.read_records(rows, levels, None, &mut values)?;
                let is_unsigned = self.is_unsigned;
                let number = |n: i32| if is_unsigned { f64::from(n.cast_unsigned()) } else { f64::from(n) };
                let unit = self.unit.unwrap_or(1.0);
                self.numbers.extend(values.into_iter().map(|n| number(n) / unit));
                records
            }
            ColumnReader::Int64ColumnReader(reader) => {
                let mut values = Vec::new();
                let (records, ..) = reader.read_records(rows, levels, None, &mut values)?;
                let is_unsigned = self.is_unsigned;
                let number = |n: i64| if is_unsigned { n.cast_unsigned() as f64 } else { n as f64 };
                let unit = self.unit.unwrap_or(1.0);
                self.numbers.extend(values.into_iter().map(|n| number(n) / unit));
                records
            }
            ColumnReader::FloatColumnReader(reader) => {
                let mut values = Vec::new();
                let (records, ..) = reader.read_records(rows, levels, None, &mut values)?;
                self.numbers.extend(values.into_iter().map(f64::from));
                records
            }
            ColumnReader::DoubleColumnReader(reader) => {
                reader.read_records(rows, levels, None, &mut self.numbers)?.0
            }
            ColumnReader::ByteArrayColumnReader(reader) => {
                let (records, ..) = reader.read_records(rows, levels, None, &mut self.texts)?;
                if let Some(unit) = self.unit {
                    self.numbers.extend(self.texts.drain(..).map(|bytes| whole(bytes.data()) / unit));
                }
                records
            }
            ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                let mut values = Vec::new();
                let (records, ..) = reader.read_records(rows, levels, None, &mut values)?;
                if let Some(unit) = self.unit {
                    self.numbers.extend(values.iter().map(|bytes| whole(bytes.data()) / unit));
                } else if self.is_half {
                    self.numbers.extend(values.iter().map(|value| half(value.data())));
                } else {
                    self.texts.extend(values.into_iter().map(ByteArray::from));
                }
                records
            }
            // Columns of dates have been refused.
            ColumnReader::Int96ColumnReader(_) => {
                return Err(ParquetError::General("a column has a date".into()));
            }
        };
        self.is_full = self.numbers.len() == rows;
        if records == rows {
            Ok(())
        } else {
            Err(ParquetError::General("a column is shorter than others".into()))
        }
    }

    /// Puts the value of a row into its cell; rows come in order.
    fn take(&mut self, index: usize, cells: &mut [Cell]) {
        let cell = &mut cells[self.place];
        // Of most columns each row is a number, as that before.
        if self.is_full
            && let Cell::Number(before) = cell
        {
            *before = self.numbers[index];
            return;
        }
        if self.is_full {
            self.next = index;
        }
        let is_present = self.is_full || self.present == 0 || self.levels.get(index) == Some(&self.present);
        self.take_any(is_present, cell);
    }

    #[inline(never)]
    fn take_any(&mut self, is_present: bool, cell: &mut Cell) {
        if !is_present {
            *cell = Cell::Empty;
            return;
        }
        if let Some(number) = self.numbers.get(self.next) {
            *cell = Cell::Number(*number);
        } else if let Some(text) = self.texts.get(self.next) {
            // The name of a body often follows itself.
            if !matches!(&*cell, Cell::Text(before) if before.as_bytes() == text.data()) {
                *cell = Cell::Text(String::from_utf8_lossy(text.data()).into_owned());
            }
        } else {
            *cell = Cell::Empty;
        }
        self.next += 1;
    }
}

/// Whether a column holds decimals: whole numbers that are divided by a power of ten.
fn is_decimal(column: &ColumnDescriptor) -> bool {
    matches!(column.logical_type_ref(), Some(LogicalType::Decimal { .. }))
        || column.converted_type() == ConvertedType::DECIMAL
}

/// A whole number with its highest byte first, in two's complement.
fn whole(bytes: &[u8]) -> f64 {
    let negative = bytes.first().is_some_and(|first| first >> 7 == 1);
    let start = if negative { -1_i128 } else { 0 };
    bytes.iter().fold(start, |number, byte| number << 8 | i128::from(*byte)) as f64
}

/// A number of 16 bits: sign, 5 bits of exponent, 10 of mantissa.
fn half(bytes: &[u8]) -> f64 {
    let [low, high] = bytes else { return f64::NAN };
    let bits = u16::from_le_bytes([*low, *high]);
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => mantissa * 2.0_f64.powi(-24),
        31 if mantissa == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + mantissa) * 2.0_f64.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}
