//! Bad input ends with a message that names the place and the remedy, exit code 1, and no output: never a
//! panic.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const GOOD: &str = r#"version = 1

[simulation]
duration = 0.1

[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0.0, 0.05, 0.0]

[[plane]]
name = "floor"
material = "granite"

[[listener]]
name = "ear"
position = [0.3, 0.4, 0.2]
"#;

fn clangor(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_clangor")).args(arguments).current_dir(folder).output().expect("runs")
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Runs a command that must fail with exit code 1, all of `wanted` on standard error and no new file; what it
/// did instead.
fn not_refused(case: &str, folder: &Path, arguments: &[&str], wanted: &[&str]) -> Option<String> {
    let before = names(folder);
    let output = clangor(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let missing = wanted.iter().find(|text| !message.contains(**text));
    let fault = if output.status.code() != Some(1) {
        format!("exit code {:?}", output.status.code())
    } else if message.contains("panicked") {
        "panic".into()
    } else if names(folder) != before {
        "files came or went".into()
    } else {
        format!("no {:?}", missing?)
    };
    Some(format!("== {case}: {fault}\n{message}\n"))
}

fn refuse(case: &str, folder: &Path, arguments: &[&str], wanted: &[&str]) {
    if let Some(fault) = not_refused(case, folder, arguments, wanted) {
        panic!("{fault}");
    }
}

#[test]
fn the_good_scene_is_good() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), GOOD).unwrap();
    let output = clangor(folder.path(), &["render", "scene.toml", "-o", "out.wav"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(folder.path()), ["out.wav", "scene.toml"]);
}

