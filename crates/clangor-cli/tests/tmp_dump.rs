use clangor_core::contact::{ContactSettings, PoseHistory, impact_pulses};
use clangor_pipeline::formats::timeline_file::TimelineReader;
use std::path::Path;
#[test]
#[ignore]
fn dump() {
    let path = std::env::var("TL").unwrap();
    let reader = TimelineReader::open(Path::new(&path)).unwrap();
    let bodies = reader.header().world.bodies.clone();
    let t = reader.read_all().unwrap();
    let poses = PoseHistory::try_new(&bodies, &t.poses).unwrap();
    let rows = t.contacts.clone();
    let (pulses, report) = impact_pulses(&bodies, &rows, &poses, &ContactSettings::default()).unwrap();
    println!("{report:?}");
    if let Ok(ids) = std::env::var("IDS") {
        for id in ids.split(',') {
            let id: u64 = id.parse().unwrap();
            println!("impact {id}");
            let first = rows.iter().find(|r| r.impact_id == id).unwrap();
            for r in rows.iter().filter(|r| r.impact_id == id) {
                println!(
                    "   t+{:.1} us  dist {:.3} mm  jn {:.6} jt {:.6} n {:.3} vn {:.4} depth {:.2} um",
                    1e6 * (r.time - first.time),
                    1e3 * r.point.distance(first.point),
                    r.impulse_n,
                    r.impulse_t.length(),
                    r.normal,
                    -r.velocity.dot(r.normal),
                    1e6 * r.depth
                );
            }
        }
    }
    for p in &pulses {
        let j: f64 = p.points.iter().map(|x| x.1.length()).sum();
        println!(
            "{:.5} {} {:?} v {:.4} J {:.6} m {:.5} tau {:.2} us R {:.5} pts {} {:?}",
            p.time,
            p.impact_id,
            p.pair,
            p.speed,
            j,
            p.effective_mass,
            p.duration * 1e6,
            p.radius,
            p.points.len(),
            p.range
        );
    }
}
