//! Our own motion of bodies on joints, exported as glTF and imported into the scene that has the joints: its
//! impacts have the impulses and the effective masses of the simulation.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use clangor_core::glam::DVec3;
use clangor_core::timeline::ContactRow;
use clangor_pipeline::formats::timeline_file::TimelineReader;

use crate::program::clangor;

/// An impact: its time \[s\], normal impulse [N s] and mean effective mass \[kg\].
struct Hit {
    time: f64,
    impulse: f64,
    mass: f64,
}

fn rows(timeline: &Path) -> Vec<ContactRow> {
    TimelineReader::open(timeline).unwrap().read_all().unwrap().contacts
}

fn hits(timeline: &Path) -> Vec<Hit> {
    let rows = rows(timeline);
    let mut impacts: BTreeMap<u64, Vec<ContactRow>> = BTreeMap::new();
    for row in rows.into_iter().filter(|row| row.impact_id != 0) {
        impacts.entry(row.impact_id).or_default().push(row);
    }
    let hit = |rows: Vec<ContactRow>| {
        let impulse: f64 = rows.iter().map(|row| row.impulse_n).sum();
        let mass = |row: &ContactRow| row.effective_mass.unwrap() * row.impulse_n / impulse;
        Hit { time: rows[0].time, impulse, mass: rows.iter().map(mass).sum() }
    };
    impacts.into_values().map(hit).collect()
}

/// Largest relative differences of the impulses and of the effective masses.
fn differences(scene: &str, duration: &str, rate: &str) -> [f64; 2] {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(format!("{scene}.toml"));
    let path = path.to_str().unwrap();
    clangor(folder, &["simulate", path, "-o", "own.timeline", "--duration", duration]);
    clangor(folder, &["export", "gltf", "own.timeline", "-o", "own.glb", "--rate", rate]);
    clangor(folder, &["import", "gltf", path, "own.glb", "-o", "found.timeline"]);
    let [own, found] = ["own.timeline", "found.timeline"].map(|name| hits(&folder.join(name)));
    let mut worst = [0.0_f64; 2];
    for one in &own {
        let distance = |hit: &&Hit| (hit.time - one.time).abs();
        let same = found.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        let [impulse, mass] = [same.impulse / one.impulse - 1.0, same.mass / one.mass - 1.0];
        println!(
            "{scene}, {rate} Hz, t = {:.4} s: impulse {impulse:+.1e}, effective mass {mass:+.1e}",
            one.time
        );
        assert!((same.time - one.time).abs() < 1e-3, "{} s: {} s", one.time, same.time);
        worst = [worst[0].max(impulse.abs()), worst[1].max(mass.abs())];
    }
    assert!(own.len() > 1);
    worst
}

#[test]
fn cross_a_door_that_falls_shut_has_the_impulses_of_its_simulation() {
    for rate in ["240", "1000"] {
        let [impulse, mass] = differences("door", "1.25", rate);
        // Seen: 4.7e-2 at 240 Hz, 2.1e-2 at 1000 Hz; 4e-8.
        assert!(impulse < 0.06 && mass < 1e-4, "{rate} Hz: {impulse} {mass}");
    }
}

/// A list that leaves the effective masses out has them from the joints of the scene.
#[test]
fn cross_listed_impacts_of_a_door_have_its_effective_masses() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/door.toml");
    let path = path.to_str().unwrap();
    clangor(folder, &["simulate", path, "-o", "own.timeline", "--duration", "1.25"]);
    clangor(folder, &["export", "gltf", "own.timeline", "-o", "own.glb", "--rate", "1000"]);
    let vectors = ["point", "normal", "velocity"].map(|v| format!("{v}_x,{v}_y,{v}_z")).join(",");
    let mut list = format!("t,body_a,body_b,impulse_n,{vectors}\n");
    for row in rows(&folder.join("own.timeline")).iter().filter(|row| row.impact_id != 0) {
        let vectors = [row.point, row.normal, row.velocity];
        let vectors = vectors.map(|DVec3 { x, y, z }| format!("{x:?},{y:?},{z:?}")).join(",");
        writeln!(list, "{:?},door,post,{:?},{vectors}", row.time, row.impulse_n).unwrap();
    }
    fs::write(folder.join("list.csv"), list).unwrap();
    clangor(folder, &["import", "gltf", path, "own.glb", "--contacts", "list.csv", "-o", "found.timeline"]);
    let [own, found] = ["own.timeline", "found.timeline"].map(|name| hits(&folder.join(name)));
    let masses = |hits: &[Hit]| hits.iter().map(|hit| hit.mass).collect::<Vec<f64>>();
    println!("{:?} {:?}", masses(&own), masses(&found));
    // Seen: 4e-8.
    assert!(found.iter().all(|hit| (hit.mass / own[0].mass - 1.0).abs() < 1e-4) && !found.is_empty());
}

#[test]
fn cross_a_bell_and_its_clapper_have_the_impulses_of_their_simulation() {
    let [impulse, mass] = differences("bell", "0.5", "1000");
    // Seen: 8.1e-2; 5.6e-3. The mesh has facets, on two of which the simulated clapper is at once.
    assert!(impulse < 0.12 && mass < 0.01, "{impulse} {mass}");
}
