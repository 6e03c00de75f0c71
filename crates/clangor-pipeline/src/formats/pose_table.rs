//! Poses that another program wrote, as `.csv`, `.jsonl` or `.parquet`: one row per body and instant.
//!
//! | columns | JSON field | default |
//! |---|---|---|
//! | `t` | `t` | required \[s\] |
//! | `body` | `body` | required: name or number |
//! | `position_x` `_y` `_z` | `position` | required, or `origin`: centre of mass \[m\] |
//! | `origin_x` `_y` `_z` | `origin` | origin of the shape or mesh file instead \[m\] |
//! | `orientation_x` `_y` `_z` `_w` | `orientation` | not turned |
//!
//! Columns `velocity_*` and `angular_velocity_*` may be there, as in the tables of timelines, but velocities
//! are computed from the poses. The rows of a body come in order of time, up to 1 ms; those of several bodies
//! may be mixed.

use std::path::{Path, PathBuf};

use clangor_core::body::BodyId;
use clangor_core::pose::Pose;
use glam::{DQuat, DVec3};

use super::calendar_times::remedy;
use super::column_names::instead_of;
use super::named_bodies::NamedBodies;
use super::record_table::{Cell, MAX_ROWS, RecordTableError, RowSink, read_rows};
use crate::motion::recording::Frame;

/// Frames this near to each other at one time are one \[m\].
const SAME_PLACE: f64 = 1e-6;

/// How late a row of a body may come \[s\]: timelines write an impact when it is over.
pub(crate) const LATE: f64 = 1e-3;

/// How late a row may come after those of other bodies in a table that is read as a stream \[s\]: programs
/// that write in blocks of frames, body by body, take less.
pub(crate) const LATENESS: f64 = 1.0;

/// What a position of a row is that of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionOf {
    /// The centre of mass.
    CentreOfMass,
    /// The origin of the shape or file.
    Origin,
}

/// Takes the poses of a table, one at a time.
pub(crate) trait PoseSink {
    /// What can go wrong with a pose.
    type Error: From<RecordTableError> + From<PoseTableError>;

    /// Most rows that are taken.
    fn most_rows(&self) -> u64;

    /// What the positions of the table are; called before any pose.
    fn begin(&mut self, position_of: PositionOf);

    /// A pose as it stands in the file, its numbers finite.
    fn pose(&mut self, body: BodyId, frame: Frame) -> Result<(), Self::Error>;
}

/// Poses of a table, by body.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseTable {
    /// What the positions are.
    pub position_of: PositionOf,
    /// Frames of each body that has any, in the order of first rows.
    pub bodies: Vec<(BodyId, Vec<Frame>)>,
}

/// Why poses could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PoseTableError {
    /// The file is no table.
    #[error(transparent)]
    Table(#[from] RecordTableError),
    /// A column is missing.
    #[error("{path} has no column {column}; {found}; docs/format/timeline.md lists the columns of poses")]
    Missing {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// The columns that are there, and which of them is likely meant.
        found: String,
    },
    /// Positions in two ways.
    #[error("{path} has both position and origin; leave out one")]
    TwoPositions {
        /// The file.
        path: PathBuf,
    },
    /// A value that is no finite number.
    #[error(
        "{path}, body {body}, row {row}: {column} is {text}, not a finite number{}",
        match text {
            text if column != "t" && text.eq_ignore_ascii_case("nan") =>
                "; leave out the rows in which the body was not seen",
            text => remedy(column, text),
        }
    )]
    NotANumber {
        /// The file.
        path: PathBuf,
        /// The body.
        body: String,
        /// Line of a text, row of a Parquet file.
        row: u64,
        /// The column.
        column: String,
        /// What is there.
        text: String,
    },
    /// A body that does not exist.
    #[error("{path}, row {row}: body is {text}, which is neither the name nor the number of a body{remedy}")]
    Body {
        /// The file.
        path: PathBuf,
        /// Line of a text, row of a Parquet file.
        row: u64,
        /// What is there.
        text: String,
        /// The name that is likely meant, or nothing.
        remedy: String,
    },
    /// A long table whose rows are not in order of time.
    #[error(
        "{path}, row {row}: t = {time} s comes after t = {latest} s; a table of more than {MAX_ROWS} poses \
         needs rows in order of time, up to {LATENESS} s: sort it by t"
    )]
    NotSorted {
        /// The file.
        path: PathBuf,
        /// The first row that comes too late.
        row: u64,
        /// Its time \[s\].
        time: f64,
        /// Latest time before it \[s\].
        latest: f64,
    },
    /// A long table with a gap between two frames of a body.
    #[error(
        "{path}: body {body} has no frame for {gap} s; the poses of all bodies in that time are too many to \
         be kept ({MAX_ROWS} at most): add frames of {body}, or import fewer bodies"
    )]
    Gap {
        /// The file.
        path: PathBuf,
        /// The body.
        body: String,
        /// Longest distance of its frames \[s\].
        gap: f64,
    },
    /// A long table with far more poses in some moments than in others.
    #[error(
        "{path}, row {row}: there are more than {MAX_ROWS} poses from t = {from} to {to} s, too many to \
         be kept; divide the table there, or leave out frames"
    )]
    Dense {
        /// The file.
        path: PathBuf,
        /// The row that is too much.
        row: u64,
        /// First time of those poses \[s\].
        from: f64,
        /// Time of the row \[s\].
        to: f64,
    },
    /// No row.
    #[error("{path} has no poses")]
    Empty {
        /// The file.
        path: PathBuf,
    },
}

