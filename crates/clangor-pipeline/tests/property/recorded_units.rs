//! Recordings in other units than seconds and metres are warned of with the option that mends them; others
//! are not.

use std::fs;
use std::path::Path;

use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::gltf_motion::{GltfChoice, read_gltf_motion};
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::body_files::{ListReading, ListedMotion, import_contacts};
use clangor_pipeline::interchange::file_frame::FileAxes;
use clangor_pipeline::interchange::motion_import::{MotionFiles, MotionSummary, import_motion};
use clangor_pipeline::motion::file_units::FileUnits;
use clangor_pipeline::motion::recording::{Frame, LengthUnit, TimeUnit};
use clangor_pipeline::stages::load::load_scene;
use parquet::basic::Compression;
use serde_json::json;

use crate::imported_motion::{folder, scene};
use crate::motion_input::{Channel, write_gltf};
use crate::parquet_columns::write_alike;

const SCENE: &str = scene!();
const G: f64 = 9.80665;

/// Height of a ball that falls from 0.5 m and bounces with half of its speed \[m\].
fn height(t: f64, gravity: f64) -> f64 {
    let impact = (2.0 * 0.49 / gravity).sqrt();
    match t < impact {
        true => 0.5 - 0.5 * gravity * t * t,
        false => 0.01 + 0.5 * gravity * impact * (t - impact) - 0.5 * gravity * (t - impact).powi(2),
    }
}

/// The rows of that ball for half a second: time, body 0, and place, in these units.
fn rows(rate: f64, gravity: f64, (metre, second): (f64, f64)) -> Vec<[f64; 5]> {
    let row = |k: u32| {
        let t = f64::from(k) / rate;
        [t * second, 0.0, 0.3 * t * metre, height(t, gravity) * metre, 0.0]
    };
    (0..(0.5 * rate) as u32).map(row).collect()
}

const COLUMNS: [&str; 5] = ["t", "body", "position_x", "position_y", "position_z"];

fn csv(rows: &[[f64; 5]]) -> String {
    let line = |[t, body, x, y, z]: &[f64; 5]| format!("{t},{body},{x},{y},{z}\n");
    COLUMNS.join(",") + "\n" + &rows.iter().map(line).collect::<String>()
}

fn import(folder: &Path, files: MotionFiles) -> Result<MotionSummary, String> {
    let loaded = load_scene(&folder.join("scene.toml"), &|_| ()).unwrap();
    import_motion(&loaded, &files, &folder.join("out.timeline"), true).map_err(|error| error.to_string())
}

fn import_table(
    text: &str,
    (unit, time_unit): (LengthUnit, TimeUnit),
) -> Result<(Timeline, Vec<String>), String> {
    let folder = folder(SCENE, &[("a.csv", text)]);
    let poses = vec![folder.path().join("a.csv")];
    let summary = import(
        folder.path(),
        MotionFiles {
            poses,
            axes: FileAxes { unit, time_unit, ..FileAxes::default() },
            ..MotionFiles::default()
        },
    )?;
    Ok((
        TimelineReader::open(&folder.path().join("out.timeline")).unwrap().read_all().unwrap(),
        summary.warnings,
    ))
}

fn warnings(rows: &[[f64; 5]]) -> Vec<String> {
    import_table(&csv(rows), Default::default()).unwrap().1
}

#[test]
fn property_times_that_are_no_seconds_are_told_with_their_option() {
    for rate in [24.0, 25.0, 30.0, 50.0, 60.0, 120.0, 240.0] {
        assert_eq!(warnings(&rows(rate, G, (1.0, 1.0))), [""; 0], "{rate} Hz");
        for (second, wanted) in [(1e3, "--time-scale 0.001".into()), (rate, format!("--time-scale 1/{rate}"))]
        {
            let said = warnings(&rows(rate, G, (1.0, second)));
            let [said] = &said[..] else { panic!("{rate} Hz, {second}: {said:?}") };
            assert!(said.ends_with(&wanted) && said.contains("ball") && said.contains("a.csv"), "{said}");
            assert!(!said.contains("--scale"), "{said}");
        }
    }
}

#[test]
fn property_the_option_gives_the_motion_in_seconds() {
    let (expected, _) = import_table(&csv(&rows(240.0, G, (1.0, 1.0))), Default::default()).unwrap();
    let unit = (LengthUnit::default(), TimeUnit { seconds: 1e-3 });
    let (read, warnings) = import_table(&csv(&rows(240.0, G, (1.0, 1e3))), unit).unwrap();
    assert_eq!(warnings, [""; 0]);
    assert_eq!((read.contacts.len(), read.poses.len()), (expected.contacts.len(), expected.poses.len()));
    // Seen: 0 and 2e-17 s.
    for (a, b) in read.contacts.iter().zip(&expected.contacts) {
        assert!((a.time - b.time).abs() < 1e-12 && (a.impulse_n / b.impulse_n - 1.0).abs() < 1e-6);
    }
    // An option that is wrong is refused or warned of.
    let refused = import_table(&csv(&rows(240.0, G, (1.0, 1.0))), unit).unwrap_err();
    assert!(refused.ends_with("leave out --time-scale"), "{refused}");
    let unit = (LengthUnit { metres: 0.01 }, TimeUnit::default());
    let (_, warnings) = import_table(&csv(&rows(240.0, G, (1.0, 1.0))), unit).unwrap();
    assert!(warnings[0].ends_with("leave out --scale"), "{warnings:?}");
}

