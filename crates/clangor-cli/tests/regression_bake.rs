//! Baking: what cannot be baked is refused with a place and a remedy, and whatever happens nothing is half-written.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// A closed tetrahedron of 2 cm.
const TETRAHEDRON: &str = "v 0.01 0.01 0.01\nv 0.01 -0.01 -0.01\nv -0.01 0.01 -0.01\nv -0.01 -0.01 0.01\n\
f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_clangor"));
    command.args(arguments).current_dir(folder).env("CLANGOR_CACHE", folder.join("cache"));
    command
}

fn clangor(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("runs")
}

/// Files below a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => names.extend(self::names(&path)),
            false => names.push(path.file_name().unwrap().to_string_lossy().into_owned()),
        }
    }
    names.sort();
    names
}

/// A command that must fail with exit code 1, say all of `wanted`, and write nothing.
fn refuse(folder: &Path, arguments: &[&str], wanted: &[&str]) {
    let before = names(folder);
    let output = clangor(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
    for text in wanted {
        assert!(message.contains(text), "{arguments:?}: no {text:?} in {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
    assert_eq!(names(folder), before, "{arguments:?}");
}

#[test]
fn surfaces_that_bound_no_solid_are_refused_at_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
    write("open.obj", TETRAHEDRON.replace("f 2 4 3\n", ""));
    write(
        "fan.obj",
        format!("{TETRAHEDRON}v 0.03 0.0 0.0\nv 0.03 0.01 0.0\nf 1 2 5\nf 2 1 6\nf 1 5 6\nf 2 6 5\n"),
    );
    write(
        "inverted.obj",
        TETRAHEDRON
            .replace("f 1 2 3", "f 1 3 2")
            .replace("f 1 4 2", "f 1 2 4")
            .replace("f 1 3 4", "f 1 4 3")
            .replace("f 2 4 3", "f 2 3 4"),
    );
    write("empty.obj", String::new());
    write("points.obj", TETRAHEDRON.replace("v 0.01 0.01 0.01", "v nan 0.01 0.01"));
    let bake = |name: &str, wanted: &[&str]| {
        refuse(folder.path(), &["bake", name, "-o", "out.safetensors"], wanted);
    };
    bake("open.obj", &["open.obj", "the surface is open: 3 boundary edges", "near", "close the holes"]);
    bake("fan.obj", &["fan.obj", "more than two triangles", "near"]);
    bake("inverted.obj", &["inverted.obj", "inwards", "flip"]);
    bake("empty.obj", &["empty.obj"]);
    bake("points.obj", &["points.obj"]);
    bake("nowhere.obj", &["nowhere.obj"]);
    bake("sfere:0.01", &["sphere"]);
}

#[test]
fn options_that_make_no_sense_are_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("x"), "").unwrap();
    let bake = |more: &[&str], wanted: &[&str]| {
        let started = Instant::now();
        refuse(folder.path(), &[&["bake", "mug"], more].concat(), wanted);
        assert!(started.elapsed() < Duration::from_secs(20));
    };
    bake(&[], &["-o MODEL.safetensors"]);
    bake(&["-o", "out.wav"], &[".safetensors"]);
    bake(&["-o", "no/out.safetensors"], &["there is no folder"]);
    bake(&["-o", "out.safetensors", "--material", "stele"], &["no material", "steel"]);
    for wrong in [
        &["--accuracy", "0"][..],
        &["--accuracy", "nan"],
        &["--max-frequency", "1"],
        &["--method", "magic"],
        &["--parts", "wheels"],
    ] {
        let arguments = [&["bake", "mug", "-o", "out.safetensors"], wrong].concat();
        assert_eq!(clangor(folder.path(), &arguments).status.code(), Some(2), "{wrong:?}");
    }
}

#[test]
fn files_that_are_no_models_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.safetensors");
    for (content, wanted) in [
        (&b""[..], "not a whole safetensors file"),
        (&b"RIFF....WAVEfmt plus some more bytes"[..], "not a whole safetensors file"),
        (&b"\x02\x00\x00\x00\x00\x00\x00\x00{}"[..], "not written by Clangor"),
    ] {
        fs::write(&path, content).unwrap();
        refuse(folder.path(), &["inspect", "bad.safetensors"], &["bad.safetensors", wanted]);
        refuse(folder.path(), &["plot", "field", "bad.safetensors", "-o", "out.png"], &[wanted]);
        refuse(folder.path(), &["bank", "info", "bad.safetensors"], &[wanted]);
    }
    refuse(folder.path(), &["inspect", "none.safetensors"], &["cannot read", "none.safetensors"]);
    refuse(folder.path(), &["plot", "field", "bad.safetensors", "-o", "out.jpg"], &[".png or .svg"]);
}
