//! The list of the contacts of a drop, without poses, sounds as the drop itself: the bodies fly between their
//! impacts, so that distance and turn are those of the simulation.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use clangor_core::timeline::{ContactRow, Timeline};
use clangor_pipeline::formats::timeline_file::TimelineReader;

use crate::program::{clangor, run};
use crate::sound_file::samples;

/// Largest difference of levels \[dB\]: half of what is heard.
const SAME_LEVEL_DB: f64 = 0.5;
/// Largest distance of poses from those of the simulation over the size of the body.
const SAME_PLACE: f64 = 0.02;

fn scene(body: &str) -> String {
    format!(
        "version = 1\n[simulation]\nduration = 1.0\n[render]\nsample_rate = 48000\n[[body]]\nname = \
        \"dropped\"\n\
         {body}\nmaterial = \"steel\"\n[[plane]]\nname = \"floor\"\nmaterial = \"granite\"\n[[listener]]\n\
         name = \"ear\"\nposition = [0.3, 0.4, 0.4]\n"
    )
}

/// The list as text.
fn csv(rows: &[ContactRow]) -> String {
    let mut text = String::from("t,body_a,body_b,kind");
    for name in ["point", "normal", "impulse_t", "couple", "velocity"] {
        let _ = write!(text, ",{name}_x,{name}_y,{name}_z");
    }
    text += ",impulse_n,impact_id\n";
    for row in rows {
        let _ = write!(text, "{},{},{},{}", row.time, row.body_a.0, row.body_b.0, row.kind as u8);
        for vector in [row.point, row.normal, row.impulse_t, row.couple, row.velocity] {
            let _ = write!(text, ",{},{},{}", vector.x, vector.y, vector.z);
        }
        let _ = writeln!(text, ",{},{}", row.impulse_n, row.impact_id);
    }
    text
}

fn timeline(path: &Path) -> Timeline {
    TimelineReader::open(path).unwrap().read_all().unwrap()
}

/// Level of a sound \[dB\], and that of its difference from another, relative to that other.
fn levels(one: &[f32], other: &[f32]) -> [f64; 2] {
    let energy = |samples: &mut dyn Iterator<Item = f64>| samples.map(|p| p * p).sum::<f64>();
    let whole = energy(&mut other.iter().map(|p| f64::from(*p)));
    let own = energy(&mut one.iter().map(|p| f64::from(*p)));
    let apart = energy(&mut one.iter().zip(other).map(|(a, b)| f64::from(a - b)));
    [10.0 * (own / whole).log10(), 10.0 * (apart / whole).log10()]
}

/// Largest distance of the poses of body 0 at the same times \[m\], of which there are many.
fn farthest(one: &Timeline, other: &Timeline) -> f64 {
    let (mut farthest, mut compared) = (0.0_f64, 0);
    for row in one.poses.iter().filter(|row| row.body.0 == 0) {
        let at = other.poses.partition_point(|pose| pose.time < row.time - 1e-9);
        if let Some(pose) = other.poses.get(at).filter(|pose| (pose.time - row.time).abs() < 1e-9) {
            farthest = farthest.max(pose.position.distance(row.position));
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared} of {} and {}", one.poses.len(), other.poses.len());
    farthest
}

#[test]
fn cross_a_list_of_contacts_sounds_as_the_drop_that_made_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("scene.toml"), scene("shape = \"sphere:0.01\"\nposition = [0.0, 0.51, 0.0]"))
        .unwrap();
    clangor(path, &["simulate", "scene.toml", "-o", "own.timeline"]);
    clangor(path, &["render", "scene.toml", "-o", "own.wav"]);
    let own = timeline(&path.join("own.timeline"));
    fs::write(path.join("list.csv"), csv(&own.contacts)).unwrap();
    fs::copy(path.join("own.timeline/contacts.parquet"), path.join("list.parquet")).unwrap();
    let expected = samples(&path.join("own.wav")).0;
    for list in ["list.csv", "list.parquet"] {
        let output =
            run(path, &["import", "contacts", "scene.toml", list, "-o", "listed.timeline", "--force"]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !message.contains("stays where") && !message.contains("miss the listed"),
            "{list}: {message}"
        );
        clangor(path, &["render", "listed.timeline", "-o", "listed.wav"]);
        let [level, apart] = levels(&samples(&path.join("listed.wav")).0, &expected);
        let distance = farthest(&timeline(&path.join("listed.timeline")), &own);
        println!("{list}: {level:.4} dB, difference {apart:.1} dB, poses within {:.1} µm", distance * 1e6);
        assert!(level.abs() < SAME_LEVEL_DB, "{list}: {level} dB");
        assert!(distance < SAME_PLACE * 0.01, "{list}: {distance} m");
    }
    // The same list between bodies that do not move.
    clangor(path, &["import", "contacts", "scene.toml", "list.csv", "--at-rest", "-o", "rest.timeline"]);
    clangor(path, &["render", "rest.timeline", "-o", "rest.wav"]);
    let [level, _] = levels(&samples(&path.join("rest.wav")).0, &expected);
    println!("at rest: {level:.2} dB");
    assert!(timeline(&path.join("rest.timeline")).poses.is_empty());
    assert!(level < -1.0, "{level} dB");
}

#[test]
fn cross_a_die_tumbles_by_its_list() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let die = "shape = \"die:0.015x0.001\"\nposition = [0.0, 0.3, 0.0]\nvelocity = [0.3, 0.0, 0.1]\n\
               angular_velocity = [3.0, 8.0, 5.0]";
    fs::write(path.join("scene.toml"), scene(die)).unwrap();
    clangor(path, &["simulate", "scene.toml", "-o", "own.timeline"]);
    let own = timeline(&path.join("own.timeline"));
    fs::write(path.join("list.csv"), csv(&own.contacts)).unwrap();
    let output = run(path, &["import", "contacts", "scene.toml", "list.csv", "-o", "listed.timeline"]);
    let listed = timeline(&path.join("listed.timeline"));
    let distance = farthest(&listed, &own);
    println!("poses within {:.2} mm; {}", distance * 1e3, String::from_utf8_lossy(&output.stderr));
    assert!(!listed.poses.is_empty() && distance < 0.5 * 0.015, "{distance} m");
}
