//! Reading a timeline, a block of rows at a time.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clangor_core::body::{Body, Life};
use clangor_core::timeline::{ContactRow, ForceRow, FractureRow, PoseRow, Timeline};

use super::columns::{EFFECTIVE_MASS_COLUMN, TableRow};
use super::description::decode;
use super::error::{RowProblem, TimelineError};
use super::files::{CONTACTS_FILE, DESCRIPTION_FILE, FORCES_FILE, FRACTURES_FILE, POSES_FILE, SAMPLES_FILE};
use super::force_columns::{ShapeReader, StoredForce, StoredSample};
use super::force_writer::force_slack;
use super::hash;
use super::header::TimelineHeader;
use super::summary::TimelineSummary;
use super::table::reader::TableReader;

/// A timeline on disk. Opening reads its description and meshes; rows are read by the iterators.
#[derive(Debug)]
pub struct TimelineReader {
    folder: PathBuf,
    header: TimelineHeader,
    births: Vec<Body>,
    fractures: Vec<FractureRow>,
    program: String,
    rows: TimelineSummary,
    /// Samples of forces.
    samples: u64,
}

impl TimelineReader {
    /// Opens the folder and checks everything but the values in the rows.
    ///
    /// # Errors
    /// [`TimelineError`] names the file and the place in it.
    pub fn open(folder: &Path) -> Result<Self, TimelineError> {
        let path = folder.join(DESCRIPTION_FILE);
        let text = fs::read(&path).map_err(|source| hash::read_error(&path, source))?;
        let (description, mut header) = decode::read(&path, &text, folder)?;
        let births = split_births(&path, &mut header.world.bodies)?;
        let tables = [
            (CONTACTS_FILE, Some(&description.contacts)),
            (POSES_FILE, Some(&description.poses)),
            (FRACTURES_FILE, description.fractures.as_ref()),
            (FORCES_FILE, description.forces.as_ref()),
            (SAMPLES_FILE, description.force_samples.as_ref()),
        ];
        for (name, table) in tables {
            if let Some(hash) = table.and_then(|table| table.hash.as_ref()) {
                hash::check_file(&folder.join(name), hash)?;
            }
        }
        let rows = TimelineSummary {
            contacts: description.contacts.rows,
            poses: description.poses.rows,
            fractures: description.fractures.map_or(0, |table| table.rows),
            births: births.len() as u64,
            forces: description.forces.map_or(0, |table| table.rows),
        };
        let samples = description.force_samples.map_or(0, |table| table.rows);
        let program = description.program;
        let mut reader = TimelineReader {
            folder: folder.into(),
            header,
            births,
            fractures: Vec::new(),
            program,
            rows,
            samples,
        };
        // All tables must at least begin and end well.
        let _ = reader.contacts()?;
        let _ = reader.poses()?;
        let _ = reader.force_tables()?;
        reader.read_fractures()?;
        Ok(reader)
    }

    /// Everything but the rows.
    pub fn header(&self) -> &TimelineHeader {
        &self.header
    }

    /// Every body that ever was, in the order of their ids: those of the header, then those born later.
    pub fn bodies(&self) -> Vec<Body> {
        [&self.header.world.bodies[..], &self.births].concat()
    }

    /// Those born after the beginning, in the order of their ids.
    pub fn births(&self) -> &[Body] {
        &self.births
    }

    /// The fractures, in order of time.
    pub fn fractures(&self) -> &[FractureRow] {
        &self.fractures
    }

    /// The program that wrote it, with its version.
    pub fn program(&self) -> &str {
        &self.program
    }

    /// How many rows there are.
    pub fn rows(&self) -> TimelineSummary {
        self.rows
    }

    /// The contacts, in the order in which they were written.
    ///
    /// # Errors
    /// [`TimelineError`] if the table cannot be opened; the iterator yields one and ends if a row is wrong.
    pub fn contacts(
        &self,
    ) -> Result<impl Iterator<Item = Result<ContactRow, TimelineError>> + use<>, TimelineError> {
        self.table::<ContactRow>(CONTACTS_FILE, self.rows.contacts, self.header.origin.order_slack())
    }

    /// Whether the table of contacts has effective masses.
    pub(super) fn has_effective_mass(&self) -> Result<bool, TimelineError> {
        let slack = self.header.origin.order_slack();
        let contacts = self.table::<ContactRow>(CONTACTS_FILE, self.rows.contacts, slack)?;
        Ok(contacts.table.has_column(EFFECTIVE_MASS_COLUMN))
    }

    /// The poses, in the order in which they were written.
    ///
    /// # Errors
    /// As [`TimelineReader::contacts`].
    pub fn poses(
        &self,
    ) -> Result<impl Iterator<Item = Result<PoseRow, TimelineError>> + use<>, TimelineError> {
        self.table::<PoseRow>(POSES_FILE, self.rows.poses, self.header.origin.order_slack())
    }