/// Beginnings of names of columns that are known, but not needed.
const IGNORED: [&str; 2] = ["velocity_", "angular_velocity_"];

/// The columns that are read.
const COLUMNS: [&str; 12] = [
    "t",
    "body",
    "position_x",
    "position_y",
    "position_z",
    "origin_x",
    "origin_y",
    "origin_z",
    "orientation_x",
    "orientation_y",
    "orientation_z",
    "orientation_w",
];
const TIME: usize = 0;
const BODY: usize = 1;
const POSITION: usize = 2;
const ORIGIN: usize = 5;
const ORIENTATION: usize = 8;

/// Reads the poses of some bodies.
///
/// # Errors
/// [`PoseTableError`] names the file, the row and the column.
pub fn read_pose_table(path: &Path, bodies: &NamedBodies<'_>) -> Result<PoseTable, PoseTableError> {
    let mut collected = Collected {
        place_of: vec![None; bodies.count()],
        table: PoseTable { position_of: PositionOf::CentreOfMass, bodies: Vec::new() },
    };
    scan_poses(path, bodies, &mut collected)?;
    Ok(collected.table)
}

/// Gives the poses of a table to `sink`, and keeps none; otherwise as [`read_pose_table`].
///
/// # Errors
/// [`PoseTableError`], and those of the sink.
pub(crate) fn scan_poses<S: PoseSink>(
    path: &Path,
    bodies: &NamedBodies<'_>,
    sink: &mut S,
) -> Result<(), S::Error> {
    let mut reader = Reader {
        path,
        bodies,
        numbered: vec![None; bodies.count()],
        position_of: PositionOf::CentreOfMass,
        is_turned: false,
        is_empty: true,
        sink,
    };
    read_rows(path, &mut reader)?;
    if reader.is_empty { Err(PoseTableError::Empty { path: path.into() }.into()) } else { Ok(()) }
}

/// All poses of a table.
struct Collected {
    /// Places of the bodies in the table.
    place_of: Vec<Option<usize>>,
    table: PoseTable,
}

impl PoseSink for Collected {
    type Error = PoseTableError;

    fn most_rows(&self) -> u64 {
        MAX_ROWS
    }

    fn begin(&mut self, position_of: PositionOf) {
        self.table.position_of = position_of;
    }

    fn pose(&mut self, id: BodyId, frame: Frame) -> Result<(), PoseTableError> {
        let bodies = &mut self.table.bodies;
        let place = *self.place_of[id.index()].get_or_insert_with(|| {
            bodies.push((id, Vec::new()));
            bodies.len() - 1
        });
        insert(&mut bodies[place].1, frame);
        Ok(())
    }
}

/// Adds a frame, a little late ones in their place. Timelines have a row at an impact besides that of the
/// same instant; it is left out.
pub(crate) fn insert(frames: &mut Vec<Frame>, frame: Frame) {
    let latest = frames.last().map_or(f64::NEG_INFINITY, |last| last.time);
    let is_late = frame.time < latest && frame.time >= latest - LATE;
    let place = if is_late { frames.partition_point(|f| f.time <= frame.time) } else { frames.len() };
    let is_same = |before: &Frame| {
        before.time == frame.time && before.pose.position.distance(frame.pose.position) < SAME_PLACE
    };
    if !place.checked_sub(1).is_some_and(|before| is_same(&frames[before])) {
        frames.insert(place, frame);
    }
}

/// Turns rows into frames.
struct Reader<'a, S> {
    path: &'a Path,
    bodies: &'a NamedBodies<'a>,
    /// Bodies of the whole numbers so far.
    numbered: Vec<Option<BodyId>>,
    position_of: PositionOf,
    is_turned: bool,
    is_empty: bool,
    sink: &'a mut S,
}

