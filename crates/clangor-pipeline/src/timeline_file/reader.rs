//! Reading a timeline, a block of rows at a time.

use std::fs;
use std::path::{Path, PathBuf};

use clangor::timeline::{ContactRow, PoseRow, Timeline};

use super::columns::TableRow;
use super::table::TableReader;
use super::{
    CONTACTS_FILE, DESCRIPTION_FILE, POSES_FILE, TimelineError, TimelineHeader, TimelineSummary, description,
    hash,
};

/// A timeline on disk. Opening reads its description and meshes; rows are read by the iterators.
#[derive(Debug)]
pub struct TimelineReader {
    folder: PathBuf,
    header: TimelineHeader,
    program: String,
    rows: TimelineSummary,
}

impl TimelineReader {
    /// Opens the folder and checks everything but the values in the rows.
    ///
    /// # Errors
    /// [`TimelineError`] names the file and the place in it.
    pub fn open(folder: &Path) -> Result<Self, TimelineError> {
        let path = folder.join(DESCRIPTION_FILE);
        let text = fs::read(&path).map_err(|source| hash::read_error(&path, source))?;
        let (description, header) = description::read(&path, &text, folder)?;
        let rows = TimelineSummary { contacts: description.contacts.rows, poses: description.poses.rows };
        for (name, table) in [(CONTACTS_FILE, &description.contacts), (POSES_FILE, &description.poses)] {
            if let Some(hash) = &table.hash {
                hash::check_file(&folder.join(name), hash)?;
            }
        }
        let reader = TimelineReader { folder: folder.into(), header, program: description.program, rows };
        // Both tables must at least begin and end well.
        let _ = reader.contacts()?;
        let _ = reader.poses()?;
        Ok(reader)
    }

    /// Everything but the rows.
    pub fn header(&self) -> &TimelineHeader {
        &self.header
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
        self.table::<ContactRow>(CONTACTS_FILE, self.rows.contacts)
    }

    /// The poses, in the order in which they were written.
    ///
    /// # Errors
    /// As [`TimelineReader::contacts`].
    pub fn poses(
        &self,
    ) -> Result<impl Iterator<Item = Result<PoseRow, TimelineError>> + use<>, TimelineError> {
        self.table::<PoseRow>(POSES_FILE, self.rows.poses)
    }

    /// All rows in memory, sorted by time.
    ///
    /// # Errors
    /// As [`TimelineReader::contacts`].
    pub fn read_all(&self) -> Result<Timeline, TimelineError> {
        let mut timeline = Timeline {
            contacts: self.contacts()?.collect::<Result<_, _>>()?,
            poses: self.poses()?.collect::<Result<_, _>>()?,
        };
        timeline.contacts.sort_by(|a, b| a.time.total_cmp(&b.time));
        timeline.poses.sort_by(|a, b| a.time.total_cmp(&b.time));
        Ok(timeline)
    }

    fn table<R: TableRow>(&self, name: &str, promised: u64) -> Result<Rows<R>, TimelineError> {
        let bodies = self.header.world.bodies.len();
        let slack = self.header.origin.order_slack();
        Ok(Rows {
            table: TableReader::open(&self.folder.join(name), promised, bodies, slack)?,
            next: 0,
            ended: false,
        })
    }
}

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
