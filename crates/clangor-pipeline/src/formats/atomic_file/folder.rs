//! Folders that are whole or absent.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::{OutputError, parent_folder, part, sync_folder};

/// A folder that appears under its name only when [`AtomicFolder::commit`] succeeds; dropped before, it
/// leaves nothing.
#[derive(Debug)]
pub struct AtomicFolder {
    part: PathBuf,
    destination: PathBuf,
    replace: bool,
    committed: bool,
    /// Keeps the lock while the folder is written.
    lock: Option<File>,
}

impl AtomicFolder {
    /// Starts a folder that will appear at `path`. One that exists is replaced only if `replace` and only if
    /// it holds `marker`, the file by which a folder of this kind is known: a mistyped path must not erase
    /// someone's work.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn create(path: &Path, replace: bool, marker: &str) -> Result<Self, OutputError> {
        let destination = match fs::symlink_metadata(path) {
            Ok(_) if !replace => return Err(OutputError::Exists { path: path.into() }),
            Ok(_) if !path.join(marker).is_file() => {
                return Err(OutputError::WrongKind {
                    path: path.into(),
                    expected: "folder written by this program",
                });
            }
            Ok(_) => fs::canonicalize(path).map_err(OutputError::io("open", path))?,
            Err(_) => path.to_path_buf(),
        };
        parent_folder(&destination)?;
        part::remove_leftovers(&destination);
        let (part, lock) = part::create_folder(&destination)?;
        Ok(AtomicFolder { part, destination, replace, committed: false, lock })
    }

    /// The folder to write into until then.
    pub fn path(&self) -> &Path {
        &self.part
    }

    /// Where the folder will appear.
    pub fn destination(&self) -> &Path {
        &self.destination
    }

    /// Lets the folder appear at another place, where it replaces what bears `marker`.
    ///
    /// # Errors
    /// [`OutputError`] where something else is; the folder is gone then.
    pub fn divert(mut self, path: &Path, marker: &str) -> Result<Self, OutputError> {
        if fs::symlink_metadata(path).is_ok() && !path.join(marker).is_file() {
            return Err(OutputError::WrongKind {
                path: path.into(),
                expected: "folder written by this program",
            });
        }
        self.destination = path.into();
        self.replace = true;
        Ok(self)
    }

    /// Puts the folder in place. Its files must have been synchronised by whoever wrote them.
    ///
    /// An old folder is first renamed to `NAME.old-RANDOM`, then the new one takes its name, then the old one
    /// is removed: a folder cannot be renamed over another. A run killed between the two renames leaves both,
    /// whole. The next run that writes there removes an old folder beside a complete new one.
    ///
    /// # Errors
    /// [`OutputError`]; the old folder is then back in place.
    pub fn commit(mut self) -> Result<(), OutputError> {
        sync_folder(&self.part)?;
        let old = self.set_aside()?;
        if let Err(error) = fs::rename(&self.part, &self.destination) {
            if let Some(old) = &old {
                fs::rename(old, &self.destination).map_err(OutputError::io("restore", old))?;
            }
            return Err(OutputError::io("write", &self.destination)(error));
        }
        self.committed = true;
        sync_folder(parent_folder(&self.destination)?)?;
        match old {
            Some(old) => match fs::remove_dir_all(&old) {
                // Another run may have removed it.
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    Err(OutputError::io("remove the replaced", &old)(error))
                }
                _ => Ok(()),
            },
            None => Ok(()),
        }
    }

    fn set_aside(&self) -> Result<Option<PathBuf>, OutputError> {
        if fs::symlink_metadata(&self.destination).is_err() {
            return Ok(None);
        }
        if !self.replace {
            return Err(OutputError::Exists { path: self.destination.clone() });
        }
        let old = part::random_name(&self.destination, part::OLD);
        fs::rename(&self.destination, &old).map_err(OutputError::io("replace", &self.destination))?;
        Ok(Some(old))
    }
}

impl Drop for AtomicFolder {
    fn drop(&mut self) {
        if !self.committed {
            // As for a file: nobody can be told. The lock is held until the folder is gone.
            let _ = fs::remove_dir_all(&self.part);
            self.lock = None;
        }
    }
}
