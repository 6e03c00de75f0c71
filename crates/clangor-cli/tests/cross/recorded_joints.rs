//! Our own motion of bodies on joints, exported as glTF and imported into the scene that has the joints: its
//! impacts have the impulses and the effective masses of the simulation.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use clangor_core::glam::DVec3;
use clangor_core::timeline::ContactRow;
use clangor_pipeline::formats::timeline_file::TimelineReader;

use tempfile::TempDir;

use crate::shared_models::clangor;

/// An impact: its time \[s\], normal impulse [N s] and mean effective mass \[kg\].
struct Hit {
    time: f64,
    impulse: f64,
    mass: f64,
}

fn rows(timeline: &Path) -> Vec<ContactRow> {
    TimelineReader::open(timeline).unwrap().read_all().unwrap().contacts
}

fn hits(rows: Vec<ContactRow>) -> Vec<Hit> {
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

/// A scene of ours and its simulation, `own.timeline` in a folder.
struct Simulated {
    folder: TempDir,
    scene: String,
}

impl Simulated {
    fn new(scene: &str, duration: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(format!("{scene}.toml"));
        let scene = path.to_str().unwrap().to_string();
        clangor(folder.path(), &["simulate", &scene, "-o", "own.timeline", "--duration", duration]);
        Simulated { folder, scene }
    }

    fn own(&self) -> Vec<ContactRow> {
        rows(&self.folder.path().join("own.timeline"))
    }

    /// The impacts of its motion at a rate, with these options of the import.
    fn imported(&self, rate: &str, options: &[&str]) -> Vec<Hit> {
        let folder = self.folder.path();
        clangor(folder, &["export", "gltf", "own.timeline", "-o", "own.glb", "--rate", rate]);
        let import = ["import", "gltf", &self.scene, "own.glb", "-o", "found.timeline", "--force"];
        clangor(folder, &[&import, options].concat());
        hits(rows(&folder.join("found.timeline")))
    }

    /// Largest relative differences of impulses and of effective masses from those of the simulation.
    fn differences(&self, found: &[Hit]) -> [f64; 2] {
        let own = hits(self.own());
        assert!(own.len() > 1);
        let mut worst = [0.0_f64; 2];
        for one in own {
            let distance = |hit: &&Hit| (hit.time - one.time).abs();
            let same = found.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            let [impulse, mass] = [same.impulse / one.impulse - 1.0, same.mass / one.mass - 1.0];
            println!("t = {:.4} s: impulse {impulse:+.1e}, effective mass {mass:+.1e}", one.time);
            assert!((same.time - one.time).abs() < 1e-3, "{} s: {} s", one.time, same.time);
            worst = [worst[0].max(impulse.abs()), worst[1].max(mass.abs())];
        }
        worst
    }
}

#[test]
fn cross_a_door_that_falls_shut_has_the_impulses_of_its_simulation() {
    let door = Simulated::new("door", "1.25");
    for rate in ["240", "1000"] {
        let [impulse, mass] = door.differences(&door.imported(rate, &[]));
        // Seen: 4.7e-2 and 3.6e-6 at 240 Hz, 2.1e-2 and 6.5e-8 at 1000 Hz.
        assert!(impulse < 0.06 && mass < 1e-4, "{rate} Hz: {impulse} {mass}");
    }
    // A list that leaves the effective masses out has them from the joints of the scene.
    let vectors = ["point", "normal", "velocity"].map(|v| format!("{v}_x,{v}_y,{v}_z")).join(",");
    let mut list = format!("t,body_a,body_b,impulse_n,{vectors}\n");
    for row in door.own().iter().filter(|row| row.impact_id != 0) {
        let vectors = [row.point, row.normal, row.velocity];
        let vectors = vectors.map(|DVec3 { x, y, z }| format!("{x:?},{y:?},{z:?}")).join(",");
        writeln!(list, "{:?},door,post,{:?},{vectors}", row.time, row.impulse_n).unwrap();
    }
    fs::write(door.folder.path().join("list.csv"), list).unwrap();
    let listed = door.imported("1000", &["--contacts", "list.csv"]);
    let mass = hits(door.own())[0].mass;
    // Seen: no difference in 32 bits.
    assert!(listed.iter().all(|hit| (hit.mass / mass - 1.0).abs() < 1e-4) && !listed.is_empty());
}

#[test]
fn cross_a_bell_and_its_clapper_have_the_impulses_of_their_simulation() {
    let bell = Simulated::new("bell", "0.5");
    let [impulse, mass] = bell.differences(&bell.imported("1000", &[]));
    // Seen: 8.1e-2; 5.6e-3. The mesh has facets, on two of which the simulated clapper is at once.
    assert!(impulse < 0.12 && mass < 0.01, "{impulse} {mass}");
}
