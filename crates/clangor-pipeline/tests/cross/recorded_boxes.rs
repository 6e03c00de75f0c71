//! Thirty boxes thrown onto a floor by PyBullet (`recorded_boxes`): impacts found in their poses alone,
//! against the contact log of the simulator.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::motion_import::{MotionFiles, import_motion};
use clangor_pipeline::stages::load::{LoadedScene, load_scene};
use glam::DVec3;

/// Impulses of one body within this time are one \[s\].
const WINDOW: f64 = 0.003;

/// Impulse on a body, and when it began and ended.
#[derive(Clone, Copy)]
struct Hit {
    first: f64,
    last: f64,
    impulse: DVec3,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recorded_boxes")
}

/// The log, whose z is up.
fn log() -> Vec<(usize, Hit)> {
    let text = fs::read_to_string(folder().join("impacts.csv")).unwrap();
    let row = |line: &str| {
        let values: Vec<f64> = line.split(',').map(|value| value.parse().unwrap()).collect();
        let impulse = DVec3::new(values[3], values[5], -values[4]);
        (values[0] as usize, Hit { first: values[1], last: values[2], impulse })
    };
    text.lines().skip(1).map(row).collect()
}

/// Impulses of the impacts of each body, near ones summed as in the log.
fn found(timeline: &Timeline) -> Vec<(usize, Hit)> {
    let mut hits: BTreeMap<usize, Vec<Hit>> = BTreeMap::new();
    for row in timeline.contacts.iter().filter(|row| row.impact_id != 0) {
        for (id, sign) in [(row.body_a, 1.0), (row.body_b, -1.0)] {
            let impulse = row.impulse() * sign;
            let hits = hits.entry(id.index()).or_default();
            match hits.last_mut().filter(|hit| row.time - hit.last <= WINDOW) {
                Some(hit) => *hit = Hit { last: row.time, impulse: hit.impulse + impulse, ..*hit },
                None => hits.push(Hit { first: row.time, last: row.time, impulse }),
            }
        }
    }
    hits.into_iter().flat_map(|(body, hits)| hits.into_iter().map(move |hit| (body, hit))).collect()
}

struct Score {
    recall: f64,
    energy: f64,
    precision: f64,
    /// Share of the impulses that are found within 20 %.
    near: f64,
}

fn score(loaded: &LoadedScene, poses: PathBuf, tolerance: f64) -> Score {
    let files = MotionFiles { poses: vec![poses], z_up: true, ..MotionFiles::default() };
    let out = tempfile::tempdir().unwrap();
    let path = out.path().join("boxes.timeline");
    import_motion(loaded, &files, &path, false).unwrap();
    let timeline = TimelineReader::open(&path).unwrap().read_all().unwrap();
    let boxes = loaded.scene.bodies.len();
    let found: Vec<(usize, Hit)> = found(&timeline).into_iter().filter(|(body, _)| *body < boxes).collect();
    let mass = |body: usize| loaded.world.bodies[body].mass;
    let energy = |(body, hit): &(usize, Hit)| hit.impulse.length_squared() / mass(*body);
    let mut log = log();
    log.sort_by(|a, b| energy(b).total_cmp(&energy(a)));
    let mut used = vec![false; found.len()];
    let (mut hits, mut near, mut whole, mut share) = (0, 0, 0.0, 0.0);
    for one @ (body, hit) in &log {
        whole += energy(one);
        let is_near =
            |other: &Hit| other.first >= hit.first - tolerance && other.first <= hit.last + tolerance;
        let free = (0..found.len()).filter(|k| !used[*k] && found[*k].0 == *body && is_near(&found[*k].1));
        let distance = |k: usize| (found[k].1.first - hit.first).abs();
        let Some(k) = free.min_by(|a, b| distance(*a).total_cmp(&distance(*b))) else { continue };
        used[k] = true;
        hits += 1;
        share += energy(one);
        near += usize::from(found[k].1.impulse.distance(hit.impulse) < 0.2 * hit.impulse.length());
    }
    let count = |n: usize, of: usize| n as f64 / of as f64;
    Score {
        recall: count(hits, log.len()),
        energy: share / whole,
        precision: count(hits, found.len()),
        near: count(near, hits),
    }
}

#[test]
fn cross_impacts_of_thirty_boxes_are_found_in_their_poses() {
    let loaded = load_scene(&folder().join("boxes.toml"), &|_| ()).unwrap();
    let Score { recall, energy, precision, near } = score(&loaded, folder().join("poses.parquet"), 0.006);
    println!(
        "250 Hz: recall {recall:.3}, energy {energy:.4}, precision {precision:.3}, within 20 % {near:.2}"
    );
    // Seen: 0.927, 0.9913, 0.863, 0.50.
    assert!(energy > 0.99, "{energy}");
    assert!(recall > 0.91 && precision > 0.84, "{recall} {precision}");
    assert!(near > 0.45, "{near}");
}
