//! Bodies that a recording moves into each other, and contacts that a list has twice.

use std::fs;
use std::path::Path;

use clangor_pipeline::interchange::body_files::{ListedMotion, import_contacts};
use clangor_pipeline::stages::load::load_scene;

use crate::imported_motion::{folder, import, scene};

const SCENE: &str = scene!(
    r#"[[body]]
name = "die"
shape = "box:0.02x0.02x0.02"
material = "plastic"
position = [1.0, 0.5, 0.0]
[[body]]
name = "block"
shape = "box:0.02x0.02x0.02"
material = "plastic"
position = [2.0, 0.5, 0.0]
"#
);

/// What is said of bodies that are at rest 1 m high, at these places along x \[m\] from the sixth frame to
/// the last of these, and far apart otherwise.
fn said(bodies: &[(&str, f64)], frames: u32) -> Vec<String> {
    let mut poses = "t,body,position_x,position_y,position_z\n".to_string();
    for k in 0..60 {
        for (place, (name, x)) in bodies.iter().enumerate() {
            let apart = if (6..6 + frames).contains(&k) { 0.0 } else { 0.04 * place as f64 };
            poses += &format!("{},{name},{},1,0\n", f64::from(k) / 60.0, x + apart);
        }
    }
    let folder = folder(SCENE, &[("a.csv", &poses)]);
    let notices = import(folder.path(), &["a.csv"], &[], false).unwrap().notices;
    notices.into_iter().filter(|notice| notice.contains("deep in each other")).collect()
}

#[test]
fn property_bodies_that_stay_in_each_other_are_told_with_time_and_depth() {
    // Balls of 10 mm radius in the same place, and cubes of 20 mm.
    for (pair, depth) in [(["ball", "die"], 20.0), (["die", "block"], 20.0)] {
        let notices = said(&[(pair[0], 0.0), (pair[1], 0.0)], 50);
        let [notice] = &notices[..] else { panic!("{notices:?}") };
        assert!(notice.contains(&format!("{} and {} lie {depth:.1} mm", pair[0], pair[1])), "{notice}");
    }
    // 5 mm of 20.
    let notices = said(&[("die", 0.0), ("block", 0.015)], 50);
    assert!(notices[0].contains("die and block lie 5.0 mm deep"), "{notices:?}");
    let notices = said(&[("die", 0.0), ("block", 0.0), ("ball", 0.0)], 50);
    assert_eq!(notices.len(), 3, "{notices:?}");
}

#[test]
fn property_contacts_and_short_overlaps_are_not_told() {
    for (a, b, gap) in [("die", "block", 0.0195), ("ball", "die", 0.0195), ("die", "block", 0.03)] {
        assert_eq!(said(&[(a, 0.0), (b, gap)], 54), [""; 0], "{a} and {b} at {gap} m");
    }
    assert_eq!(said(&[("die", 0.0), ("block", 0.015)], 2), [""; 0], "two frames");
}

const HEAD: &str = "t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,impulse_t_x,\
                    impulse_t_y,impulse_t_z,speed\n";

fn list_warnings(folder: &Path, text: &str) -> Vec<String> {
    let loaded = load_scene(&folder.join("scene.toml"), &|_| ()).unwrap();
    fs::write(folder.join("list.csv"), format!("{HEAD}{text}")).unwrap();
    let out = folder.join("out.timeline");
    let imported = import_contacts(&loaded, &folder.join("list.csv"), ListedMotion::AtRest, &out, true);
    let warnings = imported.unwrap().warnings;
    warnings.into_iter().filter(|warning| warning.contains("twice as loud")).collect()
}

#[test]
fn property_contacts_that_a_list_has_twice_are_told_with_their_rows() {
    let folder = folder(SCENE, &[]);
    let first = "0.1,ball,die,1,0.5,0,0,1,0,0.01,0.001,0,0,0.5\n";
    let exchanged = "0.1,die,ball,1,0.5,0,0,-1,0,0.01,-0.001,0,0,0.5\n";
    let other = "0.1,ball,die,1,0.5,0.001,0,1,0,0.01,0.001,0,0,0.5\n";
    let later = "0.2,ball,die,1,0.5,0,0,1,0,0.01,0.001,0,0,0.5\n";
    let of = |rows: &[&str]| list_warnings(folder.path(), &rows.concat());
    assert_eq!(of(&[first, other, later]), [""; 0]);
    assert!(of(&[first, other, first])[0].starts_with("row 4 repeats row 2: "), "{:?}", of(&[first, first]));
    assert!(of(&[later, exchanged, first])[0].starts_with("row 4 repeats row 3: "));
    let many = of(&[first, later, first, exchanged, later]);
    assert!(many[0].starts_with("3 rows repeat others, first row 4, which repeats row 2: "), "{many:?}");
}

#[test]
fn property_contacts_that_two_lists_of_a_recording_share_are_told() {
    let poses = "t,body,position_x,position_y,position_z\n0,ball,0,0.01,0\n0.5,ball,0,0.01,0\n";
    let list = format!("{HEAD}0.1,ball,floor,0,0,0,0,1,0,0.01,0,0,0,0.5\n");
    let folder = folder(SCENE, &[("a.csv", poses), ("one.csv", &list), ("two.csv", &list)]);
    let said = |lists: &[&str]| {
        let warnings = import(folder.path(), &["a.csv"], lists, false).unwrap().warnings;
        warnings.into_iter().find(|warning| warning.contains("twice as loud"))
    };
    assert_eq!(said(&["one.csv"]), None);
    let said = said(&["one.csv", "two.csv"]).unwrap();
    assert!(said.contains("two.csv: row 2 repeats row 2 of ") && said.contains("one.csv: time"), "{said}");
}