#[test]
fn property_lengths_that_are_no_metres_are_told_with_their_option() {
    for rate in [60.0, 240.0, 1000.0] {
        for (metre, wanted) in [(100.0, "--scale 0.01"), (1.0 / 0.0254, "--scale 0.0254")] {
            let said = warnings(&rows(rate, G, (metre, 1.0)));
            assert!(said[0].ends_with(wanted), "{said:?}");
        }
        let refused = import_table(&csv(&rows(rate, G, (1e3, 1.0))), Default::default()).unwrap_err();
        assert!(refused.ends_with("--scale 0.001"), "{refused}");
    }
}

#[test]
fn property_other_gravity_and_slow_motion_are_told_and_rest_and_eased_keys_are_not() {
    let said = warnings(&rows(240.0, 1.62, (1.0, 1.0)));
    assert!(said[0].contains("1.62 m/s²") && said[0].contains("0.165 times"), "{said:?}");
    assert!(warnings(&rows(240.0, G, (1.0, 4.0)))[0].contains("slow motion"));
    let moved = |height: &dyn Fn(f64) -> f64| -> Vec<String> {
        let rows = |rate: f64| {
            let row = |k: u32| [f64::from(k) / rate, 0.0, 0.0, height(f64::from(k) / rate), 0.0];
            (0..(2.0 * rate) as u32).map(row).collect::<Vec<_>>()
        };
        [24.0, 60.0, 240.0, 1000.0].into_iter().flat_map(|rate| warnings(&rows(rate))).collect()
    };
    assert_eq!(moved(&|_| 0.01), [""; 0], "rest");
    assert_eq!(moved(&|t| 1.0 - 0.4 * t), [""; 0], "even motion");
    // Cubic ease from 1 m to 0.1 m in two seconds, and a swing.
    assert_eq!(moved(&|t| 1.0 - 0.9 * (0.5 * t).powi(2) * (3.0 - t)), [""; 0], "eased keys");
    assert_eq!(moved(&|t| 0.5 + 0.2 * (3.0 * t).cos()), [""; 0], "swing");
    // A spring of 2 Hz and 2 cm, and a quadratic ease of half of gravity.
    assert_eq!(moved(&|t| 0.5 + 0.02 * (12.566 * t).cos()), [""; 0], "spring");
    assert_eq!(moved(&|t| 12.0 - 2.2 * t * t), [""; 0], "quadratic ease");
}

#[test]
fn property_tables_of_parquet_and_gltf_files_are_held_against_gravity_too() {
    let folder = folder(SCENE, &[]);
    let path = folder.path();
    let rows = rows(240.0, G, (1.0, 1e3));
    let groups: Vec<(usize, &[f64])> = rows.iter().map(|row| (1, row.as_slice())).collect();
    write_alike(&path.join("a.parquet"), &COLUMNS, &groups, Compression::UNCOMPRESSED);
    let poses = vec![path.join("a.parquet")];
    let said = import(path, MotionFiles { poses, ..MotionFiles::default() }).unwrap().warnings;
    assert!(said[0].contains("a.parquet") && said[0].ends_with("--time-scale 0.001"), "{said:?}");
    let keys: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let values = rows.iter().flat_map(|row| [0.0, row[3] as f32 + 1.0, 0.0]).collect();
    let curve = Channel { path: "translation", interpolation: "LINEAR", keys, values };
    write_gltf(path, &json!({}), &[curve]);
    let gltf = || vec![path.join("a.gltf")];
    let said = import(path, MotionFiles { gltf: gltf(), ..MotionFiles::default() }).unwrap().warnings;
    assert!(said[0].contains("a.gltf") && said[0].contains("stone"), "{said:?}");
    assert!(said[0].ends_with("--time-scale 0.001"), "{said:?}");
    let axes = FileAxes { time_unit: TimeUnit { seconds: 1e-3 }, ..FileAxes::default() };
    let read = import(path, MotionFiles { gltf: gltf(), axes, ..MotionFiles::default() }).unwrap();
    assert_eq!(read.warnings, [""; 0]);
}

