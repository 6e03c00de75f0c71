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

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use clangor_core::body::BodyId;
use clangor_core::pose::Pose;
use glam::{DQuat, DVec3};

use super::contact_list::body_of_number;
use super::record_table::{Cell, RecordTableError, RowSink, read_rows};
use crate::motion::recording::Frame;

/// Frames this near to each other at one time are one \[m\].
const SAME_PLACE: f64 = 1e-6;

/// How late a row may come \[s\]: timelines write an impact when it is over.
const LATE: f64 = 1e-3;

/// What a position of a row is that of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionOf {
    /// The centre of mass.
    CentreOfMass,
    /// The origin of the shape or file.
    Origin,
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
    #[error("{path} has no column {column}; docs/format/timeline.md lists the columns of poses")]
    Missing {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// Positions in two ways.
    #[error("{path} has both position and origin; leave out one")]
    TwoPositions {
        /// The file.
        path: PathBuf,
    },
    /// A value that is no finite number.
    #[error("{path}, row {row}: {column} is {text}, not a finite number")]
    NotANumber {
        /// The file.
        path: PathBuf,
        /// Line of a text, row of a Parquet file.
        row: u64,
        /// The column.
        column: String,
        /// What is there.
        text: String,
    },
    /// A body that does not exist.
    #[error("{path}, row {row}: body is {text}, which is neither the name nor the number of a body")]
    Body {
        /// The file.
        path: PathBuf,
        /// Line of a text, row of a Parquet file.
        row: u64,
        /// What is there.
        text: String,
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

/// Reads poses; `body` finds a body by its name, and a text that is no name may be a number below
/// `body_count`.
///
/// # Errors
/// [`PoseTableError`] names the file, the row and the column.
pub fn read_pose_table(
    path: &Path,
    body_count: usize,
    body: &dyn Fn(&str) -> Option<BodyId>,
) -> Result<PoseTable, PoseTableError> {
    let mut reader = Reader {
        path,
        find: body,
        body_count,
        ids: HashMap::new(),
        place_of: vec![None; body_count],
        bodies: Vec::new(),
        position_of: PositionOf::CentreOfMass,
        is_turned: false,
    };
    read_rows(path, &mut reader)?;
    if reader.bodies.is_empty() {
        return Err(PoseTableError::Empty { path: path.into() });
    }
    Ok(PoseTable { position_of: reader.position_of, bodies: reader.bodies })
}

/// Adds a frame, a little late ones in their place. Timelines have a row at an impact besides that of the
/// same instant; it is left out.
fn insert(frames: &mut Vec<Frame>, frame: Frame) {
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

/// Collects the frames of the bodies.
struct Reader<'a> {
    path: &'a Path,
    find: &'a dyn Fn(&str) -> Option<BodyId>,
    body_count: usize,
    /// Bodies of the texts so far.
    ids: HashMap<String, BodyId>,
    /// Places of the bodies in `bodies`.
    place_of: Vec<Option<usize>>,
    bodies: Vec<(BodyId, Vec<Frame>)>,
    position_of: PositionOf,
    is_turned: bool,
}

impl RowSink for Reader<'_> {
    type Error = PoseTableError;

    fn known(&self) -> &[&'static str] {
        &COLUMNS
    }

    fn is_ignored(&self, name: &str) -> bool {
        IGNORED.iter().any(|beginning| name.starts_with(beginning))
    }

    fn columns(&mut self, present: &[bool]) -> Result<(), PoseTableError> {
        if present[ORIGIN] && present[POSITION] {
            return Err(PoseTableError::TwoPositions { path: self.path.into() });
        }
        let position = if present[ORIGIN] { ORIGIN } else { POSITION };
        self.position_of = if present[ORIGIN] { PositionOf::Origin } else { PositionOf::CentreOfMass };
        self.is_turned = present[ORIENTATION..].contains(&true);
        let turned = self.is_turned.then_some(ORIENTATION..ORIENTATION + 4).into_iter().flatten();
        let mut needed = [TIME, BODY].into_iter().chain(position..position + 3).chain(turned);
        match needed.find(|place| !present[*place]) {
            Some(place) => {
                Err(PoseTableError::Missing { path: self.path.into(), column: COLUMNS[place].into() })
            }
            None => Ok(()),
        }
    }

    fn row(&mut self, row: u64, cells: &[Cell]) -> Result<(), PoseTableError> {
        let id = self.body(row, &cells[BODY])?;
        let frame = self.frame(row, cells)?;
        let place = *self.place_of[id.index()].get_or_insert_with(|| {
            self.bodies.push((id, Vec::new()));
            self.bodies.len() - 1
        });
        insert(&mut self.bodies[place].1, frame);
        Ok(())
    }
}

impl Reader<'_> {
    fn body(&mut self, row: u64, cell: &Cell) -> Result<BodyId, PoseTableError> {
        if let Cell::Text(text) = cell
            && let Some(id) = self.ids.get(text)
        {
            return Ok(*id);
        }
        let text = shown(cell, "");
        let id = (self.find)(&text).or_else(|| body_of_number(&text, self.body_count));
        let id =
            id.ok_or_else(|| PoseTableError::Body { path: self.path.into(), row, text: text.clone() })?;
        if matches!(cell, Cell::Text(_)) {
            self.ids.insert(text, id);
        }
        Ok(id)
    }

    fn frame(&self, row: u64, cells: &[Cell]) -> Result<Frame, PoseTableError> {
        let number = |at: usize| {
            let finite = cells[at].number().filter(|number| number.is_finite());
            finite.ok_or_else(|| PoseTableError::NotANumber {
                path: self.path.into(),
                row,
                column: COLUMNS[at].into(),
                text: shown(&cells[at], "empty"),
            })
        };
        let [at, other] = match self.position_of {
            PositionOf::CentreOfMass => [POSITION, ORIGIN],
            PositionOf::Origin => [ORIGIN, POSITION],
        };
        // A later line of JSON may have what the first had not.
        if cells[other] != Cell::Empty {
            return Err(PoseTableError::TwoPositions { path: self.path.into() });
        }
        let is_turned = self.is_turned || cells[ORIENTATION..].iter().any(|cell| *cell != Cell::Empty);
        let [x, y, z, w] = std::array::from_fn(|k| ORIENTATION + k);
        let orientation = match is_turned {
            true => DQuat::from_xyzw(number(x)?, number(y)?, number(z)?, number(w)?),
            false => DQuat::IDENTITY,
        };
        let position = DVec3::new(number(at)?, number(at + 1)?, number(at + 2)?);
        Ok(Frame { time: number(TIME)?, pose: Pose { position, orientation }, row })
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
