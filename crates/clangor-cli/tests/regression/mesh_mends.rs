//! Mesh files with faults are mended and every mend is said, once for each file, or they are refused with the
//! place of the fault and the remedy.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::shape::Shape;

const SCENE: &str = r#"version = 1

[simulation]
duration = 0.02

[[body]]
name = "first"
mesh = "bad.obj"
material = "steel"
position = [0.0, 1.0, 0.0]

[[body]]
name = "second"
mesh = "bad.obj"
material = "steel"
position = [1.0, 1.0, 0.0]

[[plane]]
material = "granite"

[[listener]]
position = [0.3, 2.4, 0.2]
"#;

fn clangor(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_clangor"));
    command.args(["--cache", "cache"]).args(arguments).current_dir(folder).output().expect("runs")
}

fn cube() -> TriMesh {
    Shape::parse("box:0.1x0.1x0.1@0.01").expect("a shape").mesh()
}

fn obj(mesh: &TriMesh) -> String {
    let vertices = mesh.vertices.iter().map(|v| format!("v {} {} {}\n", v.x, v.y, v.z));
    let faces = mesh.triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect()
}

fn joined(a: &TriMesh, b: &TriMesh) -> TriMesh {
    let start = a.vertices.len() as u32;
    let mut both = a.clone();
    both.vertices.extend(&b.vertices);
    both.triangles.extend(b.triangles.iter().map(|t| t.map(|i| i + start)));
    both
}

fn resized(mesh: &TriMesh, factor: f64, offset: DVec3) -> TriMesh {
    let vertices = mesh.vertices.iter().map(|v| factor * *v + offset).collect();
    TriMesh { vertices, triangles: mesh.triangles.clone() }
}

/// A mesh, and what must be said of it.
fn mended() -> Vec<(&'static str, TriMesh, &'static str)> {
    let good = cube();
    let changed = |change: &dyn Fn(&mut TriMesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        mesh
    };
    let fin = |m: &mut TriMesh| {
        m.vertices.push(DVec3::Y * 0.06);
        let [a, b, _] = m.triangles[300];
        m.triangles.push([a, b, m.vertices.len() as u32 - 1]);
    };
    vec![
        (
            "flipped",
            changed(&|m| (10..17).for_each(|t| m.triangles[t].swap(0, 1))),
            "turned 7 triangles that faced",
        ),
        (
            "inside out",
            changed(&|m| m.triangles.iter_mut().for_each(|t| t.swap(0, 1))),
            "that was inside out",
        ),
        (
            "hole",
            changed(&|m| m.triangles.truncate(m.triangles.len() - 1)),
            "closed 1 hole with borders of up to",
        ),
        (
            "double",
            changed(&|m| m.triangles.extend_from_within(3..5)),
            "left out 2 triangles that lay on others",
        ),
        ("fin", changed(&fin), "left out 1 triangle of sheets that bound nothing"),
        ("crack", changed(&|m| m.vertices.push(m.vertices[5] + 5e-6)), "closed cracks of up to 0.0050 %"),
        (
            "parts",
            joined(&good, &resized(&good, 0.12, DVec3::X * 0.045)),
            "united 2 shells that touch or cross",
        ),
        ("dust", joined(&good, &resized(&good, 0.01, DVec3::X * 0.1)), "left out 1 separate shell"),
    ]
}

