//! Tables of poses that are read as a stream: parts of any length give what a search in one piece gives, and
//! so does a table that is kept in memory because it is not in order.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::boxes;
use crate::imported_motion::{folder, import};
use crate::parquet_columns::write_alike;
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::file_frame::FileAxes;
use clangor_pipeline::interchange::motion_import::{MotionFiles, MotionSummary, import_motion};
use clangor_pipeline::stages::load::{LoadedScene, load_scene};
use parquet::basic::Compression;

const SCENE: &str = r#"version = 1
[[body]]
name = "early"
shape = "sphere:0.01"
material = "steel"
position = [0.0, 0.5, 0.0]
[[body]]
name = "late"
shape = "sphere:0.01"
material = "steel"
position = [0.1, 0.5, 0.0]
[[body]]
name = "sparse"
shape = "box:0.02x0.02x0.02"
material = "steel"
position = [0.2, 0.01, 0.0]
[[plane]]
name = "floor"
material = "granite"
[[listener]]
position = [0.3, 0.4, 0.4]
"#;
const HEAD: &str = "t,body,position_x,position_y,position_z\n";
const RATE: f64 = 240.0;
const G: f64 = 9.80665;

/// Imports one table in parts of a length \[s\].
fn in_parts(loaded: &LoadedScene, poses: PathBuf, part_length: f64, out: &Path) -> (MotionSummary, Timeline) {
    // The recorded boxes are the only ones with z up.
    let z_up = loaded.path == boxes::folder().join("boxes.toml");
    let part_length = Some(part_length);
    let files = MotionFiles {
        poses: vec![poses],
        axes: FileAxes { z_up, ..FileAxes::default() },
        part_length,
        ..MotionFiles::default()
    };
    let summary = import_motion(loaded, &files, out, true).unwrap();
    (summary, TimelineReader::open(out).unwrap().read_all().unwrap())
}

#[test]
fn property_parts_of_any_length_give_the_impacts_of_one_piece() {
    // Thirty boxes that pile up: impacts at all times, and bodies that touch.
    let loaded = boxes::scene();
    let folder = tempfile::tempdir().unwrap();
    let table = boxes::poses(&loaded, 4, folder.path());
    let out = folder.path().join("out.timeline");
    let whole = in_parts(&loaded, table.clone(), 1e6, &out);
    assert!(whole.0.found.as_ref().unwrap().confidence.len() > 300);
    for length in [0.52, 0.61, 0.83, 1.3] {
        let parts = in_parts(&loaded, table.clone(), length, &out);
        assert_eq!(parts.0, whole.0, "parts of {length} s");
        assert!(parts.1 == whole.1, "parts of {length} s");
    }
}

/// Height of a ball that is thrown up from the floor every second.
fn height(time: f64) -> f64 {
    let t = time.rem_euclid(1.0);
    0.01 + (3.0 * t - 0.5 * G * t * t).max(0.0)
}

/// Rows of three bodies: one leaves after 2 s, one comes at 4 s, and one that rests has a row each second.
fn rows() -> Vec<(f64, &'static str, String)> {
    let mut rows = Vec::new();
    for k in 0..(7.0 * RATE) as u32 {
        let t = f64::from(k) / RATE;
        if t < 2.0 {
            rows.push((t, "early", format!("{t},early,0,{},0\n", height(t))));
        }
        if t >= 4.0 {
            rows.push((t, "late", format!("{t},late,0.1,{},0\n", height(t + 0.3))));
        }
        if k.is_multiple_of(240) {
            rows.push((t, "sparse", format!("{t},sparse,0.2,0.01,0\n")));
        }
    }
    rows
}