#[test]
fn scenes_are_refused_at_their_place() {
    let shape = "shape = \"sphere:0.01\"";
    let position = "position = [0.0, 0.05, 0.0]";
    let cases: &[(&str, &str, &str, &[&str])] = &[
        ("no version", "version = 1\n", "", &["version", "missing"]),
        ("future version", "version = 1", "version = 9", &["scene.toml:1:", "version 9", "newer program"]),
        ("syntax", "name = \"ball\"", "name = \"ball", &["scene.toml:7:", "TOML"]),
        ("duplicate key", position, "position = [0.0, 0.05, 0.0]\nposition = [0, 1, 0]", &["scene.toml:11:"]),
        (
            "unknown key",
            "material = \"steel\"",
            "material = \"steel\"\ncolour = 3",
            &["scene.toml:10:", "colour"],
        ),
        (
            "misspelt key",
            position,
            "positoin = [0.0, 0.05, 0.0]",
            &["scene.toml:10:", "did you mean `position`?"],
        ),
        ("unknown table", "[simulation]", "[simulatoin]", &["scene.toml:3:", "did you mean `simulation`?"]),
        ("unknown material", "\"steel\"", "\"stele\"", &["scene.toml:9:", "did you mean `steel`?"]),
        ("unknown shape", shape, "shape = \"sfere:0.01\"", &["scene.toml:8:", "sphere"]),
        ("shape without size", shape, "shape = \"box:0.1x0.1\"", &["scene.toml:8:", "box"]),
        ("negative size", shape, "shape = \"sphere:-0.01\"", &["scene.toml:8:"]),
        ("NaN size", shape, "shape = \"sphere:nan\"", &["scene.toml:8:"]),
        ("size in millimetres", shape, "shape = \"sphere:7500\"", &["scene.toml:8:", "metres"]),
        ("microscopic size", shape, "shape = \"sphere:1e-9\"", &["scene.toml:8:", "metres"]),
        ("shape and mesh", shape, "shape = \"sphere:0.01\"\nmesh = \"a.obj\"", &["mesh"]),
        ("no shape", shape, "", &["scene.toml:6:", "`shape` is missing"]),
        ("missing mesh file", shape, "mesh = \"nowhere.obj\"", &["scene.toml:8:", "nowhere.obj"]),
        ("mesh of unknown kind", shape, "mesh = \"scene.toml\"", &["scene.toml:8:", ".obj"]),
        ("text for a number", "duration = 0.1", "duration = \"long\"", &["scene.toml:4:", "duration"]),
        ("zero duration", "duration = 0.1", "duration = 0.0", &["scene.toml:4:", "duration"]),
        ("infinite duration", "duration = 0.1", "duration = inf", &["scene.toml:4:", "finite"]),
        (
            "negative step",
            "duration = 0.1",
            "duration = 0.1\ntime_step = -0.001",
            &["scene.toml:5:", "time_step"],
        ),
        (
            "unknown solver",
            "duration = 0.1",
            "duration = 0.1\nsolver = \"sphere\"",
            &["scene.toml:5:", "spheres"],
        ),
        ("two coordinates", position, "position = [0.0, 0.05]", &["scene.toml:10:", "2 elements"]),
        ("NaN coordinate", position, "position = [0.0, nan, 0.0]", &["scene.toml:10:", "finite"]),
        ("text coordinate", position, "position = [0.0, \"up\", 0.0]", &["scene.toml:10:"]),
        (
            "supersonic body",
            position,
            "position = [0.0, 0.05, 0.0]\nvelocity = [400.0, 0.0, 0.0]",
            &["scene.toml:11:", "sound"],
        ),
        (
            "no name twice",
            "name = \"floor\"",
            "name = \"ball\"",
            &["scene.toml:13:", "already taken", "line 7"],
        ),
        ("listener inside", "[0.3, 0.4, 0.2]", "[0.0, 0.051, 0.0]", &["scene.toml:16:", "inside", "ball"]),
        ("body in the floor", position, "position = [0.0, 0.005, 0.0]", &["ball", "floor", "overlap"]),
        (
            "zero normal",
            "material = \"granite\"",
            "material = \"granite\"\nnormal = [0, 0, 0]",
            &["scene.toml:15:", "direction"],
        ),
        (
            "restitution above 1",
            "version = 1",
            "version = 1\n[material.odd]\nbase = \"steel\"\nrestitution = 1.5",
            &["scene.toml:4:", "restitution"],
        ),
        (
            "incomplete material",
            "version = 1",
            "version = 1\n[material.odd]\ndensity = 1000.0",
            &["youngs_modulus", "missing"],
        ),
        (
            "massless material",
            "version = 1",
            "version = 1\n[material.odd]\nbase = \"steel\"\ndensity = 0.0",
            &["scene.toml:4:", "density"],
        ),
        (
            "incompressible material",
            "version = 1",
            "version = 1\n[material.odd]\nbase = \"steel\"\npoisson_ratio = 0.7",
            &["scene.toml:4:", "poisson_ratio"],
        ),
        (
            "silly sample rate",
            "[[plane]]",
            "[render]\nsample_rate = 100\n[[plane]]",
            &["scene.toml:13:", "sample_rate"],
        ),
        (
            "listener below the floor",
            "[[plane]]",
            "[render]\nfloor = \"rigid\"\nfloor_height = 1.0\n[[plane]]",
            &["below the rigid floor"],
        ),
        (
            "crowd that does not fit",
            position,
            "count = 1000\nplacement = { region = [[0, 0.1, 0], [0.05, 0.15, 0.05]] }",
            &["scene.toml:11:", "of 1000", "region"],
        ),
        (
            "too many bodies",
            position,
            "count = 1000000000\nplacement = { region = [[0, 0.1, 0], [1, 1, 1]] }",
            &["100000"],
        ),
        (
            "keyframes out of order",
            position,
            "keyframes = [{ time = 1.0, position = [0, 1, 0] }, { time = 0.5, position = [0, 2, 0] }]",
            &["scene.toml:10:", "0.5 s follows 1 s"],
        ),
        (
            "hang of nobody",
            "[[plane]]",
            "[[hang]]\nbody = \"bell\"\nanchor = [0, 1, 0]\n[[plane]]",
            &["scene.toml:13:", "bell"],
        ),
        (
            "spring of negative stiffness",
            "[[plane]]",
            "[[spring]]\nbody = \"ball\"\nto = [0, 1, 0]\nstiffness = -5.0\n[[plane]]",
            &["scene.toml:15:", "stiffness"],
        ),
    ];
    let faults: Vec<String> = cases
        .iter()
        .filter_map(|(case, from, to, wanted)| {
            assert!(GOOD.contains(from), "{case}: the good scene has no {from:?}");
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("scene.toml"), GOOD.replacen(from, to, 1)).unwrap();
            not_refused(case, folder.path(), &["render", "scene.toml", "-o", "out.wav"], wanted)
        })
        .collect();
    assert!(faults.is_empty(), "{}", faults.concat());
    assert!(cases.len() >= 40, "{}", cases.len());
}

