//! Whole files in memory, up to a size: a link to an endless device must not fill it.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Most that is read of what is no regular file, such as a pipe: its size is not known before.
const MOST_OF_A_STREAM: u64 = 64 << 20;

/// Reads a file of at most `most` bytes.
///
/// # Errors
/// Those of the system, and [`io::ErrorKind::FileTooLarge`] for a file or pipe with more.
pub fn read_bounded(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let found = file.metadata()?;
    let most = if found.is_file() { most } else { most.min(MOST_OF_A_STREAM) };
    let too_large = || io::Error::new(io::ErrorKind::FileTooLarge, format!("it has more than {most} bytes"));
    if found.is_file() && found.len() > most {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(too_large());
    }
    Ok(bytes)
}