#[test]
fn mends_are_said_by_every_command() {
    for (case, mut mesh, wanted) in mended() {
        if case == "crack" {
            let split = mesh.vertices.len() as u32 - 1;
            let used = mesh.triangles.iter_mut().find(|t| t.contains(&5)).expect("a triangle");
            used.iter_mut().filter(|i| **i == 5).for_each(|i| *i = split);
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("bad.obj"), obj(&mesh)).unwrap();
        fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
        let strike = [
            "strike",
            "bad.obj",
            "--material=steel",
            "--quality=draft",
            "--striker=steel:0.01",
            "--point=0,0.05,0",
            "--listener=0,1,0",
            "--output=strike.wav",
        ];
        let commands: [&[&str]; 3] = [&["inspect", "bad.obj"], &["check", "scene.toml"], &strike];
        for arguments in commands {
            // The dearest command once.
            if arguments[0] == "strike" && case != "flipped" {
                continue;
            }
            let output = clangor(folder.path(), arguments);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            println!("{case}, {}: {said}", arguments[0]);
            assert_eq!(output.status.code(), Some(0), "{case}, {arguments:?}: {said}");
            assert_eq!(said.matches("the mesh was mended: ").count(), 1, "{case}, {arguments:?}: {said}");
            assert!(said.contains(wanted) && said.contains("near ["), "{case}, {arguments:?}: {said}");
        }
        let json = clangor(folder.path(), &["inspect", "bad.obj", "--json"]);
        let facts: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
        assert!(facts["warnings"][0].as_str().unwrap().contains(wanted), "{facts}");
        assert!((facts["body"]["volume_m3"].as_f64().unwrap() / 1e-3 - 1.0).abs() < 1e-3, "{case}: {facts}");
    }
}

#[test]
fn what_cannot_be_mended_is_refused_with_place_and_remedy() {
    let good = cube();
    let kept = |keep: &dyn Fn(DVec3) -> bool| {
        let triangles = (0..good.triangles.len()).filter(|t| keep(good.centroid(*t)));
        TriMesh { vertices: good.vertices.clone(), triangles: triangles.map(|t| good.triangles[t]).collect() }
    };
    // The middle of the top, pulled through the bottom.
    let mut spike = good.clone();
    let middle = spike.vertices.iter_mut().find(|v| v.distance(DVec3::Y * 0.05) < 1e-9).expect("a vertex");
    *middle = DVec3::Y * -0.08;
    let mut two_sided = kept(&|x| x.y > 0.049);
    let back: Vec<[u32; 3]> = two_sided.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    two_sided.triangles.extend(back);
    let cases: [(&str, TriMesh, &[&str]); 7] = [
        ("no top", kept(&|x| x.y < 0.049), &["open: 1 hole", "border of 231 %", "near [", "Solidify"]),
        ("sheet", kept(&|x| x.y > 0.049), &["open: 1 hole", "near [", "give a sheet a thickness"]),
        ("two-sided sheet", two_sided, &["open: 1 hole", "near [", "give a sheet a thickness"]),
        (
            "two bodies",
            joined(&good, &resized(&good, 0.5, DVec3::X * 0.2)),
            &["2 separate shells", "0.125 of its volume", "near [0.20000", "unite"],
        ),
        ("body in a body", joined(&good, &resized(&good, 0.5, DVec3::ZERO)), &["near [", "cavity"]),
        (
            "bodies on an edge",
            joined(&good, &resized(&good, 1.0, DVec3::new(0.1, 0.1, 0.0))),
            &["more than two triangles", "near [0.05", "separate"],
        ),
        ("spike", spike, &["crosses itself", "near ["]),
    ];
    for (case, mesh, wanted) in cases {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("bad.obj"), obj(&mesh)).unwrap();
        fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
        for arguments in [["inspect", "bad.obj"], ["check", "scene.toml"]] {
            let output = clangor(folder.path(), &arguments);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            println!("{case}, {}: {said}", arguments[0]);
            assert_eq!(output.status.code(), Some(1), "{case}: {said}");
            let missing = wanted.iter().find(|text| !said.contains(**text));
            assert_eq!(missing, None, "{case}: {said}");
        }
    }
}

#[test]
fn millimetres_are_suspected() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cube.obj"), obj(&resized(&cube(), 1000.0, DVec3::ZERO))).unwrap();
    let said = |arguments: &[&str]| {
        let output = clangor(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let large = said(&["inspect", "cube.obj"]);
    assert!(large.contains("the body is 173 m across") && large.contains("--scale 0.001"), "{large}");
    assert!(!said(&["inspect", "cube.obj", "--scale", "0.001"]).contains("across"));
}
