//! Temporary files and folders beside an output, and the removal of those whose owner is dead.
//!
//! `NAME.part-RANDOM` has 16 random hexadecimal digits: process numbers repeat, in containers above all. Its
//! owner holds an exclusive lock on it for as long as it writes. The system releases the lock when the
//! process ends, however it ends, so a temporary file that can be locked has no owner and is removed. Where
//! a file system has no locks, or for folders on Windows, leftovers stay.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io;
use std::path::{Path, PathBuf};

use super::OutputError;

/// Follows the name of an output in that of its temporary file.
const PART: &str = ".part-";
/// Follows the name of a folder while another takes its place.
pub(super) const OLD: &str = ".old-";
/// Number of random digits.
const DIGITS: usize = 16;
/// Names tried until one can be created and locked.
const ATTEMPTS: usize = 16;

/// A name beside `destination` that nothing else bears.
pub(super) fn random_name(destination: &Path, infix: &str) -> PathBuf {
    let mut name = base_name(destination);
    // The standard library seeds each hasher anew from the system's random numbers.
    name.push(format!("{infix}{:016x}", RandomState::new().build_hasher().finish()));
    destination.with_file_name(name)
}

fn base_name(destination: &Path) -> OsString {
    destination.file_name().unwrap_or_default().to_os_string()
}

/// Creates and locks a temporary file for an output.
pub(super) fn create_file(destination: &Path) -> Result<(PathBuf, File), OutputError> {
    create(destination, |part| OpenOptions::new().read(true).write(true).create_new(true).open(part))
}

/// Creates a temporary folder for an output, and locks it where folders can be opened.
pub(super) fn create_folder(destination: &Path) -> Result<(PathBuf, Option<File>), OutputError> {
    create(destination, |part| fs::create_dir(part).map(|()| File::open(part).ok()))
}

/// What a temporary name leads to, with the lock of its owner.
trait Lockable {
    fn handle(&self) -> Option<&File>;
}

impl Lockable for File {
    fn handle(&self) -> Option<&File> {
        Some(self)
    }
}

impl Lockable for Option<File> {
    fn handle(&self) -> Option<&File> {
        self.as_ref()
    }
}

fn create<T: Lockable>(
    destination: &Path,
    make: impl Fn(&Path) -> io::Result<T>,
) -> Result<(PathBuf, T), OutputError> {
    let mut part = random_name(destination, PART);
    for _ in 0..ATTEMPTS {
        match make(&part) {
            Ok(made) if is_ours(&part, made.handle()) => return Ok((part, made)),
            // Another run has taken it for a leftover, between its creation and its lock.
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(OutputError::io("create", &part)(error)),
        }
        part = random_name(destination, PART);
    }
    Err(OutputError::io("create", &part)(io::Error::other("its temporary names are taken")))
}

/// Locks what was created; `false` where another run has locked or removed it.
fn is_ours(part: &Path, handle: Option<&File>) -> bool {
    let is_locked_by_another =
        handle.is_some_and(|handle| matches!(handle.try_lock(), Err(TryLockError::WouldBlock)));
    !is_locked_by_another && fs::symlink_metadata(part).is_ok()
}

/// Removes what dead processes have left of an output. Failures are ignored: the next run tries again.
pub(super) fn remove_leftovers(destination: &Path) {
    let Some(folder) = destination.parent() else { return };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let base = base_name(destination);
    let of_output = |infix: &str, name: &std::ffi::OsStr| {
        name.as_encoded_bytes()
            .strip_prefix(base.as_encoded_bytes())
            .and_then(|rest| rest.strip_prefix(infix.as_bytes()))
            .is_some_and(|digits| digits.len() == DIGITS && digits.iter().all(u8::is_ascii_hexdigit))
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if of_output(PART, &entry.file_name()) {
            remove_abandoned(&entry.path());
        } else if of_output(OLD, &entry.file_name()) && fs::symlink_metadata(destination).is_ok() {
            // The new folder is complete: nothing will restore the old one.
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Removes a temporary file or folder if no process holds its lock.
pub(in super::super) fn remove_abandoned(part: &Path) {
    let Ok(found) = fs::symlink_metadata(part) else { return };
    // Anything else, such as a pipe, is not ours, and might block when it is opened.
    if !found.is_file() && !found.is_dir() {
        return;
    }
    let Ok(handle) = File::open(part) else { return };
    if handle.try_lock().is_ok() {
        let _ = if found.is_dir() { fs::remove_dir_all(part) } else { fs::remove_file(part) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leftovers_of_the_dead_go_and_those_of_the_living_stay() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.wav");
        let (living, _lock) = create_file(&output).unwrap();
        let (living_folder, _folder_lock) = create_folder(&output).unwrap();
        let (dead, lock) = create_file(&output).unwrap();
        let (dead_folder, folder_lock) = create_folder(&output).unwrap();
        drop((lock, folder_lock));
        fs::write(dead_folder.join("poses.parquet"), "half").unwrap();
        // Names that are not ours.
        let others = ["a.wav.part-2", "b.wav.part-0123456789abcdef", "a.wav.part-0123456789abcdeg"];
        others.iter().for_each(|name| fs::write(folder.path().join(name), "mine").unwrap());
        remove_leftovers(&output);
        assert!(living.exists() && living_folder.exists());
        assert!(!dead.exists());
        assert_eq!(dead_folder.exists(), cfg!(windows));
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
    }
}
