//! The program with one cache for all tests of a run: modes and fields of a body are found once.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use crate::program::{run_with_cache, text};

/// Empty when the first test asks for it: models of an older program are not used.
static CACHE: LazyLock<PathBuf> = LazyLock::new(|| {
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cross-models");
    let _ = std::fs::remove_dir_all(&cache);
    cache
});

/// Standard output of a command that must succeed.
pub(crate) fn clangor(folder: &Path, arguments: &[&str]) -> String {
    text(run_with_cache(folder, &CACHE, arguments), arguments)
}
