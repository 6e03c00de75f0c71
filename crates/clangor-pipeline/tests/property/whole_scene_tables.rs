//! Tables that list every body of a scene, those that the scene holds or leads too.

use crate::imported_motion::{folder, import};

const SCENE: &str = r#"version = 1
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0.0, 0.5, 0.0]
[[body]]
name = "anvil"
shape = "box:0.1x0.1x0.1"
material = "steel"
position = [5.0, 0.05, 0.0]
motion = "fixed"
[[body]]
name = "door"
shape = "box:0.02x0.4x0.2"
material = "wood"
keyframes = [
  { time = 0.0, position = [2.0, 0.5, 0.0] },
  { time = 1.0, position = [2.5, 0.5, 0.0] },
]
[[plane]]
name = "floor"
material = "granite"
[[listener]]
position = [0.3, 0.4, 0.4]
"#;

const HEAD: &str = "t,body,position_x,position_y,position_z\n";

/// A table in which the ball falls for 0.2 s, and other rows at each time.
fn table(others: &dyn Fn(f64) -> String) -> String {
    let times = (0..20).map(|k| 0.01 * f64::from(k));
    let rows = times.map(|t| format!("{t},ball,0,{},0\n{}", 0.5 - 4.903325 * t * t, others(t)));
    HEAD.to_string() + &rows.collect::<String>()
}

#[test]
fn bodies_where_the_scene_has_them_are_left_out() {
    // The door is where its track begins.
    let door = |t: f64| if t == 0.0 { "0,door,2,0.5,0\n" } else { "" };
    let others = |t: f64| format!("{t},anvil,5,0.05,0\n{t},floor,0,0,0\n{}", door(t));
    let folder = folder(SCENE, &[("a.csv", &table(&others))]);
    let summary = import(folder.path(), &["a.csv"], &[], false).expect("a table of the scene");
    assert_eq!(summary.moved, 1);
    assert_eq!(summary.rows.poses, 20, "{:?}", summary.rows);
}

#[test]
fn bodies_elsewhere_are_told() {
    let cases = [
        ("anvil", "5,0.06,0", "moves anvil, which is fixed in the scene"),
        ("floor", "0,0.01,0", "moves floor, which is fixed in the scene"),
        ("door", "2.1,0.5,0", "moves door, which is moved by keyframes in the scene"),
    ];
    for (body, place, wanted) in cases {
        let folder = folder(SCENE, &[("a.csv", &table(&|t| format!("{t},{body},{place}\n")))]);
        let message = import(folder.path(), &["a.csv"], &[], false).unwrap_err();
        assert!(message.contains(wanted), "{message}");
    }
    // A table of bodies that rest moves nothing.
    let rests: String = HEAD.to_string() + "0,anvil,5,0.05,0\n0.1,anvil,5,0.05,0\n";
    let folder = folder(SCENE, &[("a.csv", &rests)]);
    let message = import(folder.path(), &["a.csv"], &[], false).unwrap_err();
    assert!(message.contains("moves no body of the scene"), "{message}");
}
