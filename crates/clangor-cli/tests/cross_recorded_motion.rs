//! Our own motion, exported as glTF and imported with meshes and materials alone: the poses come back, and
//! the impacts are found in the motion.

mod program;
mod sound_file;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use clangor_core::body::{Body, Motion};
use clangor_core::glam::DVec3;
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::timeline_file::TimelineReader;

use program::clangor;
use sound_file::samples;

const LISTENER: &str = "[[listener]]\nname = \"ear\"\nposition = [0.5, 0.8, 0.5]\n";
/// Simulated time \[s\].
const SECONDS: &str = "2";

fn read(folder: &Path, name: &str) -> (Vec<Body>, Timeline) {
    let reader = TimelineReader::open(&folder.join(name)).unwrap();
    (reader.header().world.bodies.clone(), reader.read_all().unwrap())
}

/// Simulates a scene of ours, exports it at a rate and imports it into `planes`.
fn exported_and_imported(folder: &Path, scene: &str, planes: &str, rates: &[&str]) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(format!("{scene}.toml"));
    let scene = scene.to_str().unwrap();
    fs::write(folder.join("planes.toml"), format!("version = 1\n{planes}{LISTENER}")).unwrap();
    clangor(folder, &["simulate", scene, "-o", "own.timeline", "--duration", SECONDS]);
    for rate in rates {
        let (glb, timeline) = (format!("{rate}.glb"), format!("{rate}.timeline"));
        clangor(folder, &["export", "gltf", "own.timeline", "-o", &glb, "--rate", rate]);
        clangor(folder, &["import", "gltf", "planes.toml", &glb, "-o", &timeline]);
    }
}

/// Impulse of one impact on a free body.
struct Hit {
    time: f64,
    impulse: DVec3,
    energy: f64,
}

/// The impacts of each free body, by its name, strongest first.
fn hits((bodies, timeline): &(Vec<Body>, Timeline)) -> BTreeMap<String, Vec<Hit>> {
    let mut sums: BTreeMap<(usize, u64), (f64, DVec3)> = BTreeMap::new();
    for row in timeline.contacts.iter().filter(|row| row.impact_id != 0) {
        for (id, sign) in [(row.body_a, 1.0), (row.body_b, -1.0)] {
            let sum = sums.entry((id.index(), row.impact_id)).or_insert((row.time, DVec3::ZERO));
            sum.0 = sum.0.min(row.time);
            sum.1 += row.impulse() * sign;
        }
    }
    let mut hits: BTreeMap<String, Vec<Hit>> = BTreeMap::new();
    for ((index, _), (time, impulse)) in sums {
        let Some(body) = bodies.get(index).filter(|body| matches!(body.motion, Motion::Free)) else {
            continue;
        };
        let energy = impulse.length_squared() / body.mass;
        hits.entry(body.name.clone()).or_default().push(Hit { time, impulse, energy });
    }
    hits.values_mut().for_each(|hits| hits.sort_by(|a, b| b.energy.total_cmp(&a.energy)));
    hits
}

/// Share of Σ J²/m that has an impact of the same body within `tolerance` \[s\], each used once; and the
/// share of those whose impulse is within 20 %, by energy.
fn found_share(
    own: &BTreeMap<String, Vec<Hit>>,
    found: &BTreeMap<String, Vec<Hit>>,
    tolerance: f64,
) -> [f64; 2] {
    let (mut whole, mut hit, mut near) = (0.0, 0.0, 0.0);
    for (body, hits) in own {
        let others = found.get(body).map(Vec::as_slice).unwrap_or_default();
        let mut used = vec![false; others.len()];
        for one in hits {
            whole += one.energy;
            let distance = |k: usize| (others[k].time - one.time).abs();
            let free = (0..others.len()).filter(|k| !used[*k] && distance(*k) <= tolerance);
            let Some(k) = free.min_by(|a, b| distance(*a).total_cmp(&distance(*b))) else { continue };
            used[k] = true;
            hit += one.energy;
            if others[k].impulse.distance(one.impulse) < 0.2 * one.impulse.length() {
                near += one.energy;
            }
        }
    }
    [hit / whole, near / whole]
}

fn shares(folder: &Path, rate: &str) -> [f64; 2] {
    let frame = 1.0 / rate.parse::<f64>().unwrap();
    let own = hits(&read(folder, "own.timeline"));
    let found = hits(&read(folder, &format!("{rate}.timeline")));
    let shares = found_share(&own, &found, (1.5 * frame).max(0.002));
    println!("{rate} Hz: {:.4} found, {:.4} within 20 %", shares[0], shares[1]);
    shares
}

const GRANITE: &str = "[render]\nfloor = \"rigid\"\n[[plane]]\nname = \"slab\"\nmaterial = \"granite\"\n";