fn table(rows: &[(f64, &'static str, String)]) -> String {
    rows.iter().fold(HEAD.to_string(), |mut text, (_, _, line)| {
        let _ = write!(text, "{line}");
        text
    })
}

#[test]
fn property_a_table_by_body_gives_the_same_as_one_by_time() {
    let by_time = rows();
    let mut by_body = by_time.clone();
    let order = ["early", "sparse", "late"];
    by_body.sort_by_key(|(_, body, _)| order.iter().position(|name| name == body));
    // Blocks of 0.1 s, body by body, as some programs write.
    let mut in_blocks = by_time.clone();
    in_blocks.sort_by_key(|(t, body, _)| ((t * 10.0) as u32, order.iter().position(|name| name == body)));
    let folder = folder(SCENE, &[("time.csv", &table(&by_time)), ("body.csv", &table(&by_body))]);
    fs::write(folder.path().join("blocks.csv"), table(&in_blocks)).unwrap();
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let out = folder.path().join("out.timeline");
    let run = |name: &str, length: f64| in_parts(&loaded, folder.path().join(name), length, &out);
    // The notices name rows of the file.
    let compared = |(summary, timeline): (MotionSummary, Timeline)| (summary.found, summary.rows, timeline);
    let in_memory = compared(run("body.csv", 1e6));
    let throws = in_memory.0.as_ref().unwrap().confidence.len();
    assert!(throws >= 4, "{throws}");
    for name in ["time.csv", "blocks.csv"] {
        for length in [1e6, 0.1, 3.0] {
            assert!(compared(run(name, length)) == in_memory, "{name} in parts of {length} s");
        }
    }
}

/// Where the late ball is if it slides along x \[m\].
fn drift(t: f64) -> f64 {
    0.1 + 0.02 * t
}

/// Contacts of the three bodies at and beside the frames of impacts, some of them off the surfaces, in two
/// lists.
fn lists() -> [String; 2] {
    let head = "t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";
    let row = |t: f64, body: &str, x: f64, y: f64| format!("{t},{body},floor,{x},{y},0,0,1,0,0.1,3\n");
    let early = [0.0, 0.998, 1.0, 1.003].map(|t| row(t, "early", 0.0, 0.0005)).concat();
    let late = [4.7, 5.697, 5.7021, 6.7].map(|t| row(t, "late", drift(t), 0.0004)).concat();
    let sparse = [0.25, 1.5, 3.9, 5.01].map(|t| row(t, "sparse", 0.2, 0.0)).concat();
    [format!("{head}{late}{early}"), format!("{head}{sparse}")]
}

#[test]
fn property_a_stream_with_contact_lists_gives_the_same_as_a_table_in_memory() {
    let sliding = |(t, body, line): (f64, &'static str, String)| match body {
        "late" => (t, body, format!("{t},late,{},{},0\n", drift(t), height(t + 0.3))),
        _ => (t, body, line),
    };
    let by_time: Vec<_> = rows().into_iter().map(sliding).collect();
    let mut by_body = by_time.clone();
    let order = ["early", "sparse", "late"];
    by_body.sort_by_key(|(_, body, _)| order.iter().position(|name| name == body));
    let [one, two] = lists();
    let files = [("one.csv", one.as_str()), ("two.csv", &two)];
    let folder = folder(SCENE, &files);
    for (name, rows) in [("time.csv", &by_time), ("body.csv", &by_body)] {
        fs::write(folder.path().join(name), table(rows)).unwrap();
    }
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let out = folder.path().join("out.timeline");
    let run = |name: &str, length: f64| {
        let contacts = files.iter().map(|(list, _)| folder.path().join(list)).collect();
        let (poses, part_length) = (vec![folder.path().join(name)], Some(length));
        let files = MotionFiles { poses, contacts, part_length, ..MotionFiles::default() };
        let summary = import_motion(&loaded, &files, &out, true).unwrap();
        (summary, TimelineReader::open(&out).unwrap().read_all().unwrap())
    };
    let (summary, timeline) = run("body.csv", 1e6);
    assert_eq!((summary.found.as_ref(), timeline.contacts.len()), (None, 12));
    assert!(summary.notices.iter().any(|notice| notice.contains("moved onto it")), "{:?}", summary.notices);
    for length in [1e6, 0.1, 1.3, 3.0] {
        let found = run("time.csv", length);
        assert_eq!(found.0, summary, "parts of {length} s");
        assert!(found.1 == timeline, "parts of {length} s");
    }
}

#[test]
fn property_mistakes_late_in_a_long_table_are_told_before_anything_is_written() {
    let mut lines = rows();
    lines.insert(900, (0.0, "late", "5.0,late,0.1,inf,0\n".into()));
    let folder = folder(SCENE, &[("a.csv", &table(&lines))]);
    let message = import(folder.path(), &["a.csv"], &[], false).unwrap_err();
    assert!(message.contains("row 902: position_y is inf"), "{message}");
    assert!(!folder.path().join("out.timeline").exists());
}

#[test]
fn property_a_long_table_that_is_not_in_order_is_refused_with_its_row() {
    let folder = folder(SCENE, &[]);
    let names = ["t", "body", "position_x", "position_y", "position_z"];
    let groups: [(usize, &[f64]); 2] =
        [(1, &[10.0, 0.0, 0.0, 1.0, 0.0]), (20_000_000, &[0.0, 1.0, 0.0, 1.0, 0.0])];
    write_alike(&folder.path().join("long.parquet"), &names, &groups, Compression::UNCOMPRESSED);
    let message = import(folder.path(), &["long.parquet"], &[], false).unwrap_err();
    assert!(message.contains("row 1: t = 0 s comes after t = 10 s"), "{message}");
    assert!(message.contains("sort it by t"), "{message}");
    assert!(!folder.path().join("out.timeline").exists());
}
