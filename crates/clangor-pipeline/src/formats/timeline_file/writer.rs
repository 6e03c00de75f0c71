//! Writing a timeline as it happens.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use clangor_core::body::{Body, Life};
use clangor_core::timeline::{ContactRow, ForceRow, FractureRow, PoseRow, TimelineSink};

use super::columns::EFFECTIVE_MASS_COLUMN;
use super::description::Description;
use super::description::decode::check_json;
use super::description::encode::describe;
use super::error::{RowProblem, TimelineError};
use super::files::{CONTACTS_FILE, DESCRIPTION_FILE, FRACTURES_FILE, MESH_FOLDER, POSES_FILE};
use super::force_writer::ForceWriter;
use super::header::TimelineHeader;
use super::summary::TimelineSummary;
use super::table::writer::TableWriter;
use crate::formats::atomic_file::AtomicFolder;

/// Writes one timeline; the folder appears under its name when [`TimelineWriter::finish`] succeeds, under
/// that of a part of it when [`TimelineWriter::keep`] does, and not at all otherwise.
pub struct TimelineWriter {
    folder: AtomicFolder,
    description: Description,
    contacts: TableWriter<ContactRow>,
    poses: TableWriter<PoseRow>,
    /// Only once something broke.
    fractures: Option<TableWriter<FractureRow>>,
    /// Only once there is one.
    forces: Option<ForceWriter>,
    /// Of all bodies so far.
    lives: Vec<Life>,
    /// Bodies at the beginning.
    start: usize,
    /// Hashes of the meshes that have been written.
    meshes: BTreeSet<String>,
    slack: f64,
    /// Time of the latest row \[s\].
    latest: f64,
}

impl TimelineWriter {
    /// Starts a timeline at `path`. An existing one is replaced only if `replace`, and stays until the new
    /// one is finished.
    ///
    /// # Errors
    /// [`TimelineError`] if the place cannot be written.
    pub fn create(path: &Path, header: &TimelineHeader, replace: bool) -> Result<Self, TimelineError> {
        Self::create_with(path, header, replace, &[])
    }

    /// As [`TimelineWriter::create`], for contacts some of which have an effective mass if
    /// `has_effective_mass`. Without, such a row is an error.
    ///
    /// # Errors
    /// [`TimelineError`] if the place cannot be written.
    pub fn create_for_contacts(
        path: &Path,
        header: &TimelineHeader,
        replace: bool,
        has_effective_mass: bool,
    ) -> Result<Self, TimelineError> {
        let optional: &[&str] = if has_effective_mass { &[EFFECTIVE_MASS_COLUMN] } else { &[] };
        Self::create_with(path, header, replace, optional)
    }

    /// With these optional columns of contacts.
    fn create_with(
        path: &Path,
        header: &TimelineHeader,
        replace: bool,
        optional: &[&str],
    ) -> Result<Self, TimelineError> {
        let folder = AtomicFolder::create(path, replace, DESCRIPTION_FILE)?;
        let (description, meshes) = describe(header);
        let description_file = folder.path().join(DESCRIPTION_FILE);
        // JSON turns NaN into null: better refused now than found when the file is read.
        let text = to_json(&description, &description_file)?;
        check_json(&description_file, &text)?;
        let lives: Vec<Life> = header.world.bodies.iter().map(|body| body.life).collect();
        let slack = header.origin.order_slack();
        let path = folder.path().join(CONTACTS_FILE);
        let contacts = TableWriter::create_with(&path, lives.clone(), slack, optional)?;
        let poses = TableWriter::create(&folder.path().join(POSES_FILE), lives.clone(), slack)?;
        let mut writer = TimelineWriter {
            folder,
            description,
            contacts,
            poses,
            fractures: None,
            forces: None,
            start: lives.len(),
            lives,
            meshes: BTreeSet::new(),
            slack,
            latest: 0.0,
        };
        writer.write_meshes(meshes)?;
        Ok(writer)
    }

    /// Writes the meshes, by hash, that are not there yet.
    fn write_meshes(
        &mut self,
        meshes: impl IntoIterator<Item = (String, Vec<u8>)>,
    ) -> Result<(), TimelineError> {
        let folder = self.folder.path().join(MESH_FOLDER);
        for (hash, bytes) in meshes {
            if self.meshes.is_empty() {
                fs::create_dir(&folder).map_err(io_error("create", &folder))?;
            }
            if self.meshes.insert(hash.clone()) {
                write_synchronised(&folder.join(format!("{hash}.ply")), &bytes)?;
            }
        }
        Ok(())
    }

    /// Appends a contact.
    pub(super) fn add_contact(&mut self, row: &ContactRow) -> Result<(), TimelineError> {
        self.latest = self.latest.max(row.time);
        self.contacts.push(row)
    }

    /// Appends a pose.
    pub(super) fn add_pose(&mut self, row: &PoseRow) -> Result<(), TimelineError> {
        self.latest = self.latest.max(row.time);
        self.poses.push(row)
    }

