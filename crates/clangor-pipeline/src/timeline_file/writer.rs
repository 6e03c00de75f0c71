//! Writing a timeline as it happens.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use clangor::timeline::{ContactRow, PoseRow, TimelineSink};

use super::description::{Description, check_json, describe};
use super::table::TableWriter;
use super::{CONTACTS_FILE, DESCRIPTION_FILE, MESH_FOLDER, POSES_FILE, TimelineError, TimelineHeader};
use crate::atomic_file::AtomicFolder;

/// What a finished timeline holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimelineSummary {
    /// Contact rows.
    pub contacts: u64,
    /// Pose rows.
    pub poses: u64,
}

/// Writes one timeline; the folder appears under its name when [`TimelineWriter::finish`] succeeds, and not at all
/// otherwise.
pub struct TimelineWriter {
    folder: AtomicFolder,
    description: Description,
    contacts: TableWriter<ContactRow>,
    poses: TableWriter<PoseRow>,
}

impl TimelineWriter {
    /// Starts a timeline at `path`. An existing one is replaced only if `replace`, and stays until the new one is
    /// finished.
    ///
    /// # Errors
    /// [`TimelineError`] if the place cannot be written.
    pub fn create(path: &Path, header: &TimelineHeader, replace: bool) -> Result<Self, TimelineError> {
        let folder = AtomicFolder::create(path, replace, DESCRIPTION_FILE)?;
        let (description, meshes) = describe(header);
        let description_file = folder.path().join(DESCRIPTION_FILE);
        // JSON turns NaN into null: better refused now than found when the file is read.
        let text = to_json(&description, &description_file)?;
        check_json(&description_file, &text)?;
        if !meshes.is_empty() {
            let mesh_folder = folder.path().join(MESH_FOLDER);
            fs::create_dir(&mesh_folder).map_err(io_error("create", &mesh_folder))?;
            for (hash, bytes) in meshes {
                write_synchronised(&mesh_folder.join(format!("{hash}.ply")), &bytes)?;
            }
        }
        let bodies = header.world.bodies.len();
        let slack = header.origin.order_slack();
        let contacts = TableWriter::create(&folder.path().join(CONTACTS_FILE), bodies, slack)?;
        let poses = TableWriter::create(&folder.path().join(POSES_FILE), bodies, slack)?;
        Ok(TimelineWriter { folder, description, contacts, poses })
    }

    /// Completes the files and puts the folder in place.
    ///
    /// # Errors
    /// [`TimelineError`]; what was there before is then untouched.
    pub fn finish(mut self) -> Result<TimelineSummary, TimelineError> {
        let contacts = self.contacts.finish()?;
        let poses = self.poses.finish()?;
        let summary = TimelineSummary { contacts: contacts.rows, poses: poses.rows };
        self.description.contacts = contacts;
        self.description.poses = poses;
        let path = self.folder.path().join(DESCRIPTION_FILE);
        write_synchronised(&path, &to_json(&self.description, &path)?)?;
        self.folder.commit()?;
        Ok(summary)
    }
}

impl TimelineSink for TimelineWriter {
    fn contact(&mut self, row: &ContactRow) -> std::io::Result<()> {
        self.contacts.push(row).map_err(std::io::Error::other)
    }

    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        self.poses.push(row).map_err(std::io::Error::other)
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
