//! Tables of strikes: comma-separated values, JSON lines or Parquet, one strike in a row.
//!
//! | column | what | default |
//! |---|---|---|
//! | `object` | a name of the recipe, a shape, or a file relative to the table | drawn |
//! | `material` | a name of the recipe or a preset | drawn from the object's |
//! | `scale` | factor on the lengths of a file | 1 |
//! | `point_x` `_y` `_z` | \[m from the centre of mass\] | drawn |
//! | `normal_x` `_y` `_z` | outward normal, of any length | that of the surface |
//! | `striker`, `radius`, `speed` | material, \[m\], [m/s] | drawn |
//! | `impulse_x` `_y` `_z`, `duration` | [N s] on the body, \[s\] | drawn |
//! | `listener_x` `_y` `_z` | \[m from the centre of mass\] | drawn |
//! | `room` | a name of the recipe | drawn |

use std::path::{Path, PathBuf};

use clangor_core::glam::DVec3;
use clangor_core::quantity::{self, Quantity};

use super::error::{DatasetError, RowPlace};
use crate::formats::record_table::{Cell, RowSink, read_rows};

const COLUMNS: [&str; 20] = [
    "object",
    "material",
    "scale",
    "point_x",
    "point_y",
    "point_z",
    "normal_x",
    "normal_y",
    "normal_z",
    "striker",
    "radius",
    "speed",
    "impulse_x",
    "impulse_y",
    "impulse_z",
    "duration",
    "listener_x",
    "listener_y",
    "listener_z",
    "room",
];
const OBJECT: usize = 0;
const MATERIAL: usize = 1;
const SCALE: usize = 2;
const POINT: usize = 3;
const NORMAL: usize = 6;
const STRIKER: usize = 9;
const RADIUS: usize = 10;
const SPEED: usize = 11;
const IMPULSE: usize = 12;
const DURATION: usize = 15;
const LISTENER: usize = 16;
const ROOM: usize = 19;

const FACTOR: Quantity = Quantity::above(0.0, 1e6, "");
const APPROACH: Quantity = Quantity::above(0.0, 1e3, "m/s");
const PUSH: Quantity = Quantity::between(-1e6, 1e6, "N s");
const CONTACT: Quantity = Quantity::between(1e-9, 1.0, "s");

/// A row; what it does not say is drawn.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StrikeRow {
    /// Line of a text from 1, or row of a Parquet file from 0.
    pub(super) row: u64,
    pub(super) object: Option<String>,
    pub(super) material: Option<String>,
    pub(super) scale: Option<f64>,
    pub(super) point: Option<DVec3>,
    pub(super) normal: Option<DVec3>,
    pub(super) force: Option<RowForce>,
    pub(super) listener: Option<DVec3>,
    pub(super) room: Option<String>,
}

/// What strikes the body of a row.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum RowForce {
    Ball { material: String, radius: f64, speed: f64 },
    Impulse { impulse: DVec3, duration: Option<f64> },
}

/// Reads a table.
///
/// # Errors
/// [`DatasetError::Table`] and [`DatasetError::Cell`], with the file, the row and the column.
pub(super) fn read_strikes(path: &Path) -> Result<Vec<StrikeRow>, DatasetError> {
    let mut rows = Rows { path: path.into(), rows: Vec::new() };
    read_rows(path, &mut rows)?;
    match rows.rows.is_empty() {
        true => Err(DatasetError::EmptyTable { path: path.into() }),
        false => Ok(rows.rows),
    }
}

struct Rows {
    path: PathBuf,
    rows: Vec<StrikeRow>,
}

impl RowSink for Rows {
    type Error = DatasetError;

    fn known(&self) -> &[&'static str] {
        &COLUMNS
    }

    fn is_ignored(&self, _: &str) -> bool {
        false
    }

