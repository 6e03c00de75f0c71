//! Baking: what cannot be baked is refused with a place and a remedy, and whatever happens nothing is
//! half-written.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use clangor_core::sound_model::files::model_file::ModelFile;

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
    write("empty.obj", String::new());
    write("points.obj", TETRAHEDRON.replace("v 0.01 0.01 0.01", "v nan 0.01 0.01"));
    let bake = |name: &str, wanted: &[&str]| {
        refuse(folder.path(), &["bake", name, "-o", "out.safetensors"], wanted);
    };
    bake("open.obj", &["open.obj", "the surface is open: 1 hole", "near", "close what should be closed"]);
    bake("fan.obj", &["fan.obj", "more than two triangles", "near"]);
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
fn a_wall_thinner_than_the_triangles_resolve_is_warned_of_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let key = ["bake", "key", "--accuracy", "0.02", "--max-frequency", "3000", "-o", "out.safetensors"];
    let output = clangor(folder.path(), &key);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    for wanted in ["walls of 1.80e-3 m", "thinnest at (", "ask for a finer accuracy"] {
        assert!(message.contains(wanted), "{message}");
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

/// The ball is the cheapest body there is.
const BALL: [&str; 3] = ["bake", "sphere:0.0075", "--no-near-field"];

#[test]
fn a_model_is_baked_once_and_noticed_when_it_was_changed() {
    let folder = tempfile::tempdir().unwrap();
    let bake = |output: &str| {
        let result = clangor(folder.path(), &[&BALL[..], &["--json", "-o", output]].concat());
        assert!(result.status.success(), "{}", String::from_utf8_lossy(&result.stderr));
        let json: serde_json::Value = serde_json::from_slice(&result.stdout).unwrap();
        (json, String::from_utf8_lossy(&result.stderr).into_owned())
    };
    let (first, _) = bake("a.safetensors");
    assert_eq!(first["cached"], false);
    let (second, _) = bake("b.safetensors");
    assert_eq!(second["cached"], true);
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("a.safetensors"), read("b.safetensors"));
    assert!(ModelFile::decode(&read("a.safetensors")).is_ok());

    let cached = folder.path().join("cache").join(&names(&folder.path().join("cache"))[0]);
    let mut bytes = fs::read(&cached).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&cached, &bytes).unwrap();
    let (third, warning) = bake("c.safetensors");
    assert_eq!(third["cached"], false);
    assert!(warning.contains("changed") && warning.contains("baked again"), "{warning}");
    assert_eq!(read("a.safetensors"), read("c.safetensors"));
    assert_eq!(read("a.safetensors"), fs::read(&cached).unwrap());

    let mut bytes = read("a.safetensors");
    bytes[middle] ^= 1;
    fs::write(folder.path().join("tampered.safetensors"), &bytes).unwrap();
    refuse(folder.path(), &["inspect", "tampered.safetensors"], &["tampered.safetensors", "changed"]);
    fs::write(folder.path().join("short.safetensors"), &bytes[..middle]).unwrap();
    refuse(folder.path(), &["inspect", "short.safetensors"], &["short.safetensors", "whole"]);
    let inspected = clangor(folder.path(), &["inspect", "a.safetensors"]);
    assert!(String::from_utf8_lossy(&inspected.stdout).contains("sphere:0.0075"));
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_told_and_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    // A limit on the size of files stops a write half-way as a full disk does, for any user.
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 2; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_clangor")])
        .args(BALL)
        .args(["-o", "out.safetensors"])
        .current_dir(folder.path())
        .env("CLANGOR_CACHE", folder.path().join("cache"))
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("cannot write out.safetensors"), "{message}");
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn a_cache_that_does_not_work_costs_no_model() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cache"), "a file where the folder should be").unwrap();
    let output = clangor(folder.path(), &[&BALL[..], &["-o", "out.safetensors"]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    assert!(message.contains("not kept") && message.contains("--cache"), "{message}");
    assert_eq!(names(folder.path()), ["cache", "out.safetensors"]);
}

#[test]
fn a_killed_bake_leaves_no_model_or_a_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let whole = clangor(folder.path(), &[&BALL[..], &["-o", "out.safetensors"]].concat());
    assert!(whole.status.success());
    let lasting = started.elapsed();
    fs::remove_file(folder.path().join("out.safetensors")).unwrap();
    for round in 1..=8 {
        fs::remove_dir_all(folder.path().join("cache")).unwrap();
        let mut child = command(folder.path(), &[&BALL[..], &["-o", "out.safetensors"]].concat())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(lasting * round / 8);
        child.kill().unwrap();
        child.wait().unwrap();
        for path in fs::read_dir(folder.path())
            .unwrap()
            .chain(fs::read_dir(folder.path().join("cache")).into_iter().flatten())
        {
            let path = path.unwrap().path();
            if path.extension().is_some_and(|e| e == "safetensors") {
                assert!(ModelFile::decode(&fs::read(&path).unwrap()).is_ok(), "{}", path.display());
            }
        }
        fs::create_dir_all(folder.path().join("cache")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_bake_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    // A body that takes long, so that there is time to interrupt.
    let child = command(folder.path(), &["bake", "mug", "-o", "out.safetensors", "--accuracy", "0.001"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
#[cfg(not(feature = "gpu"))]
fn a_program_without_graphics_processors_says_how_to_build_one_with() {
    let folder = tempfile::tempdir().unwrap();
    refuse(
        folder.path(),
        &[
            "bake",
            "die",
            "--method",
            "fdtd",
            "--device",
            "gpu",
            "--max-frequency",
            "4000",
            "-o",
            "die.safetensors",
        ],
        &["graphics processors", "cargo build --release --features gpu"],
    );
}
