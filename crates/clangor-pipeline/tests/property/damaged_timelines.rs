//! Timelines on disk that are damaged, tampered with or impossible: each is refused by name.

use std::fs;
use std::path::{Path, PathBuf};

use clangor_core::body::BodyId;
use clangor_core::timeline::{ContactKind, ContactRow, Timeline};
use clangor_pipeline::formats::timeline_file::{RowProblem, TimelineError, TimelineWriter};
use glam::DVec3;
use proptest::prelude::*;
use tempfile::TempDir;

use crate::timelines::{broken, example, header, read, recorded, row, write};

#[test]
fn births_that_contradict_themselves_are_refused() {
    let (_folder, path, timeline) = broken();
    let file = path.join("timeline.json");
    let good = fs::read_to_string(&file).unwrap();
    let cases = [
        (
            "\"birth\": 0.30000000000000004",
            "\"birth\": 0.25",
            "fractures.parquet, row 0: pieces 5 to 5 + 3 - 1",
        ),
        ("\"birth\": 0.4", "\"birth\": -0.4", "bodies[8].life.birth is -0.4"),
        ("\"death\": 0.4", "\"death\": 0.35", "fractures.parquet, row 1: pieces 8 to 8 + 2 - 1"),
        ("\"death\": 0.4", "\"death\": 0.2", "bodies[6].life.death is 0.2, before the birth at 0.3"),
        ("\"parent\": 6", "\"parent\": 8", "bodies[8].life.parent is 8, which does not come before it"),
        ("\"parent\": 6", "\"parent\": null", "bodies[8].life has no parent, but comes after"),
        ("\"rows\": 2", "\"rows\": 0", "bodies[5].life has a parent, but fractures.parquet does not know"),
    ];
    for (from, to, expected) in cases {
        assert!(good.contains(from), "{from}");
        fs::write(&file, good.replacen(from, to, 1)).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains(expected), "{from} -> {to}: {message}");
    }
    fs::write(&file, &good).unwrap();
    fs::remove_file(path.join("fractures.parquet")).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::Missing { .. })));

    // What is written is checked as well.
    let (dead, unborn) = (row(0.31), ContactRow { body_a: BodyId(8), ..row(0.31) });
    for (bad, expected) in [
        (dead, "body_a is 0, which lives from 0 s to 0.30000000000000004 s, but the row is of 0.31 s"),
        (unborn, "body_a is 8, which lives from 0.4 s to inf s"),
    ] {
        let wrong = Timeline { contacts: vec![bad], ..timeline.clone() };
        let message = write(&path, &header(), &wrong).unwrap_err().to_string();
        assert!(message.contains("contacts.parquet, row 0: ") && message.contains(expected), "{message}");
    }
    let mut wrong = timeline.clone();
    wrong.fractures[0].first_child = BodyId(6);
    let message = write(&path, &header(), &wrong).unwrap_err().to_string();
    assert!(message.contains("fractures.parquet, row 0: pieces 6 to"), "{message}");
    let mut wrong = timeline;
    wrong.births[1].velocity.x = f64::NAN;
    let message = write(&path, &header(), &wrong).unwrap_err().to_string();
    assert!(message.contains("timeline.json") && message.contains("a piece"), "{message}");
}

