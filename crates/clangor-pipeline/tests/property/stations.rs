//! Paths of glTF files with few keys, and bodies that nothing stops.

use crate::imported_motion::{folder, scene};
use crate::motion_input::{Channel, write_gltf};
use clangor_pipeline::formats::gltf_motion::{GltfChoice, read_gltf_motion};
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::motion_import::{MotionFiles, import_motion};
use clangor_pipeline::stages::load::load_scene;
use glam::DVec3;
use serde_json::json;

/// Down by 0.3 m in half a second, and rest.
fn lowered() -> Channel {
    let heights = [0.3_f32, 0.0, 0.0];
    let values = heights.iter().flat_map(|y| [0.0, *y, 0.0]).collect();
    Channel { path: "translation", interpolation: "LINEAR", keys: vec![0.0, 0.5, 0.8], values }
}

#[test]
fn property_linear_keys_far_apart_are_stations_of_lines() {
    let folder = folder(scene!(), &[]);
    write_gltf(folder.path(), &json!({}), &[lowered()]);
    let path = folder.path().join("a.gltf");
    let motion = read_gltf_motion(&path, &GltfChoice::default()).unwrap();
    let frames = &motion.nodes[0].frames;
    assert!(frames.windows(2).all(|pair| pair[1].time - pair[0].time < 1.001 / 240.0), "{}", frames.len());
    let off = frames.iter().map(|frame| {
        let height = 0.3 * (1.0 - frame.time / 0.5).max(0.0);
        frame.pose.position.distance(DVec3::Y * height)
    });
    let off = off.fold(0.0, f64::max);
    println!("off the line by {off:.1e} m");
    // Residual seen: 1.2e-8, as values have 32 bits.
    assert!(off < 1e-7, "{off}");

    // The impact is at the key, with the momentum of the line.
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let files = MotionFiles { gltf: vec![path], ..MotionFiles::default() };
    let out = folder.path().join("out.timeline");
    import_motion(&loaded, &files, &out, true).unwrap();
    let reader = TimelineReader::open(&out).unwrap();
    let bodies = &reader.header().world.bodies;
    let mass = bodies.iter().find(|body| body.name == "stone").unwrap().mass;
    let timeline = reader.read_all().unwrap();
    let impulse: f64 = timeline.contacts.iter().map(|row| row.impulse_n).sum();
    println!("{impulse} of {} N s at {:?}", 0.6 * mass, timeline.contacts.first().map(|row| row.time));
    // Residual seen: 5e-9.
    assert!((impulse / (0.6 * mass) - 1.0).abs() < 0.02, "{impulse} of {}", 0.6 * mass);
    assert!(timeline.contacts.iter().all(|row| (row.time - 0.5).abs() < 0.5 / 240.0));
}

#[test]
fn property_a_kinematic_body_that_strikes_nothing_that_moves_is_named() {
    let folder = folder(scene!(), &[]);
    let physics = json!({ "motion": { "isKinematic": true } });
    let node = json!({ "extensions": { "KHR_physics_rigid_bodies": physics } });
    write_gltf(folder.path(), &node, &[lowered()]);
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let files = MotionFiles { gltf: vec![folder.path().join("a.gltf")], ..MotionFiles::default() };
    let summary = import_motion(&loaded, &files, &folder.path().join("out.timeline"), true).unwrap();
    let said = summary.notices.join("\n");
    assert!(said.contains("on what cannot move either: stone"), "{said}");
}
