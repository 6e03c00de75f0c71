//! Output that is whole or absent: files and folders are written under a temporary name beside their
//! destination, synchronised to the disk, and renamed.
//!
//! A run that fails, is interrupted or is dropped half-way leaves what was there before. A power cut or
//! `kill -9` leaves a temporary file beside the destination. It is never mistaken for the result, and the
//! next run that writes the same output removes it (`part`).

mod folder;
pub(super) mod part;

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

pub use folder::AtomicFolder;

/// Why an output could not be put in place.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The operating system refused.
    #[error("cannot {action} {path}: {source}")]
    Io {
        /// What was attempted.
        action: &'static str,
        /// On which path.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The folder to write into is missing.
    #[error("cannot write {path}: there is no folder {folder}; create it first")]
    NoFolder {
        /// The output.
        path: PathBuf,
        /// The missing folder.
        folder: PathBuf,
    },
    /// The destination exists and must not be replaced.
    #[error("{path} exists already; choose another name or replace it with --force")]
    Exists {
        /// The destination.
        path: PathBuf,
    },
    /// The destination is something that a rename must not replace.
    #[error("{path} exists and is not a {expected}; choose another name")]
    WrongKind {
        /// The destination.
        path: PathBuf,
        /// What may be replaced.
        expected: &'static str,
    },
}

impl OutputError {
    fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> OutputError {
        let path = path.to_path_buf();
        move |source| OutputError::Io { action, path, source }
    }
}

/// The folder that holds `path`, which must exist.
fn parent_folder(path: &Path) -> Result<&Path, OutputError> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if path.file_name().is_none() {
        return Err(OutputError::WrongKind { path: path.into(), expected: "file name" });
    }
    if !folder.is_dir() {
        return Err(OutputError::NoFolder { path: path.into(), folder: folder.into() });
    }
    Ok(folder)
}

/// Whether an output has a folder to go into.
///
/// # Errors
/// [`OutputError::NoFolder`], or [`OutputError::WrongKind`] for a path without a file name.
pub fn check_folder(path: &Path) -> Result<(), OutputError> {
    parent_folder(path).map(|_| ())
}

/// Makes a rename in `folder` durable. Only Unix can open a folder for that; elsewhere the file system
/// decides.
fn sync_folder(folder: &Path) -> Result<(), OutputError> {
    if cfg!(unix) {
        File::open(folder).and_then(|f| f.sync_all()).map_err(OutputError::io("synchronise", folder))?;
    }
    Ok(())
}

/// A file that appears under its name only when [`AtomicFile::commit`] succeeds; dropped before, it leaves
/// nothing.
#[derive(Debug)]
pub struct AtomicFile {
    file: Option<File>,
    part: PathBuf,
    destination: PathBuf,
}

impl AtomicFile {
    /// Starts a file that will replace `path`, or the file that a symbolic link at `path` leads to.
    ///
    /// # Errors
    /// [`OutputError`], among others where `path` is a folder or a device.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let destination = match fs::metadata(path) {
            Ok(found) if !found.is_file() => {
                return Err(OutputError::WrongKind { path: path.into(), expected: "regular file" });
            }
            Ok(_) => fs::canonicalize(path).map_err(OutputError::io("open", path))?,
            Err(_) => path.to_path_buf(),
        };
        parent_folder(&destination)?;
        part::remove_leftovers(&destination);
        let (part, file) = part::create_file(&destination)?;
        Ok(AtomicFile { file: Some(file), part, destination })
    }

    /// Where the file will appear.
    pub fn destination(&self) -> &Path {
        &self.destination
    }

    /// Puts the file in place of whatever bore its name.
    ///
    /// # Errors
    /// [`OutputError`]; the old file is then untouched.
    pub fn commit(mut self) -> Result<(), OutputError> {
        if let Some(file) = &self.file {
            file.sync_all().map_err(OutputError::io("write", &self.part))?;
        }
        fs::rename(&self.part, &self.destination).map_err(OutputError::io("write", &self.destination))?;
        // From here on there is nothing to remove.
        self.file = None;
        sync_folder(parent_folder(&self.destination)?)
    }

    fn open_file(&mut self) -> io::Result<&mut File> {
        self.file.as_mut().ok_or_else(|| io::Error::other("the file is closed"))
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if self.file.take().is_some() {
            // A failure to clean up has nowhere to go; the name tells what the leftover is.
            let _ = fs::remove_file(&self.part);
        }
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.open_file()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.open_file()?.flush()
    }
}

impl Read for AtomicFile {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.open_file()?.read(bytes)
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.open_file()?.seek(to)
    }
}

/// Writes a small file at once.
///
/// # Errors
/// As [`AtomicFile`].
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes).map_err(OutputError::io("write", path))?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn dropped_file_leaves_the_old_one_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        write_atomically(&path, b"old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"half of the n").unwrap();
        assert_eq!(names(folder.path()).len(), 2);
        drop(file);
        assert_eq!(names(folder.path()), ["a.wav"]);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write_atomically(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.wav"]);
    }

    #[test]
    fn folder_is_replaced_only_by_force_and_only_if_it_is_ours() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.timeline");
        let build = |replace, content: &str| {
            let part = AtomicFolder::create(&path, replace, "marker")?;
            fs::write(part.path().join("marker"), content).unwrap();
            part.commit()
        };
        build(false, "one").unwrap();
        assert!(matches!(build(false, "two"), Err(OutputError::Exists { .. })));
        build(true, "two").unwrap();
        assert_eq!(fs::read_to_string(path.join("marker")).unwrap(), "two");
        assert_eq!(names(folder.path()), ["run.timeline"]);

        let stranger = folder.path().join("photos");
        fs::create_dir(&stranger).unwrap();
        let refused = AtomicFolder::create(&stranger, true, "marker");
        assert!(matches!(refused, Err(OutputError::WrongKind { .. })));
        drop(AtomicFolder::create(&path, true, "marker").unwrap());
        assert_eq!(names(folder.path()), ["photos", "run.timeline"]);
    }

    #[test]
    fn impossible_places_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let missing = AtomicFile::create(&folder.path().join("no/a.wav")).unwrap_err().to_string();
        assert!(missing.contains("there is no folder"), "{missing}");
        assert!(matches!(AtomicFile::create(folder.path()), Err(OutputError::WrongKind { .. })));
        assert!(matches!(AtomicFile::create(Path::new("/")), Err(OutputError::WrongKind { .. })));
        assert!(AtomicFile::create(Path::new("..")).is_err());
        assert!(AtomicFile::create(Path::new("")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn symbolic_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("target"), folder.path().join("link"));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");
    }
}