    /// Adds the pieces of a body that broke.
    pub(super) fn replace(&mut self, row: &FractureRow, pieces: &[Body]) -> Result<(), TimelineError> {
        let path = self.folder.path().join(FRACTURES_FILE);
        let known = self.lives.len();
        if row.first_child.index() != known
            || row.children as usize != pieces.len()
            || row.parent.index() >= known
        {
            let problem =
                RowProblem::Pieces { first: row.first_child.0, count: row.children, time: row.time };
            return Err(TimelineError::Row {
                path,
                row: self.fractures.as_ref().map_or(0, TableWriter::rows),
                problem,
            });
        }
        let lives: Vec<Life> = pieces.iter().map(|piece| piece.life).collect();
        self.lives[row.parent.index()].death = row.time;
        self.lives.extend_from_slice(&lives);
        self.contacts.replace(row.parent, &lives);
        self.poses.replace(row.parent, &lives);
        match &mut self.fractures {
            Some(table) => table.replace(row.parent, &lives),
            none => *none = Some(TableWriter::create(&path, self.lives.clone(), self.slack)?),
        }
        if let Some(table) = &mut self.fractures {
            table.push(row)?;
        }
        let meshes = self.description.replace(row.parent, pieces).map_err(|e| {
            let (line, column) = (e.line(), e.column());
            let path = self.folder.path().join(DESCRIPTION_FILE);
            TimelineError::Json { path, line, column, reason: format!("a piece: {e}") }
        })?;
        self.write_meshes(meshes)
    }

    /// Appends the force of a contact point. Rows come in order of time, up to the length of a contact
    /// ([`FORCE_REACH`](clangor_core::timeline::FORCE_REACH)); the contacts of the impact are written too,
    /// before or after.
    ///
    /// # Errors
    /// [`TimelineError`].
    pub fn force(&mut self, row: &ForceRow) -> Result<(), TimelineError> {
        let forces = match &mut self.forces {
            Some(forces) => forces,
            none => none.insert(ForceWriter::create(self.folder.path(), self.slack)?),
        };
        forces.push(row)
    }

    /// Makes the duration reach the latest row, where the header could not know it.
    pub(crate) fn extend_to_latest(&mut self) {
        self.description.extend(self.latest);
    }

    /// Completes the files and puts the folder in place.
    ///
    /// # Errors
    /// [`TimelineError`]; what was there before is then untouched.
    pub fn finish(self) -> Result<TimelineSummary, TimelineError> {
        let (folder, summary) = self.complete()?;
        folder.commit()?;
        Ok(summary)
    }

    /// Keeps what there is of a run that came to no end but `reached` a time \[s\]: as
    /// `NAME.partial.timeline`, which takes the place of an earlier one and whose duration is that time.
    /// Where and how long it is; `None` if nothing has happened.
    ///
    /// # Errors
    /// [`TimelineError`].
    pub fn keep(mut self, reached: f64) -> Result<Option<(PathBuf, f64)>, TimelineError> {
        let duration = self.latest.max(reached);
        if duration <= 0.0 {
            return Ok(None);
        }
        self.description.cut(duration);
        let path = self.folder.destination().with_extension("partial.timeline");
        let (folder, _) = self.complete()?;
        folder.divert(&path, DESCRIPTION_FILE)?.commit()?;
        Ok(Some((path, duration)))
    }

    /// Completes the files.
    fn complete(mut self) -> Result<(AtomicFolder, TimelineSummary), TimelineError> {
        let contacts = self.contacts.finish()?;
        let poses = self.poses.finish()?;
        let fractures = self.fractures.map(TableWriter::finish).transpose()?;
        let forces = self.forces.map(ForceWriter::finish).transpose()?;
        let summary = TimelineSummary {
            contacts: contacts.rows,
            poses: poses.rows,
            fractures: fractures.as_ref().map_or(0, |table| table.rows),
            births: (self.lives.len() - self.start) as u64,
            forces: forces.as_ref().map_or(0, |[table, _]| table.rows),
        };
        self.description.contacts = contacts;
        self.description.poses = poses;
        self.description.fractures = fractures;
        if let Some([forces, samples]) = forces {
            self.description.forces = Some(forces);
            self.description.force_samples = Some(samples);
        }
        let path = self.folder.path().join(DESCRIPTION_FILE);
        write_synchronised(&path, &to_json(&self.description, &path)?)?;
        Ok((self.folder, summary))
    }
}

impl TimelineSink for TimelineWriter {
    fn contact(&mut self, row: &ContactRow) -> std::io::Result<()> {
        self.add_contact(row).map_err(std::io::Error::other)
    }

    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        self.add_pose(row).map_err(std::io::Error::other)
    }

    fn fracture(&mut self, row: &FractureRow, children: &[Body]) -> std::io::Result<()> {
        self.latest = self.latest.max(row.time);
        self.replace(row, children).map_err(std::io::Error::other)
    }
}

fn to_json(description: &Description, path: &Path) -> Result<Vec<u8>, TimelineError> {
    serde_json::to_vec_pretty(description).map_err(|e| io_error("write", path)(e.into()))
}

fn write_synchronised(path: &Path, bytes: &[u8]) -> Result<(), TimelineError> {
    let mut file = File::create_new(path).map_err(io_error("create", path))?;
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(io_error("write", path))
}

fn io_error(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> TimelineError {
    let path = path.to_path_buf();
    move |source| TimelineError::Io { action, path, source }
}