#[test]
fn all_errors_of_a_scene_are_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let bad = GOOD
        .replace("\"steel\"", "\"stele\"")
        .replace("duration = 0.1", "duration = -1")
        .replace("[0.3, 0.4, 0.2]", "[0.3]");
    fs::write(folder.path().join("scene.toml"), bad).unwrap();
    refuse(
        "three errors",
        folder.path(),
        &["check", "scene.toml"],
        &["scene.toml:4:", "scene.toml:9:", "scene.toml:18:", "3 errors"],
    );
}

#[test]
fn meshes_of_other_kinds_are_no_shapes() {
    let folder = tempfile::tempdir().unwrap();
    let wanted = |name: &'static str| [name, "a mesh file ends in .obj", "export it"];
    let modes = ["modes", "part.3mf", "--material", "steel"];
    refuse("a kind of mesh that is not read", folder.path(), &modes, &wanted("part.3mf"));
    fs::write(folder.path().join("scene.toml"), GOOD.replace("sphere:0.01", "part.fbx")).unwrap();
    refuse("the same as a shape", folder.path(), &["check", "scene.toml"], &wanted("part.fbx"));
    fs::write(folder.path().join("scene.toml"), GOOD.replace("sphere:0.01", "sphera:0.01")).unwrap();
    refuse("a name", folder.path(), &["check", "scene.toml"], &["did you mean `sphere`?"]);
}

const CUBE_CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
const CUBE_FACES: [&str; 6] = ["f 4 3 2 1", "f 5 6 7 8", "f 1 2 6 5", "f 3 4 8 7", "f 2 3 7 6", "f 1 5 8 4"];