#[test]
fn cross_the_drop_of_a_ball_is_found_and_sounds_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    exported_and_imported(path, "ball-drop", GRANITE, &["24", "120", "1000"]);
    for rate in ["120", "1000"] {
        // Seen: all, all.
        assert!(shares(path, rate)[1] > 0.999, "{rate} Hz");
    }
    // Seen at 24 Hz: all.
    assert!(shares(path, "24")[0] > 0.98);

    // Poses come back exactly at the rate of the timeline, up to 32 bits.
    let ((bodies, own), (others, found)) = (read(path, "own.timeline"), read(path, "1000.timeline"));
    let ball = others.iter().position(|body| body.name == "ball").unwrap();
    assert!((others[ball].mass / bodies[0].mass - 1.0).abs() < 1e-6, "{}", others[ball].mass);
    for row in own.poses.iter().filter(|row| (row.time * 1000.0).fract() == 0.0) {
        let same = found.poses.iter().find(|other| other.time == row.time).expect("the same instants");
        assert!(same.position.distance(row.position) < 1e-6, "{row:?} {same:?}");
    }

    let sound = |name: &str| {
        let wav = format!("{name}.wav");
        let listener = ["--listener", "0.5,0.8,0.5"];
        clangor(path, &[&["render", name, "-o", &wav, "--to", "1"][..], &listener].concat());
        samples(&path.join(wav)).0
    };
    let (own, found) = (sound("own.timeline"), sound("1000.timeline"));
    let level = |samples: &[f32]| 10.0 * samples.iter().map(|p| f64::from(*p).powi(2)).sum::<f64>().log10();
    let difference = level(&found) - level(&own);
    println!("level of the sound: {difference:.3} dB");
    // Bar: 0.5 dB. Seen: 0.000.
    assert!(difference.abs() < 0.05, "{difference} dB");
}

/// Poses and contacts of a simulator are its tables, or the same as text.
#[test]
fn cross_poses_and_contacts_of_a_drop_sound_as_the_scene_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/ball-drop.toml");
    let scene = scene.to_str().unwrap();
    clangor(path, &["simulate", scene, "-o", "own.timeline", "--duration", "1"]);
    clangor(path, &["render", "own.timeline", "-o", "own.wav"]);
    let (_, own) = read(path, "own.timeline");
    let mut poses = String::from("t,body,position_x,position_y,position_z\n");
    for row in &own.poses {
        let DVec3 { x, y, z } = row.position;
        poses += &format!("{},ball,{x},{y},{z}\n", row.time);
    }
    let mut contacts = String::new();
    for row in &own.contacts {
        // Without the second body: the floor is told from the point.
        contacts += &serde_json::json!({
            "t": row.time, "body_a": row.body_a.0, "point": row.point.to_array(),
            "normal": row.normal.to_array(),
            "impulse_n": row.impulse_n, "velocity": row.velocity.to_array(),
        })
        .to_string();
        contacts.push('\n');
    }
    fs::write(path.join("poses.csv"), poses).unwrap();
    fs::write(path.join("contacts.jsonl"), contacts).unwrap();
    let tables = ["own.timeline/poses.parquet", "own.timeline/contacts.parquet"];
    let own = samples(&path.join("own.wav")).0;
    for [poses, contacts] in [["poses.csv", "contacts.jsonl"], tables] {
        let import =
            ["import", "poses", scene, poses, "--contacts", contacts, "-o", "in.timeline", "--force"];
        clangor(path, &import);
        clangor(path, &["render", "in.timeline", "-o", "in.wav"]);
        let found = samples(&path.join("in.wav")).0;
        let level =
            |samples: &[f32]| 10.0 * samples.iter().map(|p| f64::from(*p).powi(2)).sum::<f64>().log10();
        let difference = level(&found) - level(&own);
        println!("{poses}: {difference:.4} dB");
        // Bar: 0.5 dB. Seen: 0.000 and 0.000.
        assert!(difference.abs() < 0.05, "{poses}: {difference} dB");
    }
}

#[test]
fn cross_most_energy_of_tumbling_dice_is_found_at_120_hz() {
    let folder = tempfile::tempdir().unwrap();
    exported_and_imported(folder.path(), "dice", "", &["120", "1000"]);
    // Seen: 0.988 and 0.981; 0.9994 and 0.9991.
    assert!(shares(folder.path(), "120")[0] > 0.98);
    assert!(shares(folder.path(), "1000")[1] > 0.99);
}

/// Eight thin coins rattle: two impacts of a coin within a frame cannot be told apart.
#[test]
fn cross_most_energy_of_rattling_coins_is_found() {
    let folder = tempfile::tempdir().unwrap();
    exported_and_imported(folder.path(), "coins", "", &["120", "1000"]);
    // Seen: 0.970 and 0.939; 0.9926 and 0.985.
    assert!(shares(folder.path(), "120")[0] > 0.95);
    assert!(shares(folder.path(), "1000")[1] > 0.96);
}
