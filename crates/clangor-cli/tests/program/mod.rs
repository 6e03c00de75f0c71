//! The program, run in a folder, with a cache of its own there.

use std::path::Path;
use std::process::{Command, Output};

pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Output {
    run_with_cache(folder, &folder.join("cache"), arguments)
}

/// With another cache.
pub(crate) fn run_with_cache(folder: &Path, cache: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_clangor"));
    command.args(arguments).current_dir(folder).env("CLANGOR_CACHE", cache);
    command.output().expect("runs")
}

/// Standard output of a command that must succeed.
pub(crate) fn clangor(folder: &Path, arguments: &[&str]) -> String {
    text(run(folder, arguments), arguments)
}

/// Standard output of a command that has succeeded.
pub(crate) fn text(output: Output, arguments: &[&str]) -> String {
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}
