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
//! Columns `velocity_*` and `angular_velocity_*` may be there, as in the tables of timelines: motion is told
//! from the poses. The rows of a body come in order of time, up to 1 ms; those of several bodies may be
//! mixed.

use std::path::{Path, PathBuf};

use clangor_core::body::BodyId;
use clangor_core::pose::Pose;
use glam::{DQuat, DVec3};

use super::contact_list::body_of_number;
use super::record_table::{Cell, Record, RecordTable, RecordTableError, read_table};
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
    /// A column that means nothing.
    #[error("{path}: column {column} is unknown; docs/format/timeline.md lists the columns of poses")]
    Unknown {
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

/// Columns that are known, but not needed.
const IGNORED: [&str; 2] = ["velocity_", "angular_velocity_"];

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
    let table = read_table(path)?;
    let reader = Reader::new(path, &table)?;
    let mut bodies: Vec<(BodyId, Vec<Frame>)> = Vec::new();
    let mut place_of: Vec<Option<usize>> = vec![None; body_count];
    for record in &table.records {
        let text = match &record.cells[reader.body] {
            Cell::Text(text) => text.clone(),
            Cell::Number(number) => number.to_string(),
            Cell::Empty => String::new(),
        };
        let number = || body_of_number(&text, body_count);
        let id = body(&text).or_else(number);
        let id = id.ok_or_else(|| PoseTableError::Body { path: path.into(), row: record.row, text })?;
        let place = *place_of[id.index()].get_or_insert_with(|| {
            bodies.push((id, Vec::new()));
            bodies.len() - 1
        });
        insert(&mut bodies[place].1, reader.frame(record)?);
    }
    if bodies.is_empty() {
        return Err(PoseTableError::Empty { path: path.into() });
    }
    Ok(PoseTable { position_of: reader.position_of, bodies })
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

/// Places of the columns.
struct Reader<'a> {
    path: &'a Path,
    table: &'a RecordTable,
    time: usize,
    body: usize,
    position: [usize; 3],
    orientation: Option<[usize; 4]>,
    position_of: PositionOf,
}

impl<'a> Reader<'a> {
    fn new(path: &'a Path, table: &'a RecordTable) -> Result<Self, PoseTableError> {
        let place = |name: &str| table.columns.iter().position(|column| column == name);
        let needed = |name: String| {
            place(&name).ok_or_else(|| PoseTableError::Missing { path: path.into(), column: name })
        };
        let has_origin = place("origin_x").is_some();
        if has_origin && place("position_x").is_some() {
            return Err(PoseTableError::TwoPositions { path: path.into() });
        }
        let name = if has_origin { "origin" } else { "position" };
        let column = |name: &str, axis: &str| needed(format!("{name}_{axis}"));
        let orientation = if place("orientation_x").is_some() || place("orientation_w").is_some() {
            let axis = |axis| column("orientation", axis);
            Some([axis("x")?, axis("y")?, axis("z")?, axis("w")?])
        } else {
            None
        };
        let reader = Reader {
            path,
            table,
            time: needed("t".into())?,
            body: needed("body".into())?,
            position: [column(name, "x")?, column(name, "y")?, column(name, "z")?],
            orientation,
            position_of: if has_origin { PositionOf::Origin } else { PositionOf::CentreOfMass },
        };
        let mut used = vec![reader.time, reader.body];
        used.extend(reader.position.iter().chain(reader.orientation.iter().flatten()));
        let is_known =
            |at: usize, name: &str| used.contains(&at) || IGNORED.iter().any(|i| name.starts_with(i));
        let unknown = table.columns.iter().enumerate().find(|(at, name)| !is_known(*at, name));
        match unknown {
            Some((_, column)) => Err(PoseTableError::Unknown { path: path.into(), column: column.clone() }),
            None => Ok(reader),
        }
    }

    fn frame(&self, record: &Record) -> Result<Frame, PoseTableError> {
        let finite = |cell: &Cell| cell.number().filter(|number| number.is_finite());
        let number = |at: usize| match (finite(&record.cells[at]), &record.cells[at]) {
            (Some(number), _) => Ok(number),
            (None, other) => Err(PoseTableError::NotANumber {
                path: self.path.into(),
                row: record.row,
                column: self.table.columns[at].clone(),
                text: match other {
                    Cell::Empty => "empty".into(),
                    Cell::Number(number) => number.to_string(),
                    Cell::Text(text) => text.clone(),
                },
            }),
        };
        let [x, y, z] = self.position;
        let orientation = match self.orientation {
            Some([x, y, z, w]) => DQuat::from_xyzw(number(x)?, number(y)?, number(z)?, number(w)?),
            None => DQuat::IDENTITY,
        };
        Ok(Frame {
            time: number(self.time)?,
            pose: Pose { position: DVec3::new(number(x)?, number(y)?, number(z)?), orientation },
            row: record.row,
        })
    }
}
