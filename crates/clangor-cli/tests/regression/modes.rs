//! `clangor modes`: what it prints, and what it refuses with a reason.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A tetrahedron of 2 cm without one of its faces.
const OPEN: &str = "v 0.01 0.01 0.01\nv 0.01 -0.01 -0.01\nv -0.01 0.01 -0.01\nv -0.01 -0.01 0.01\nf 1 2 3\n\
    f 1 4 2\nf 1 3 4\n";

/// A cuboid about a place, with half its edges; its first vertex has the number `first`.
fn cuboid(at: [f64; 3], half: [f64; 3], first: usize) -> String {
    let corner = |n: usize| (0..3).map(move |k| at[k] + half[k] * if n >> k & 1 == 1 { 1.0 } else { -1.0 });
    let vertex = |n: usize| corner(n).map(|x| format!(" {x}")).collect::<String>();
    let vertices = (0..8).map(|n| format!("v{}\n", vertex(n))).collect::<String>();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let face = |f: [usize; 4]| format!("f{}\n", f.map(|i| format!(" {}", i + first)).concat());
    vertices + &faces.map(face).concat()
}

fn clangor(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_clangor"));
    command.args(arguments).current_dir(folder).env("CLANGOR_CACHE", folder.join("cache"));
    command.output().expect("runs")
}

fn refuse(folder: &Path, arguments: &[&str], wanted: &[&str]) {
    let output = clangor(folder, &[&["modes"], arguments].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
    for text in wanted {
        assert!(message.contains(text), "{arguments:?}: no {text:?} in {message}");
    }
    assert!(!message.contains("panicked") && message.lines().count() == 1, "{message}");
}

#[test]
fn what_cannot_ring_is_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("open.obj"), OPEN).unwrap();
    let refuse = |arguments: &[&str], wanted: &[&str]| refuse(folder.path(), arguments, wanted);
    refuse(&["open.obj", "--material", "steel"], &["open.obj", "open", "near", "thickness"]);
    refuse(&["bowl", "--material", "ceramic", "--poisson-ratio", "0.5"], &["Poisson", "0.5"]);
    refuse(&["bowl", "--material", "ceramic", "--density", "0"], &["density", "0 kg/m³"]);
    refuse(&["bowl", "--material", "ceramic", "--youngs-modulus=-1"], &["Young", "-1 Pa"]);
    refuse(&["sphere:0.0075", "--material", "steel"], &["no audible modes: the first is at", "kHz"]);
    refuse(&["bowl", "--material", "cheese"], &["cheese", "known:", "steel"]);
    refuse(&["bowl", "--material", "steel", "--export", "nowhere"], &["nowhere"]);
    refuse(&["coin", "--material", "steel", "--export", "."], &["section"]);
    refuse(&["rock:1x0.2", "--material", "steel", "--max-nodes", "100"], &["nodes", "100 allowed"]);
}

/// Neither `modes` nor `bake` makes anything of surfaces that bound no solid, or bound two.
#[test]
fn what_cannot_be_filled_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
    let two = cuboid([0.0; 3], [0.01; 3], 1) + &cuboid([0.05, 0.0, 0.0], [0.01; 3], 9);
    write("two.obj", two);
    write("within.obj", cuboid([0.0; 3], [0.01; 3], 1) + &cuboid([0.003; 3], [0.004; 3], 9));
    write("open.obj", OPEN.into());
    let cases: [(&str, &[&str]); 3] = [
        ("two.obj", &["2 separate shells", "give each a body of its own"]),
        ("within.obj", &["lies inside another", "cavity"]),
        ("open.obj", &["open", "near"]),
    ];
    for (file, wanted) in cases {
        refuse(folder.path(), &[file, "--material", "steel", "--export", "."], wanted);
        let bake =
            ["bake", file, "--material", "steel", "--parts", "acceleration,modal", "-o", "model.safetensors"];
        let output = clangor(folder.path(), &bake);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{file}: {message}");
        for text in wanted {
            assert!(message.contains(text), "{file}: no {text:?} in {message}");
        }
        assert!(!message.contains("panicked"), "{message}");
    }
    let left = |ending: &str| {
        let files = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().path());
        files.filter(|p| p.to_string_lossy().ends_with(ending)).count()
    };
    assert_eq!((left("obj"), left("mtx"), left("safetensors")), (3, 0, 0));
}

#[test]
fn modes_of_a_bowl_are_told_in_full() {
    let folder = tempfile::tempdir().unwrap();
    let output = clangor(folder.path(), &["modes", "bowl", "--material", "ceramic", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let numbers = |name: &str| -> Vec<f64> {
        report[name].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect()
    };
    let (frequencies, damping, errors) =
        (numbers("frequencies_hz"), numbers("damping_ratios"), numbers("convergence"));
    assert_eq!((frequencies.len(), damping.len(), errors.len()), (39, 39, 39));
    // The pair of four nodal meridians; 1253.5 Hz on the finest section.
    assert!((frequencies[0] - 1253.5).abs() < 3.0 && frequencies[1] == frequencies[0], "{frequencies:?}");
    assert!(damping.iter().all(|d| *d == 0.001), "{damping:?}");
    assert!(errors.iter().all(|e| *e > 0.0 && *e < 0.01), "{errors:?}");
    assert_eq!(report["complete"], true);
    assert!(report["nodes"].as_u64().unwrap() > 100);
    let table = clangor(folder.path(), &["modes", "bowl", "--material", "ceramic"]);
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(table.lines().count() == 41 && table.contains("39 modes below 20000 Hz"), "{table}");
}

#[test]
fn matrices_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let output = clangor(
        folder.path(),
        &["modes", "box:0.05x0.04x0.03", "--material", "glass", "--max-frequency", "60000", "--export", "."],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for name in ["stiffness.mtx", "mass.mtx"] {
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("%%MatrixMarket matrix coordinate real symmetric"));
        let header: Vec<usize> = lines.next().unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
        assert_eq!((header[0], header[0] % 3, lines.count()), (header[1], 0, header[2]), "{name}");
    }
}