#[test]
fn impossible_rows_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.timeline");
    let good = row(1.0);
    let wrong = [
        (ContactRow { body_a: BodyId(5), ..good }, "body_a is 5, but there are 5 bodies"),
        (ContactRow { body_a: BodyId::WORLD, ..good }, "body_a is 4294967295"),
        (ContactRow { normal: DVec3::Y * 1.1, ..good }, "normal has length 1.1"),
        (ContactRow { normal: DVec3::NAN, ..good }, "normal has length NaN"),
        (ContactRow { impulse_n: f64::NAN, ..good }, "impulse_n is NaN"),
        (ContactRow { depth: 1e39, ..good }, "depth is 1"),
        (ContactRow { time: f64::INFINITY, ..good }, "t is inf"),
        (ContactRow { time: 0.999, ..good }, "time 0.999 s comes after 1 s"),
    ];
    for (bad, expected) in wrong {
        let error = write(&path, &header(), &recorded(vec![good, bad], vec![])).unwrap_err();
        let message = error.to_string();
        assert!(message.contains("contacts.parquet, row 1: ") && message.contains(expected), "{message}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    // Within the window of a merged impact order is free, and a link needs no normal.
    let earlier = ContactRow { time: 0.9995, ..good };
    let link = ContactRow { kind: ContactKind::Constraint, normal: DVec3::ZERO, ..good };
    write(&path, &header(), &recorded(vec![good, earlier, link], vec![])).unwrap();
    let mut bad_header = header();
    bad_header.world.gravity.y = f64::NAN;
    assert!(matches!(TimelineWriter::create(&path, &bad_header, true), Err(TimelineError::Json { .. })));
}

/// Lets tables be changed, as one who edits them does.
fn forget_hashes(path: &Path) {
    let file = path.join("timeline.json");
    let text = fs::read_to_string(&file).unwrap();
    let mut description: serde_json::Value = serde_json::from_str(&text).unwrap();
    for table in ["contacts", "poses"] {
        description[table].as_object_mut().unwrap().remove("hash").unwrap();
    }
    fs::write(&file, description.to_string()).unwrap();
}

#[test]
fn changed_tables_are_refused() {
    let (_folder, path, _) = example();
    let file = path.join("contacts.parquet");
    let mut bytes = fs::read(&file).unwrap();
    // A value, not the structure: the decoder alone would not notice.
    bytes[200] ^= 1;
    fs::write(&file, bytes).unwrap();
    let message = read(&path).unwrap_err().to_string();
    assert!(message.contains("contacts.parquet has changed since it was written"), "{message}");
}

#[test]
fn damaged_tables_are_refused_by_name() {
    let (_folder, path, _) = example();
    forget_hashes(&path);
    for table in ["contacts.parquet", "poses.parquet"] {
        let file = path.join(table);
        let good = fs::read(&file).unwrap();
        for length in [0, 3, 100, good.len() / 2, good.len() - 1] {
            fs::write(&file, &good[..length]).unwrap();
            let message = read(&path).unwrap_err().to_string();
            assert!(message.contains(table) && message.contains("again"), "{message}");
        }
        fs::remove_file(&file).unwrap();
        assert!(matches!(read(&path), Err(TimelineError::Missing { .. })));
        fs::write(&file, &good).unwrap();
        read(&path).unwrap();
    }
    // A table of another run, and a table of other columns.
    let (_other_folder, other, _) = example();
    write(&other, &header(), &recorded(vec![row(0.0)], vec![])).unwrap();
    fs::copy(other.join("contacts.parquet"), path.join("contacts.parquet")).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::RowCount { promised: 3000, found: 1, .. })));
    fs::copy(other.join("poses.parquet"), path.join("contacts.parquet")).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::MissingColumn { column: "body_a", .. })));
}

/// The beginning of the hash of a mesh, as the file is indented.
const MESH_HASH: &str = "\"mesh\": {\n          \"hash\": \"";

