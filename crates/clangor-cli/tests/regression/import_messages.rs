//! Messages around `clangor import`: where to begin with a file of an animation program, and numbers
//! with their nouns.

use std::fs;

use crate::program::{clangor, run};

const SCENE: &str = r#"version = 1
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0.0, 0.5, 0.0]
[[plane]]
name = "floor"
material = "granite"
[[listener]]
position = [0.3, 0.4, 0.4]
"#;

/// A ball that falls from 0.5 m and bounces at 0.3161 s with half of its speed.
fn poses() -> String {
    let (gravity, impact) = (9.80665_f64, 0.316_119_f64);
    let height = |t: f64| match t < impact {
        true => 0.5 - 0.5 * gravity * t * t,
        false => 0.01 + 0.5 * gravity * impact * (t - impact) - 0.5 * gravity * (t - impact).powi(2),
    };
    let row = |t: f64| format!("{t},ball,0,{},0\n", height(t));
    let rows: String = (0..120).map(|k| row(f64::from(k) / 240.0)).collect();
    format!("t,body,position_x,position_y,position_z\n{rows}")
}

#[test]
fn a_model_in_the_place_of_a_scene_names_the_import() {
    let folder = tempfile::tempdir().unwrap();
    for (name, command) in [
        ("shot.glb", "clangor import gltf SCENE.toml shot.glb -o RUN.timeline"),
        ("shot.gltf", "clangor import gltf SCENE.toml shot.gltf -o RUN.timeline"),
        ("shot.blend", "clangor import gltf SCENE.toml EXPORTED.glb -o RUN.timeline"),
    ] {
        fs::write(folder.path().join(name), b"glTF\x02\0\0\0\xff\xff\0\0").unwrap();
        for verb in ["render", "check"] {
            let output = run(folder.path(), &[verb, name]);
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(!output.status.success() && message.contains(command), "{verb} {name}: {message}");
        }
    }
}

#[test]
fn a_scene_in_which_nothing_moves_names_the_import() {
    let folder = tempfile::tempdir().unwrap();
    let scene = SCENE.replace("position = [0.0, 0.5, 0.0]", "motion = \"fixed\"");
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let output = run(folder.path(), &["check", "scene.toml"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("nothing moves") && message.contains("`clangor import`"), "{message}");
}

#[test]
fn numbers_have_the_right_nouns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("scene.toml"), SCENE).unwrap();
    fs::write(path.join("a.csv"), poses()).unwrap();
    let said = clangor(path, &["import", "poses", "scene.toml", "a.csv", "-o", "a.timeline"]);
    assert!(said.contains("1 moved body, 121 poses, 1 contact row\n"), "{said}");
    assert!(said.contains("1 impact found in the motion\n"), "{said}");
    let said = clangor(path, &["inspect", "a.timeline"]);
    assert!(said.contains("1 contact row, 1 impact, fastest"), "{said}");
}

#[test]
fn warnings_of_a_contact_list_are_in_its_report() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("scene.toml"), SCENE).unwrap();
    let row = "0.3161,ball,floor,0,0,0,0,1,0,0.05,3.1\n";
    let head = "t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";
    fs::write(path.join("list.csv"), format!("{head}{row}{row}")).unwrap();
    let arguments = ["import", "contacts", "scene.toml", "list.csv", "-o", "a.timeline", "--json"];
    let output = run(path, &arguments);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let warning = report["warnings"][0].as_str().unwrap();
    assert!(warning.starts_with("row 3 repeats row 2: "), "{report}");
    assert!(report["notices"].is_array(), "{report}");
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(printed.contains("warning: row 3 repeats row 2"), "{printed}");
}
