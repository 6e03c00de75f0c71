//! A table of rows as Parquet, written and read a few thousand rows at a time.
//!
//! zstd over byte-stream-split floats and plain integers and times. Dictionaries, delta packing and plain
//! floats were measured on a settling pile and are larger: the rows of a step repeat those of the step
//! before, which zstd finds best where values keep whole bytes.

pub(super) mod reader;
pub(super) mod writer;

use std::path::Path;

use parquet::basic::{LogicalType, Type as Physical};
use parquet::errors::ParquetError;

use super::columns::Field;
use super::error::{RowProblem, TimelineError};

/// Rows that are turned between row and column order at once: they fit the second-level cache.
const BLOCK_ROWS: usize = 1 << 10;

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

/// Storage and meaning of a field in Parquet's terms, and in words.
fn parquet_type<R>(field: &Field<R>) -> (Physical, Option<LogicalType>, &'static str) {
    let unsigned = |bit_width| Some(LogicalType::integer(bit_width, false));
    match field {
        Field::F64(..) => (Physical::DOUBLE, None, "a 64-bit float"),
        Field::F32(..) | Field::OptionalF32(..) => (Physical::FLOAT, None, "a 32-bit float"),
        Field::U32(..) => (Physical::INT32, unsigned(32), "a 32-bit integer"),
        Field::Kind(..) => (Physical::INT32, unsigned(8), "an integer of at most 32 bits"),
        Field::U64(..) => (Physical::INT64, unsigned(64), "a 64-bit integer"),
    }
}

fn parquet_error(path: &Path, error: &ParquetError) -> TimelineError {
    TimelineError::Parquet { path: path.into(), reason: error.to_string() }
}
