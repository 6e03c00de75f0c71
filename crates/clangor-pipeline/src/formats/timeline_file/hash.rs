//! Hashes that name meshes and tell whether a file is still what was written.
//!
//! XXH3-128 is stable, fast enough not to be felt (a gigabyte in 0.1 s), and finds duplicates and accidental
//! damage. It is no protection against forgery.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use twox_hash::xxhash3_128::Hasher;

use super::error::TimelineError;

/// The hash of a file's content, 32 hexadecimal digits.
pub(super) fn of(content: &[u8]) -> String {
    digits(Hasher::oneshot(content))
}

/// Refuses a file whose content has another hash than it should.
pub(super) fn check_file(path: &Path, expected: &str) -> Result<(), TimelineError> {
    check(path, &of_file(path).map_err(|source| read_error(path, source))?, expected)
}

/// Refuses a hash that is not the one expected.
pub(super) fn check(path: &Path, found: &str, expected: &str) -> Result<(), TimelineError> {
    if found == expected {
        return Ok(());
    }
    Err(TimelineError::Changed { path: path.into(), found: found.into(), expected: expected.into() })
}

/// What it means that a file of a timeline cannot be read.
pub(super) fn read_error(path: &Path, source: io::Error) -> TimelineError {
    match source.kind() {
        io::ErrorKind::NotFound => TimelineError::Missing { path: path.into() },
        _ => TimelineError::Io { action: "read", path: path.into(), source },
    }
}

fn of_file(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hasher = Hasher::new();
    let mut block = vec![0; 1 << 20];
    loop {
        match file.read(&mut block)? {
            0 => return Ok(digits(hasher.finish_128())),
            length => hasher.write(&block[..length]),
        }
    }
}

fn digits(hash: u128) -> String {
    format!("{hash:032x}")
}

/// A file that is hashed as it is written, from its beginning to its end.
pub(super) struct HashedFile {
    file: File,
    hasher: Hasher,
}

impl HashedFile {
    /// Hashes what is written to this empty file.
    pub(super) fn new(file: File) -> Self {
        HashedFile { file, hasher: Hasher::new() }
    }

    /// Synchronises the file; returns its hash.
    pub(super) fn finish(self) -> io::Result<String> {
        self.file.sync_all()?;
        Ok(digits(self.hasher.finish_128()))
    }
}

impl Write for HashedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.hasher.write(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
