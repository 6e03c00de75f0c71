//! Tables that list every body of a scene, those that the scene holds or leads too.

use clangor_core::body::Motion;
use clangor_pipeline::formats::timeline_file::TimelineReader;

use crate::imported_motion::{folder, import, scene};

const SCENE: &str = scene!(
    r#"[[body]]
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
[[body]]
name = "mug"
shape = "box:0.08x0.1x0.08"
material = "ceramic"
keyframes = [
  { time = 0.0, position = [3.0, 0.5, 0.0] },
  { time = 0.1, position = [3.0, 0.5, 0.0] },
]
let_go = 0.1
"#
);

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
fn numbers_that_are_none_are_refused_with_row_and_body_before_a_motion_is() {
    let head = "t,body,position_x,position_y,position_z,orientation_x,orientation_y,orientation_z,\
                orientation_w\n0,ball,0,0.5,0,0,0,0,1\n0.1,ball,0,0.45,0,0,0,0,1\n";
    let cases = [
        ("0,anvil,5,NaN,0,0,0,0,1", "body anvil, row 4: position_y is NaN, not a finite number"),
        ("0,anvil,5,0.05,0,0,0,0,0", "body anvil, row 4: the orientation has length 0, not 1"),
        ("0,door,2,0.5,0,0,0,nan,1", "body door, row 4: orientation_z is nan, not a finite number"),
        ("-1,door,2,0.5,0,0,0,0,1", "body door, row 4: t = -1 s"),
        ("0,floor,0,1e300,0,0,0,0,1", "body floor, row 4: a coordinate is"),
    ];
    for (row, wanted) in cases {
        let folder = folder(SCENE, &[("a.csv", &format!("{head}{row}\n"))]);
        let streamed = import(folder.path(), &["a.csv"], &[], false).unwrap_err();
        assert!(streamed.contains(wanted), "{streamed}");
    }
    let list = "t,body_a,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";
    let text = format!("{head}{}\n", cases[1].0);
    let folder = folder(SCENE, &[("a.csv", &text), ("b.csv", list)]);
    let in_memory = import(folder.path(), &["a.csv"], &["b.csv"], false).unwrap_err();
    assert!(in_memory.contains(cases[1].1), "{in_memory}");
}

#[test]
fn a_body_that_a_hand_lets_go_moves_as_recorded_and_hits_the_floor() {
    // Held for 0.1 s and let go: the bottom of the mug, 0.45 m high, is on the floor after 0.303 s more.
    let height = |t: f64| if t < 0.1 { 0.5 } else { 0.5 - 4.903325 * (t - 0.1).powi(2) };
    let landed = 0.1 + (2.0 * 0.45 / 9.80665_f64).sqrt();
    let times = || (0..100).map(|k| 0.005 * f64::from(k));
    let place = |t: f64| if t < landed { height(t) } else { 0.05 };
    let rows = times().map(|t| format!("{t},mug,3,{},0\n", place(t)));
    let table = HEAD.to_string() + &rows.collect::<String>();
    let folder = folder(SCENE, &[("a.csv", &table), ("b.csv", &format!("{HEAD}0,ball,0,0.5,0\n"))]);
    let path = folder.path().join("out.timeline");
    let impacts = |motion: &[&str]| -> Vec<f64> {
        let summary = import(folder.path(), motion, &[], false).expect("a mug that is let go");
        assert_eq!(summary.moved, motion.len());
        let reader = TimelineReader::open(&path).unwrap();
        let (bodies, timeline) = (reader.bodies(), reader.read_all().unwrap());
        let mug = bodies.iter().position(|body| body.name == "mug").unwrap();
        assert_eq!(bodies[mug].motion, Motion::Free);
        let own = timeline.contacts.iter().filter(|row| row.impact_id != 0);
        own.filter(|row| row.body_a.index() == mug).map(|row| row.time).collect()
    };
    // One table is a stream, two are kept in memory.
    for motion in [&["a.csv"] as &[&str], &["a.csv", "b.csv"]] {
        let times = impacts(motion);
        assert!(!times.is_empty() && times.iter().all(|t| (t - landed).abs() < 0.005), "{times:?}, {landed}");
    }
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