    fn document(&self) -> &'static str {
        "docs/format/dataset.md"
    }

    fn columns(&mut self, _: &[String], _: &[bool]) -> Result<(), DatasetError> {
        Ok(())
    }

    fn row(&mut self, row: u64, cells: &[Cell]) -> Result<(), DatasetError> {
        let read = Reader { path: &self.path, row, cells };
        let strike = StrikeRow {
            row,
            object: read.text(OBJECT),
            material: read.text(MATERIAL),
            scale: read.number(SCALE, FACTOR)?,
            point: read.vector(POINT, quantity::COORDINATE)?,
            normal: read.vector(NORMAL, Quantity::any(""))?,
            force: read.force()?,
            listener: read.vector(LISTENER, quantity::COORDINATE)?,
            room: read.text(ROOM),
        };
        self.rows.push(strike);
        Ok(())
    }
}

struct Reader<'a> {
    path: &'a Path,
    row: u64,
    cells: &'a [Cell],
}

impl Reader<'_> {
    fn wrong(&self, column: usize, fault: impl Into<String>) -> DatasetError {
        let row = RowPlace { path: self.path.into(), row: self.row };
        DatasetError::Cell { row, column: COLUMNS[column].into(), fault: fault.into() }
    }

    fn text(&self, column: usize) -> Option<String> {
        match &self.cells[column] {
            Cell::Empty => None,
            Cell::Number(number) => Some(number.to_string()),
            Cell::Text(text) => Some(text.clone()),
        }
    }

    fn number(&self, column: usize, quantity: Quantity) -> Result<Option<f64>, DatasetError> {
        let cell = &self.cells[column];
        if *cell == Cell::Empty {
            return Ok(None);
        }
        let found = self.text(column).unwrap_or_default();
        match cell.number().filter(|number| number.is_finite()) {
            None => Err(self.wrong(column, format!("is {found}, not a finite number"))),
            Some(number) if quantity.admits(number) => Ok(Some(number)),
            Some(_) => Err(self.wrong(column, format!("is {found}; write {}", quantity.expected()))),
        }
    }

    /// A vector, all of whose components are there, or none.
    fn vector(&self, first: usize, quantity: Quantity) -> Result<Option<DVec3>, DatasetError> {
        let mut values = [None; 3];
        for (axis, value) in values.iter_mut().enumerate() {
            *value = self.number(first + axis, quantity)?;
        }
        match values {
            [None, None, None] => Ok(None),
            [Some(x), Some(y), Some(z)] => Ok(Some(DVec3::new(x, y, z))),
            _ => {
                let missing = values.iter().position(Option::is_none).unwrap_or(0);
                Err(self.wrong(first + missing, "is missing"))
            }
        }
    }

    fn force(&self) -> Result<Option<RowForce>, DatasetError> {
        let striker = self.text(STRIKER);
        let radius = self.number(RADIUS, quantity::RADIUS)?;
        let speed = self.number(SPEED, APPROACH)?;
        let impulse = self.vector(IMPULSE, PUSH)?;
        let duration = self.number(DURATION, CONTACT)?;
        let is_ball = striker.is_some() || radius.is_some() || speed.is_some();
        match (is_ball, impulse) {
            (true, Some(_)) => Err(self.wrong(IMPULSE, "follows from the striker: give either")),
            (true, None) if duration.is_some() => {
                Err(self.wrong(DURATION, "follows from the striker: leave it out"))
            }
            (true, None) => {
                let material = striker.ok_or_else(|| self.wrong(STRIKER, "is missing"))?;
                let radius = radius.ok_or_else(|| self.wrong(RADIUS, "is missing"))?;
                let speed = speed.ok_or_else(|| self.wrong(SPEED, "is missing"))?;
                Ok(Some(RowForce::Ball { material, radius, speed }))
            }
            (false, Some(impulse)) => Ok(Some(RowForce::Impulse { impulse, duration })),
            (false, None) if duration.is_some() => Err(self.wrong(IMPULSE, "is missing beside `duration`")),
            (false, None) => Ok(None),
        }
    }
}
