//! Stacks of boxes at rest: each pair carries what lies on it.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::imported_motion::{folder, import};
use clangor_core::body::BodyId;
use clangor_core::timeline::ContactKind;
use clangor_pipeline::formats::timeline_file::TimelineReader;

const G: f64 = 9.80665;
const EDGE: f64 = 0.04;
/// Distance of boxes on each other, over their edge: a micrometre between them.
const RISE: f64 = EDGE + 1e-6;

#[test]
fn analytic_stacks_at_rest_carry_what_lies_on_each() {
    for count in [2, 3, 4, 5, 6, 8, 10, 16, 20] {
        let start = std::time::Instant::now();
        let mut scene = String::from("version = 1\n[render]\nrolling = true\n");
        scene += "[[plane]]\nname = \"floor\"\nmaterial = \"granite\"\n";
        scene += "[[listener]]\nposition = [0.3, 0.4, 0.4]\n";
        let mut rows = String::from("t,body,position_x,position_y,position_z,");
        rows += "orientation_x,orientation_y,orientation_z,orientation_w\n";
        for k in 0..count {
            let y = 0.5 * EDGE + f64::from(k) * RISE;
            write!(scene, "[[body]]\nname = \"box{k}\"\nshape = \"box:{EDGE}x{EDGE}x{EDGE}\"\n").unwrap();
            writeln!(scene, "material = \"wood\"\nposition = [0.0, {y}, 0.0]").unwrap();
            for row in 0..24 {
                writeln!(rows, "{},box{k},0,{y},0,0,0,0,1", f64::from(row) / 240.0).unwrap();
            }
        }
        let folder = folder(&scene, &[("poses.csv", &rows)]);
        import(folder.path(), &["poses.csv"], &[], false).unwrap();
        let reader = TimelineReader::open(&folder.path().join("out.timeline")).unwrap();
        let bodies = reader.header().world.bodies.clone();
        let step = reader.header().origin.time_step;
        let place =
            |id: BodyId| bodies[id.index()].name.strip_prefix("box").map(|k| k.parse::<i32>().unwrap());
        let weight = bodies.iter().find(|body| body.name == "box0").unwrap().mass * G * step;
        // By the lower body of each pair, -1 for the floor, and the step.
        let mut carried: BTreeMap<(i32, u64), f64> = BTreeMap::new();
        for row in reader.read_all().unwrap().contacts {
            assert_eq!(row.kind, ContactKind::Contact);
            let [a, b] = [row.body_a, row.body_b].map(|id| place(id).unwrap_or(-1));
            assert_eq!((a - b).abs(), 1, "{a}, {b}");
            *carried.entry((a.min(b), (row.time / step).round() as u64)).or_default() += row.impulse_n;
        }
        let off = carried
            .iter()
            .map(|((k, _), j)| (j / weight - f64::from(count - 1 - k)).abs() / f64::from(count));
        let off = off.fold(0.0, f64::max);
        println!("{count} boxes: {off:.1e} of the weight of all, {:.2?}", start.elapsed());
        assert_eq!(carried.len(), 22 * count as usize, "each pair in each step");
        // Seen: 3e-5.
        assert!(off < 1e-3, "{count} boxes: {off}");
    }
}