impl<S: PoseSink> RowSink for Reader<'_, S> {
    type Error = S::Error;

    fn most_rows(&self) -> u64 {
        self.sink.most_rows()
    }

    fn known(&self) -> &[&'static str] {
        &COLUMNS
    }

    fn is_ignored(&self, name: &str) -> bool {
        IGNORED.iter().any(|beginning| name.starts_with(beginning))
    }

    fn columns(&mut self, names: &[String], present: &[bool]) -> Result<(), S::Error> {
        if present[ORIGIN] && present[POSITION] {
            return Err(PoseTableError::TwoPositions { path: self.path.into() }.into());
        }
        let position = if present[ORIGIN] { ORIGIN } else { POSITION };
        self.position_of = if present[ORIGIN] { PositionOf::Origin } else { PositionOf::CentreOfMass };
        self.is_turned = present[ORIENTATION..].contains(&true);
        let turned = self.is_turned.then_some(ORIENTATION..ORIENTATION + 4).into_iter().flatten();
        let mut needed = [TIME, BODY].into_iter().chain(position..position + 3).chain(turned);
        match needed.find(|place| !present[*place]) {
            Some(place) => {
                let names = names.iter().map(String::as_str);
                let unknown = names.clone().filter(|name| !COLUMNS.contains(name));
                let found = instead_of(COLUMNS[place], names, unknown);
                let (path, column) = (self.path.into(), COLUMNS[place].into());
                Err(PoseTableError::Missing { path, column, found }.into())
            }
            None => {
                self.sink.begin(self.position_of);
                Ok(())
            }
        }
    }

    fn row(&mut self, row: u64, cells: &[Cell]) -> Result<(), S::Error> {
        let id = self.body(row, &cells[BODY])?;
        let frame = self.frame(row, id, cells)?;
        self.is_empty = false;
        self.sink.pose(id, frame)
    }
}

impl<S> Reader<'_, S> {
    fn body(&mut self, row: u64, cell: &Cell) -> Result<BodyId, PoseTableError> {
        let number = match cell {
            Cell::Number(number) if number.fract() == 0.0 && *number >= 0.0 => Some(*number as usize),
            _ => None,
        };
        let known = match cell {
            Cell::Text(text) => self.bodies.find(text),
            _ => number.and_then(|number| *self.numbered.get(number)?),
        };
        if let Some(id) = known {
            return Ok(id);
        }
        let text = shown(cell, "");
        let id = self.bodies.find(&text).ok_or_else(|| PoseTableError::Body {
            path: self.path.into(),
            row,
            remedy: self.bodies.meant(&text),
            text,
        })?;
        if let Some(place) = number.and_then(|number| self.numbered.get_mut(number)) {
            *place = Some(id);
        }
        Ok(id)
    }

    fn frame(&self, row: u64, id: BodyId, cells: &[Cell]) -> Result<Frame, PoseTableError> {
        let [at, other] = match self.position_of {
            PositionOf::CentreOfMass => [POSITION, ORIGIN],
            PositionOf::Origin => [ORIGIN, POSITION],
        };
        // A later line of JSON may have what the first had not.
        if cells[other] != Cell::Empty {
            return Err(PoseTableError::TwoPositions { path: self.path.into() });
        }
        let turned = [0, 1, 2, 3].map(|k| ORIENTATION + k);
        let [qx, qy, qz, qw] = turned;
        let places = [TIME, at, at + 1, at + 2, qx, qy, qz, qw];
        let mut numbers = places.map(|place| cells[place].number().unwrap_or(f64::NAN));
        if !self.is_turned && turned.iter().all(|place| cells[*place] == Cell::Empty) {
            numbers[4..].copy_from_slice(&DQuat::IDENTITY.to_array());
        }
        if let Some(bad) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(PoseTableError::NotANumber {
                path: self.path.into(),
                body: self.bodies.name(id).into(),
                row,
                column: COLUMNS[places[bad]].into(),
                text: shown(&cells[places[bad]], "empty"),
            });
        }
        let [time, px, py, pz, x, y, z, w] = numbers;
        let pose = Pose { position: DVec3::new(px, py, pz), orientation: DQuat::from_xyzw(x, y, z, w) };
        Ok(Frame { time, pose, row })
    }
}

/// A cell as it stands in the file.
fn shown(cell: &Cell, empty: &str) -> String {
    match cell {
        Cell::Empty => empty.into(),
        Cell::Number(number) => number.to_string(),
        Cell::Text(text) => text.clone(),
    }
}