#[test]
fn meshes_are_refused_with_a_reason() {
    let closed = format!("{CUBE_CORNERS}{}\n", CUBE_FACES.join("\n"));
    let open = format!("{CUBE_CORNERS}{}\n", CUBE_FACES[..5].join("\n"));
    let flat = closed.replace(" 1\n", " 0\n");
    let apart = format!(
        "{closed}{}{}\n",
        CUBE_CORNERS.replace("v 0", "v 5").replace("v 1", "v 6"),
        CUBE_FACES
            .map(|f| {
                let corners = f[2..].split(' ').map(|c| (c.parse::<u32>().unwrap() + 8).to_string());
                format!("f {}", corners.collect::<Vec<_>>().join(" "))
            })
            .join("\n")
    );
    let cases: &[(&str, &str, &[u8], &[&str])] = &[
        ("open mesh", "open.obj", open.as_bytes(), &["open", "1 hole", "near", "thickness"]),
        ("flat mesh", "flat.obj", flat.as_bytes(), &["flat.obj"]),
        ("two solids", "apart.obj", apart.as_bytes(), &["2 separate shells", "unite them"]),
        ("NaN vertex", "nan.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["nan.obj", "line 1"]),
        (
            "index out of range",
            "index.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
            &["index.obj", "line 4"],
        ),
        ("empty mesh", "empty.obj", b"", &["empty.obj"]),
        (
            "truncated STL",
            "short.stl",
            b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0",
            &["short.stl"],
        ),
        ("truncated PLY", "short.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n", &["short.ply"]),
        ("broken GLB", "broken.glb", b"glTF\x02\0\0\0", &["broken.glb"]),
        ("binary noise", "noise.obj", &[0xFF, 0xFE, 0x00, 0x80, 0x01], &["noise.obj"]),
    ];
    let mut faults = Vec::new();
    for (case, name, bytes, wanted) in cases {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), bytes).unwrap();
        let scene = GOOD.replace("shape = \"sphere:0.01\"", &format!("mesh = \"{name}\"\nscale = 0.02"));
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let mut all = vec!["scene.toml:8:"];
        all.extend_from_slice(wanted);
        faults.extend(not_refused(case, folder.path(), &["render", "scene.toml", "-o", "out.wav"], &all));
        faults.extend(not_refused(case, folder.path(), &["inspect", name], wanted));
    }
    assert!(faults.is_empty(), "{}", faults.concat());
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cube.obj"), closed).unwrap();
    let output = clangor(folder.path(), &["inspect", "cube.obj"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn timelines_are_refused_when_damaged() {
    let make = |folder: &Path| {
        fs::write(folder.join("scene.toml"), GOOD.replace("0.1\n", "0.3\n")).unwrap();
        let output = clangor(folder, &["simulate", "scene.toml", "-o", "run.timeline"]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        folder.join("run.timeline")
    };
    let render = ["render", "run.timeline", "-o", "out.wav"];
    type Damage = fn(&Path);
    let cases: &[(&str, Damage, &[&str])] = &[
        ("truncated contacts", |t| shorten(&t.join("contacts.parquet")), &["contacts.parquet"]),
        ("truncated poses", |t| shorten(&t.join("poses.parquet")), &["poses.parquet"]),
        ("missing contacts", |t| fs::remove_file(t.join("contacts.parquet")).unwrap(), &["contacts.parquet"]),
        ("missing description", |t| fs::remove_file(t.join("timeline.json")).unwrap(), &["timeline.json"]),
        ("truncated description", |t| shorten(&t.join("timeline.json")), &["timeline.json"]),
        ("description of nothing", |t| fs::write(t.join("timeline.json"), "{}").unwrap(), &["timeline.json"]),
    ];
    for (case, damage, wanted) in cases {
        let folder = tempfile::tempdir().unwrap();
        damage(&make(folder.path()));
        refuse(case, folder.path(), &render, wanted);
        refuse(case, folder.path(), &["inspect", "run.timeline"], wanted);
    }
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    let again = ["simulate", "scene.toml", "-o", "run.timeline"];
    refuse("timeline exists", folder.path(), &again, &["run.timeline", "exists", "--force"]);
    refuse("no such timeline", folder.path(), &["render", "no.timeline"], &["no.timeline"]);
}

fn shorten(path: &Path) {
    let bytes = fs::read(path).unwrap();
    fs::write(path, &bytes[..bytes.len() * 2 / 3]).unwrap();
}

#[test]
fn commands_are_refused_before_anything_is_written() {
    let strike = |body, point, listener, output| {
        [
            "strike",
            body,
            "--material",
            "steel",
            "--impulse",
            "0,-0.01,0",
            "--point",
            point,
            "--listener",
            listener,
            "-o",
            output,
        ]
    };
    let folder = tempfile::tempdir().unwrap();
    let refuse =
        |case: &str, arguments: &[&str], wanted: &[&str]| refuse(case, folder.path(), arguments, wanted);
    refuse("no such scene", &["render", "nowhere.toml"], &["nowhere.toml"]);
    refuse("scene is a folder", &["check", "."], &["cannot read"]);
    let good = "sphere:0.01";
    refuse("point off the surface", &strike(good, "0,0.02,0", "1,1,1", "a.wav"), &["off the surface"]);
    refuse("listener inside", &strike(good, "0,0.01,0", "0,0,0", "a.wav"), &["inside"]);
    refuse("unknown ending", &strike(good, "0,0.01,0", "1,1,1", "a.mp3"), &[".wav or .csv"]);
    refuse("no folder", &strike(good, "0,0.01,0", "1,1,1", "no/a.wav"), &["no", "folder"]);
    refuse("unknown shape", &strike("ball", "0,0.01,0", "1,1,1", "a.wav"), &["ball"]);
    let mut unknown = strike(good, "0,0.01,0", "1,1,1", "a.wav");
    unknown[3] = "adamant";
    refuse("unknown material", &unknown, &["adamant", "steel"]);
    refuse("not a WAV file", &["inspect", "nothing.wav"], &["nothing.wav"]);

    fs::write(folder.path().join("scene.toml"), GOOD).unwrap();
    refuse("output is not WAV", &["render", "scene.toml", "-o", "out.ogg"], &["out.ogg", ".wav"]);
    refuse(
        "end before start",
        &["render", "scene.toml", "--from", "0.5", "--to", "0.2"],
        &["0.2 s", "0.5 s"],
    );
    refuse("rate out of range", &["render", "scene.toml", "--sample-rate", "1000"], &["1000 Hz", "384000"]);

    let usage = clangor(folder.path(), &["render", "scene.toml", "--listener", "1,2"]);
    assert_eq!(usage.status.code(), Some(2), "two coordinates are a usage error");
}