#[test]
fn property_a_list_without_a_recording_has_axes_and_units_too() {
    let folder = folder(SCENE, &[]);
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let head = "t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";
    let read = |row: &str, axes: FileAxes| {
        let (list, out) = (folder.path().join("list.csv"), folder.path().join("out.timeline"));
        fs::write(&list, format!("{head}{row}\n")).unwrap();
        let reading = ListReading { motion: ListedMotion::Flights, axes };
        import_contacts(&loaded, &list, reading, &out, true).unwrap();
        TimelineReader::open(&out).unwrap().read_all().unwrap()
    };
    let ours = read("0.3161,ball,floor,0,0,0,0,1,0,0.01,3.1", FileAxes::default());
    let axes =
        FileAxes { z_up: true, unit: LengthUnit { metres: 1e-3 }, time_unit: TimeUnit { seconds: 1e-3 } };
    let theirs = read("316.1,ball,floor,0,0,0,0,0,1,0.01,3100", axes);
    let ([a], [b]) = (&ours.contacts[..], &theirs.contacts[..]) else { panic!("{theirs:?}") };
    let off = [
        (a.time - b.time).abs(),
        a.normal.distance(b.normal),
        a.velocity.distance(b.velocity),
        a.impulse().distance(b.impulse()),
    ];
    // Seen: at most 7e-16.
    assert!(off.iter().all(|off| *off < 1e-14), "{off:?}");
    println!("{off:?}");
    assert_eq!(ours.poses.len(), theirs.poses.len());
}

#[test]
fn property_lists_that_last_far_longer_than_their_scene_are_told() {
    let timed = SCENE.replacen('\n', "\n[simulation]\nduration = 3.0\n", 1);
    let folder = folder(SCENE, &[("timed.toml", &timed)]);
    let said_of = |scene: &str, times: &[f64]| {
        let loaded = load_scene(&folder.path().join(scene), &|_| ()).unwrap();
        let row = |t: &f64| format!("{t},ball,floor,0,0,0,0,1,0,0.01,0.5\n");
        let head = "t,body_a,body_b,point_x,point_y,point_z,normal_x,normal_y,normal_z,impulse_n,speed\n";
        let (list, out) = (folder.path().join("list.csv"), folder.path().join("out.timeline"));
        fs::write(&list, head.to_string() + &times.iter().map(row).collect::<String>()).unwrap();
        let warnings = import_contacts(&loaded, &list, ListedMotion::AtRest, &out, true).unwrap().warnings;
        let wanted = format!("the scene lasts {} s", loaded.scene.simulation.duration);
        warnings.into_iter().find(|warning| warning.contains(&wanted))
    };
    let said = |times: &[f64]| said_of("scene.toml", times);
    assert_eq!(said(&[0.3, 0.9, 1.7]), None);
    assert_eq!(said(&[0.5, 20.5, 60.0]), None, "a long list of a scene without a duration");
    assert!(said(&[316.0, 900.5, 1700.25]).unwrap().contains("t = 1700.25 s (row 4)"));
    // Whole times may be seconds, unless the scene says how long it lasts.
    assert_eq!(said(&[7.0, 12.0, 19.0, 40.0]), None);
    assert!(said(&[7.0, 12.0, 19.0, 240.0]).unwrap().contains("all times are whole"));
    assert!(said_of("timed.toml", &[7.0, 12.0, 19.0, 40.0]).unwrap().contains("all times are whole"));
    assert_eq!(said_of("timed.toml", &[7.0, 12.0, 19.5, 40.0]), None);
}

#[test]
fn property_a_unit_of_time_counts_before_limits_and_between_the_keys_of_smooth_curves() {
    // Keys from 0 to 8 s, in milliseconds and numbers of frames; tangents are per unit of the file.
    let curve = |seconds: f64| {
        let keys: Vec<f64> = (0..9).map(|k| f64::from(k) / seconds).collect();
        let key = |k: i32| {
            let tangent = (0.5 * seconds) as f32;
            let height = 0.01 * (k % 3) as f32;
            [[0.0, tangent, 0.0], [0.0, height, 0.0], [0.0, -tangent, 0.0]].concat()
        };
        let values = (0..9).flat_map(key).collect();
        Channel { path: "translation", interpolation: "CUBICSPLINE", keys, values }
    };
    let frames = |seconds: f64| {
        let folder = tempfile::tempdir().unwrap();
        write_gltf(folder.path(), &json!({}), &[curve(seconds)]);
        let units = FileUnits { time: TimeUnit { seconds }, ..FileUnits::default() };
        let mut motion =
            read_gltf_motion(&folder.path().join("a.gltf"), &GltfChoice { units, ..GltfChoice::default() })
                .unwrap();
        assert!(motion.faults.is_empty(), "{:?}", motion.faults);
        assert_eq!(motion.first_key.unwrap().spacing, 1.0);
        motion.nodes.remove(0).frames
    };
    let expected = frames(1.0);
    assert_eq!(expected.len(), 8 * 240 + 1);
    for seconds in [1e-3, 1.0 / 24.0] {
        let found = frames(seconds);
        assert_eq!(found.len(), expected.len(), "{seconds}");
        let differ =
            |(a, b): (&Frame, &Frame)| (a.time - b.time).abs().max(a.pose.position.distance(b.pose.position));
        let largest = found.iter().zip(&expected).map(differ).fold(0.0, f64::max);
        println!("unit of {seconds} s: times and places differ by {largest:.1e}");
        // Tangents have 24 bits.
        assert!(largest < 1e-7, "{seconds}: {largest}");
    }
}
