//! The end of a glTF animation: the format holds the last values, so a body that arrives with its last key
//! stops there, and one that is in flight or sliding does not hit anything.

use std::fs;
use std::path::Path;

use clangor_core::timeline::ContactKind;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use serde_json::json;

use crate::imported_motion::{folder, import};

const SCENE: &str = "version = 1\n[simulation]\nduration = 3.0\n[[plane]]\nname = \"floor\"\n\
                     material = \"granite\"\n[[listener]]\nposition = [0.3, 0.4, 0.4]\n";

/// Writes `a.gltf`: a granite tetrahedron of edges 0.1 m, a face down, with a key of its place for each
/// frame.
fn write_stone(folder: &Path, rate: f64, places: &[[f32; 3]]) {
    let corners = [[0.0_f32, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let indices: [u32; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let floats =
        |values: &mut dyn Iterator<Item = f32>| -> Vec<u8> { values.flat_map(f32::to_le_bytes).collect() };
    let parts = [
        floats(&mut corners.into_iter().flatten()),
        indices.iter().flat_map(|i| i.to_le_bytes()).collect(),
        floats(&mut (0..places.len()).map(|k| (k as f64 / rate) as f32)),
        floats(&mut places.iter().flatten().copied()),
    ];
    let mut at = 0;
    let views = parts.iter().map(|part| {
        at += part.len();
        json!({ "buffer": 0, "byteOffset": at - part.len(), "byteLength": part.len() })
    });
    let views: Vec<_> = views.collect();
    let accessor = |view: usize, component: u32, of: &str| {
        let size = if component == 5125 || of == "SCALAR" { 4 } else { 12 };
        let count = parts[view].len() / size;
        json!({ "bufferView": view, "componentType": component, "count": count, "type": of })
    };
    let document = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "stone", "mesh": 0, "extras": { "material": "granite" } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [accessor(0, 5126, "VEC3"), accessor(1, 5125, "SCALAR"),
            accessor(2, 5126, "SCALAR"), accessor(3, 5126, "VEC3")],
        "bufferViews": views, "buffers": [{ "byteLength": at, "uri": "data.bin" }],
        "animations": [{ "samplers": [{ "input": 2, "output": 3 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] }],
    });
    fs::write(folder.join("a.gltf"), document.to_string()).unwrap();
    fs::write(folder.join("data.bin"), parts.concat()).unwrap();
}

/// Imports frames at a rate and gives the impulses of its impacts over the mass [m/s], the notices, and the
/// duration of the timeline \[s\].
fn imported(rate: f64, places: &[[f32; 3]]) -> (Vec<f64>, Vec<String>, f64) {
    let folder = folder(SCENE, &[]);
    write_stone(folder.path(), rate, places);
    let notices = import(folder.path(), &["a.gltf"], &[], false).unwrap().notices;
    let reader = TimelineReader::open(&folder.path().join("out.timeline")).unwrap();
    let timeline = reader.read_all().unwrap();
    let header = reader.header();
    let mass = header.world.bodies.iter().find(|body| body.name == "stone").unwrap().mass;
    let impacts = timeline.contacts.iter().filter(|row| row.kind == ContactKind::Impact);
    let mut impulses: Vec<(u64, f64)> = Vec::new();
    for row in impacts {
        match impulses.iter_mut().find(|(id, _)| *id == row.impact_id) {
            Some((_, sum)) => *sum += row.impulse_n / mass,
            None => impulses.push((row.impact_id, row.impulse_n / mass)),
        }
    }
    (impulses.into_iter().map(|(_, speed)| speed).collect(), notices, header.origin.duration)
}

#[test]
fn property_what_arrives_with_its_last_key_hits() {
    for rate in [24.0, 60.0, 120.0] {
        let frames = (0.5 * rate) as i32;
        // Set down at 0.6 m/s.
        let height = |k: i32| (0.6 * f64::from(frames - k) / rate) as f32;
        let places: Vec<[f32; 3]> = (0..=frames).map(|k| [0.0, height(k), 0.0]).collect();
        let (speeds, notices, duration) = imported(rate, &places);
        assert_eq!(speeds.len(), 1, "{rate} Hz: {speeds:?}, {notices:?}");
        println!("{rate} Hz: {:.1e}", speeds[0] / 0.6 - 1.0);
        // The fit leaves up to half a percent; seen: 4e-3.
        assert!((speeds[0] / 0.6 - 1.0).abs() < 6e-3, "{rate} Hz: {speeds:?}");
        // It rings on as long as the scene lasts.
        assert_eq!(duration, 3.0);
    }
}

#[test]
fn property_the_end_of_the_keys_is_no_impact() {
    let rate = 60.0;
    let times = || (0..=30).map(|k| f64::from(k) / rate);
    let falling = times().map(|t| [0.0, (2.0 - 4.905 * t * t) as f32, 0.0]).collect::<Vec<_>>();
    let sliding = times().map(|t| [(0.8 * t) as f32, 0.0, 0.0]).collect::<Vec<_>>();
    for places in [falling, sliding] {
        let (speeds, notices, _) = imported(rate, &places);
        assert_eq!(speeds, [] as [f64; 0]);
        // Of one jump or of more.
        assert!(!notices.iter().any(|notice| notice.contains("of the motion touch")), "{notices:?}");
    }
}