#[test]
fn tampered_description_is_refused_by_field() {
    let (_folder, path, _) = example();
    let file = path.join("timeline.json");
    let good = fs::read_to_string(&file).unwrap();
    let cases = [
        ("\"version\": 2", "\"version\": 3", "has format version 3; this program reads versions 1 to 2"),
        ("clangor timeline", "other timeline", "format is \"other timeline\""),
        ("\"mass\": 0.1", "\"mass\": -0.1", "bodies[0].mass is -0.1, not a number in kg above 0"),
        ("\"mass\": 0.1", "\"mass\": null", "line 53, column 18: expected a number or \"infinity\""),
        ("\"mass\": 0.1", "\"weight\": 0.1", "unknown field `weight`"),
        ("\"poisson_ratio\": 0.29", "\"poisson_ratio\": 0.6", "material.poisson_ratio is 0.6"),
        ("\"rock 2\"", "\"rock 1\"", "bodies[1].name \"rock 1\" is not unique"),
        ("\"time\": 0.3", "\"time\": -0.3", "bodies[1].motion has no keys, or times that do not increase"),
        ("\"rows\": 3000", "\"rows\": 3001", "contacts.parquet has 3000 rows"),
        ("\"radius\": 0.0075", "\"radius\": 0", "radius is 0, not a number in m from 1e-6"),
        ("\"sound_speed\": 340.1", "\"sound_speed\": 1e999", "number out of range"),
        (
            "\"sound_speed\": 340.1",
            "\"sound_speed\": 1e308",
            "medium.sound_speed is 1e308, not a number in m/s",
        ),
        ("\"sound_speed\": 340.1", "\"sound_speed\": 1e-308", "medium.sound_speed is 1e-308"),
        ("\"hash\": \"", "\"hash\": \"0", "contacts.parquet has changed since it was written"),
        (MESH_HASH, "\"mesh\": {\n          \"hash\": \"../", "is not 32 hexadecimal digits"),
        ("\"body\": 3", "\"body\": 9", "links[0].body is 9, but there are 5 bodies"),
        ("\"body\": 0", "\"body\": 9", "origin.impact_modes.body is 9, but there are 5 bodies"),
    ];
    for (from, to, expected) in cases {
        assert!(good.contains(from), "{from}");
        fs::write(&file, good.replacen(from, to, 1)).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains(expected), "{from} -> {to}: {message}");
    }
    // The first number after a key.
    let edited = |key: &str, number: &str| {
        let after = good.find(&format!("\"{key}\": ")).unwrap();
        let start = after + good[after..].find(|c: char| c.is_ascii_digit()).unwrap();
        let end = start + good[start..].find(|c: char| ",\n ".contains(c)).unwrap();
        format!("{}{number}{}", &good[..start], &good[end..])
    };
    for (key, number, expected) in [
        ("duration", "1e18", "origin.duration is 1e18, not a number in s from 0 to"),
        ("time_step", "1e300", "origin.time_step is 1e300"),
        ("restitution", "1e308", "bodies[0].material.restitution is 1e308, not a number from 0 to 1"),
        ("volume", "1e308", "surface.mesh.volume is 1e308"),
        ("density", "1e308", "density is 1e308"),
        ("inertia", "-1e-7", "bodies[0].inertia is not a symmetric matrix with positive principal moments"),
        ("velocity", "1e300", "bodies[0].velocity is 1e300"),
        ("edge_radius", "1e300", "bodies[0].edge_radius is 1e300"),
        ("stiffness", "1e300", "stiffness is 1e300"),
    ] {
        fs::write(&file, edited(key, number)).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains(expected), "{key} = {number}: {message}");
    }
    fs::write(&file, &good[..good.len() - 2]).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::Json { .. })));
    // Fewer bodies than the rows name.
    let bodies = good.find("\"name\": \"rock 2\"").unwrap();
    let start = good[..bodies].rfind('{').unwrap();
    let links = good.find("\"links\"").unwrap();
    let cut = format!("{} ], {}", good[..start].trim_end().trim_end_matches(','), &good[links..]);
    let cut = cut.replace("\"body\": 3", "\"body\": 0").replace("\"body\": 1", "\"body\": 0");
    fs::write(&file, cut).unwrap();
    let error = read(&path).unwrap_err();
    let expected = RowProblem::Body { column: "body", body: 1, bodies: 1 };
    assert!(matches!(&error, TimelineError::Row { row: 0, problem, .. } if *problem == expected), "{error}");
}

#[test]
fn damaged_mesh_is_refused_by_hash() {
    let (_folder, path, _) = example();
    let mesh = fs::read_dir(path.join("meshes")).unwrap().next().unwrap().unwrap().path();
    let mut bytes = fs::read(&mesh).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&mesh, bytes).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::Changed { .. })));
    fs::remove_file(&mesh).unwrap();
    assert!(matches!(read(&path), Err(TimelineError::Missing { .. })));
}

#[test]
fn places_that_are_no_timeline_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(read(&folder.path().join("none")), Err(TimelineError::Missing { .. })));
    assert!(matches!(read(folder.path()), Err(TimelineError::Missing { .. })));
    let file = folder.path().join("a.timeline");
    fs::write(&file, "no folder").unwrap();
    assert!(read(&file).is_err());
    assert!(TimelineWriter::create(&file, &header(), true).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_bytes_are_rows_or_an_error(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        at_end: bool,
    ) {
        let (path, good) = damage_target();
        let mut bytes = good.clone();
        for (index, byte) in edits {
            // Half of the cases hit the footer, where the structure is.
            let span = if at_end { bytes.len().min(900) } else { bytes.len() };
            let start = bytes.len() - span;
            bytes[start + index.index(span)] = byte;
        }
        fs::write(path.join("contacts.parquet"), bytes).unwrap();
        if let Ok(timeline) = read(path) {
            prop_assert!(timeline.contacts.iter().all(|r| r.time.is_finite() && r.point.is_finite()));
        }
    }
}

/// A timeline to damage, shared by the cases, and the good bytes of its contacts.
fn damage_target() -> &'static (PathBuf, Vec<u8>) {
    static TARGET: std::sync::OnceLock<(TempDir, (PathBuf, Vec<u8>))> = std::sync::OnceLock::new();
    let make = || {
        let (folder, path, _) = example();
        forget_hashes(&path);
        let good = fs::read(path.join("contacts.parquet")).unwrap();
        (folder, (path, good))
    };
    &TARGET.get_or_init(make).1
}
