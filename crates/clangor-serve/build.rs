//! Puts the files of `web/dist`, where it has been built, into the program.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() {
    if let Err(error) = embed() {
        println!("cargo::error={error}");
    }
}

fn embed() -> Result<(), String> {
    let variable = |name| env::var_os(name).map(PathBuf::from).ok_or(format!("cargo sets no {name}"));
    let web = variable("CARGO_MANIFEST_DIR")?.join("../../web");
    let dist = web.join("dist");
    println!("cargo::rerun-if-changed=build.rs");
    let mut names = Vec::new();
    if dist.is_dir() {
        println!("cargo::rerun-if-changed={}", dist.display());
        collect(&dist, "", &mut names).map_err(|e| format!("{}: {e}", dist.display()))?;
    } else if web.is_dir() {
        // What does not exist yet cannot be watched without building anew every time, but the folder it will
        // be in can.
        println!("cargo::rerun-if-changed={}", web.display());
    }
    names.sort();
    let mut table = String::from("/// Names and contents.\npub(crate) static FILES: &[(&str, &[u8])] = &[\n");
    for name in &names {
        let path = dist.join(name).canonicalize().map_err(|e| format!("{name}: {e}"))?;
        let _ = writeln!(table, "    ({name:?}, include_bytes!({:?})),", path.display().to_string());
    }
    table.push_str("];\n");
    let output = variable("OUT_DIR")?.join("files.rs");
    fs::write(&output, table).map_err(|e| format!("{}: {e}", output.display()))
}

/// Names of all files, below `dist`, with `/` between folders.
fn collect(folder: &Path, prefix: &str, names: &mut Vec<String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let file_name = entry.file_name();
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
        let Some(name) = file_name.to_str().filter(|n| n.chars().all(plain)) else {
            return Err(io::Error::other(format!("{file_name:?} would need an escape in its address")));
        };
        // Neither what a link points at nor what an editor left behind.
        let kind = entry.file_type()?;
        if name.starts_with('.') || !(kind.is_file() || kind.is_dir()) {
            continue;
        }
        let name = format!("{prefix}{name}");
        if kind.is_dir() {
            collect(&entry.path(), &format!("{name}/"), names)?;
        } else {
            names.push(name);
        }
    }
    Ok(())
}