    /// All rows in memory, sorted by time.
    ///
    /// # Errors
    /// As [`TimelineReader::contacts`].
    pub fn read_all(&self) -> Result<Timeline, TimelineError> {
        let mut timeline = Timeline {
            contacts: self.contacts()?.collect::<Result<_, _>>()?,
            poses: self.poses()?.collect::<Result<_, _>>()?,
            fractures: self.fractures.clone(),
            births: self.births.clone(),
            forces: Vec::new(),
        };
        timeline.contacts.sort_by(|a, b| a.time.total_cmp(&b.time));
        timeline.poses.sort_by(|a, b| a.time.total_cmp(&b.time));
        timeline.forces = self.forces_of(&timeline.impacts())?;
        Ok(timeline)
    }

    /// The recorded forces of `impacts`, which are all there are, sorted by time; none for a timeline
    /// without.
    ///
    /// # Errors
    /// As [`TimelineReader::contacts`], and [`RowProblem::Impact`] for a force of an unknown impact.
    pub fn forces_of(&self, impacts: &BTreeSet<u64>) -> Result<Vec<ForceRow>, TimelineError> {
        let Some((table, samples)) = self.force_tables()? else { return Ok(Vec::new()) };
        let samples =
            samples.map(|sample| sample.map(|sample| sample.value as f32)).collect::<Result<_, _>>()?;
        let mut shapes = ShapeReader::new(samples);
        let mut forces = Vec::new();
        for (row, stored) in table.enumerate() {
            let stored = stored?;
            let known = impacts.contains(&stored.impact_id);
            let force = if known {
                shapes.join(&stored)
            } else {
                Err(RowProblem::Impact { impact_id: stored.impact_id })
            };
            let path = self.folder.join(FORCES_FILE);
            forces.push(force.map_err(|problem| TimelineError::Row { path, row: row as u64, problem })?);
        }
        forces.sort_by(|a, b| a.time.total_cmp(&b.time));
        Ok(forces)
    }

    /// The tables of forces and samples; `None` for a timeline without.
    fn force_tables(&self) -> Result<Option<ForceTables>, TimelineError> {
        if self.rows.forces == 0 {
            return Ok(None);
        }
        let slack = force_slack(self.header.origin.order_slack());
        let forces = self.table(FORCES_FILE, self.rows.forces, slack)?;
        Ok(Some((forces, self.table(SAMPLES_FILE, self.samples, 0.0)?)))
    }

    /// Reads the fractures, and checks that the pieces are theirs one after the other.
    fn read_fractures(&mut self) -> Result<(), TimelineError> {
        let start = self.header.world.bodies.len();
        let mut next = start;
        if self.rows.fractures > 0 {
            let path = self.folder.join(FRACTURES_FILE);
            let slack = self.header.origin.order_slack();
            let table = self.table::<FractureRow>(FRACTURES_FILE, self.rows.fractures, slack)?;
            for (row, fracture) in table.enumerate() {
                let fracture = fracture?;
                if fracture.first_child.index() != next {
                    let FractureRow { first_child, children, time, .. } = fracture;
                    let problem = RowProblem::Pieces { first: first_child.0, count: children, time };
                    return Err(TimelineError::Row { path, row: row as u64, problem });
                }
                next += fracture.children as usize;
                self.fractures.push(fracture);
            }
        }
        if next != start + self.births.len() {
            let (field, path) = (format!("bodies[{next}].life"), self.folder.join(DESCRIPTION_FILE));
            let problem = format!("has a parent, but {FRACTURES_FILE} does not know how it broke");
            return Err(TimelineError::Field { path, field, problem });
        }
        Ok(())
    }

    fn table<R: TableRow>(&self, name: &str, promised: u64, slack: f64) -> Result<Rows<R>, TimelineError> {
        let lives: Vec<Life> = self.header.world.bodies.iter().chain(&self.births).map(|b| b.life).collect();
        Ok(Rows {
            table: TableReader::open(&self.folder.join(name), promised, lives, slack)?,
            next: 0,
            ended: false,
        })
    }
}

/// Takes those that are pieces of others, which must come last, out of the list.
fn split_births(path: &Path, bodies: &mut Vec<Body>) -> Result<Vec<Body>, TimelineError> {
    let start = bodies.iter().position(|body| body.life.parent.is_some()).unwrap_or(bodies.len());
    let births = bodies.split_off(start);
    if let Some(at) = births.iter().position(|body| body.life.parent.is_none()) {
        let field = format!("bodies[{}].life", start + at);
        let problem = "has no parent, but comes after a body that has one".into();
        return Err(TimelineError::Field { path: path.into(), field, problem });
    }
    Ok(births)
}

/// The forces, and the samples of their shapes.
type ForceTables = (Rows<StoredForce>, Rows<StoredSample>);

/// The rows of a table, one after another; a fault is the last item.
struct Rows<R: TableRow> {
    table: TableReader<R>,
    next: usize,
    ended: bool,
}

impl<R: TableRow> Iterator for Rows<R> {
    type Item = Result<R, TimelineError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.next == self.table.block().len() {
            if self.ended {
                return None;
            }
            self.next = 0;
            if let Err(error) = self.table.next_block() {
                self.ended = true;
                return Some(Err(error));
            }
            self.ended = self.table.block().is_empty();
        }
        let row = self.table.block().get(self.next).copied()?;
        self.next += 1;
        Some(Ok(row))
    }
}
