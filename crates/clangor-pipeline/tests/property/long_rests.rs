//! Bodies at rest take no memory, however long the sound is.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;

use clangor_core::body::BodyId;
use clangor_core::contact::PoseHistory;
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::stages::load::{LoadedScene, scene_from_text};
use clangor_pipeline::stages::render::read_impacts;
use clangor_pipeline::stages::simulate::{simulate_and_keep, simulate_impacts};

/// Three dice that fall onto a floor; the third hits the first at rest after 0.8 s.
fn scene(duration: f64) -> LoadedScene {
    let text = format!(
        r#"
version = 1

[simulation]
duration = {duration}

[[plane]]
material = "granite"

[[body]]
name = "die"
shape = "die"
material = "plastic"
positions = [[0.0, 0.05, 0.0], [0.2, 0.1, 0.0], [0.0, 3.0, 0.002]]

[[listener]]
name = "ear"
position = [0.5, 0.5, 0.5]
"#
    );
    scene_from_text(Path::new("dice.toml"), text, &|_| ()).unwrap()
}

#[test]
fn property_rests_take_no_memory_and_lose_no_pose() {
    let everything: BTreeSet<BodyId> = (0..3).map(BodyId).collect();
    let go_on = &mut |_: f64| ControlFlow::Continue(());
    let mut kept =
        |duration: f64| simulate_impacts(&scene(duration), &everything, go_on).unwrap().0.poses.len();
    let (short, long) = (kept(12.0), kept(60.0));
    println!("rows of 12 s {short}, of 60 s {long}");
    // With all rows: 36 000 and 180 000. Seen: 13 447 of both.
    assert!(long <= short + 10 && short < 18_000, "{short} {long}");

    // Of a folder the same, and at every instant the pose that all rows have.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dice.timeline");
    let loaded = scene(12.0);
    let (kept, _) = simulate_and_keep(&loaded, &everything, &path, false, go_on).unwrap();
    let reader = TimelineReader::open(&path).unwrap();
    let all = reader.read_all().unwrap();
    let read = read_impacts(&reader, &everything, false).unwrap();
    assert!(read.poses.len() < all.poses.len() / 2, "{} of {}", read.poses.len(), all.poses.len());
    let bodies = &loaded.world.bodies;
    let history = |timeline: &Timeline| PoseHistory::try_new(bodies, &timeline.poses).unwrap();
    let [whole, read, kept] = [&all, &read, &kept].map(history);
    for k in 0..120_001 {
        let time = f64::from(k) * 1e-4;
        for body in &everything {
            let pose = whole.at(*body, time);
            assert_eq!(read.at(*body, time), pose, "{body:?} at {time} s");
            // Files have 32 bits.
            let apart = kept.at(*body, time).position.distance(pose.position);
            assert!(apart < 2e-6, "{body:?} at {time} s: {apart}");
        }
    }
    let impacts = all.contacts.iter().filter(|row| row.impact_id != 0);
    for row in impacts.filter(|row| row.body_a.index() < 3) {
        let velocity = |poses: &PoseHistory| poses.velocity_at(row.body_a, row.point, row.time);
        assert_eq!(velocity(&read), velocity(&whole), "at {} s", row.time);
        assert_eq!(velocity(&kept).is_some(), velocity(&whole).is_some(), "at {} s", row.time);
    }
}
