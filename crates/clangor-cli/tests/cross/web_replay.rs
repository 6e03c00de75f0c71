//! A replay file played by the real-time engine, as the page plays it, sounds as `clangor render` does.

use std::fs;
use std::path::Path;

use clangor_core::glam::DVec3;
use clangor_core::material::Damping;
use clangor_core::realtime::event_row::{DecodedRow, ROW, RowDecoder};
use clangor_core::realtime::{EngineSettings, Event, SoundingObject, engine};
use clangor_core::scene::Scene;
use safetensors::SafeTensors;
use serde_json::Value;

/// A disc with its own field and modes, a die and a bar as ellipsoids, and a ball.
const SCENE: &str = r#"
version = 1

[simulation]
duration = 0.5

[render]
floor = "rigid"
ground = "none"
max_frequency = 16000

[[body]]
name = "disc"
shape = "coin:0.03x0.002@0.003"
material = "steel"
position = [0.0, 0.1, 0.0]
orientation = { axis = [1.0, 0.0, 0.6], degrees = 20.0 }

[[body]]
name = "die"
shape = "die"
material = "plastic"
acceleration = "proxy"
position = [0.2, 0.1, 0.1]
orientation = { axis = [1.0, 0.3, 0.6], degrees = 40.0 }

[[body]]
name = "bar"
shape = "box:0.06x0.004x0.03"
material = "glass"
modal = "proxy"
acceleration = "proxy"
position = [-0.2, 0.1, 0.1]
orientation = { axis = [1.0, 0.5, 0.6], degrees = 30.0 }

[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0.1, 0.1, -0.2]

[[plane]]
material = "granite"

[[plane]]
name = "wall"
point = [-1.0, 0.0, 0.0]
normal = [1.0, 0.1, 0.2]
material = "wood"
reflects = true
absorption = 0.1

[[listener]]
name = "ears"
position = [0.2, 0.5, 0.8]
spacing = 0.17
"#;

fn numbers<const N: usize, T>(bytes: &[u8], of: impl Fn([u8; N]) -> T) -> Vec<T> {
    bytes.as_chunks::<N>().0.iter().map(|b| of(*b)).collect()
}

/// Plays a replay file from its beginning, as the page does. Returns the left and the right channel \[Pa\],
/// from time 0 of the run.
fn replayed(path: &Path, frames: usize) -> [Vec<f64>; 2] {
    let bytes = fs::read(path).expect("a file");
    let arrays = SafeTensors::deserialize(&bytes).expect("safetensors");
    let (_, header) = SafeTensors::read_metadata(&bytes).expect("a header");
    let text = header.metadata().as_ref().and_then(|m| m.get("clangor")).expect("a description");
    let report: Value = serde_json::from_str(text).expect("JSON");
    let array = |name: &str| arrays.tensor(name).expect(name).data().to_vec();
    let scene = Scene::from_toml(report["scene"].as_str().expect("a scene")).expect("a scene");
    let settings = EngineSettings { objects: 1024, ..EngineSettings::from_scene(&scene) };
    let (mut controller, mut live) = engine(&settings).expect("an engine");

    let (ranges, files) = (numbers(&array("sounds.ranges"), u32::from_le_bytes), array("sounds.bytes"));
    let sounds = report["sounds"].as_array().expect("sounds");
    assert_eq!(ranges.len(), 2 * sounds.len());
    for (slot, sound) in sounds.iter().enumerate() {
        let [first, count] = [ranges[2 * slot], ranges[2 * slot + 1]].map(|n| n as usize);
        let t60: Vec<[f64; 2]> = serde_json::from_value(sound["t60"].clone()).expect("a table");
        let damping = (!t60.is_empty()).then_some(Damping::T60Table(t60));
        let file = &files[first..first + count];
        let object = SoundingObject::from_file(file, damping.as_ref(), &settings).expect("a sound");
        controller.put(slot, Some(object)).expect("room");
    }
    let vector =
        |values: &Value| DVec3::from_array(serde_json::from_value(values.clone()).expect("a vector"));
    let listener = &report["listeners"][0];
    controller.send(Event::Receivers([vector(&listener["left"]), vector(&listener["right"])])).expect("room");
    let mut decoder = RowDecoder::default();
    for row in numbers(&array("events"), f64::from_le_bytes).as_chunks::<ROW>().0 {
        let event = match decoder.decode(row) {
            DecodedRow::Event(event) => event,
            DecodedRow::ForceHistory => continue,
            DecodedRow::Unknown => panic!("{row:?} is of an unknown kind"),
        };
        assert!(!matches!(event, Event::End { .. }), "no body of this scene breaks");
        controller.send(event).expect("room");
    }
    let latency = (live.latency() * settings.sample_rate.as_f64()).round() as usize;
    let mut ears = [Vec::new(), Vec::new()];
    while ears[0].len() < frames + latency {
        let channels = live.render(256);
        ears.iter_mut().zip(channels).for_each(|(ear, channel)| ear.extend_from_slice(channel));
    }
    let report = live.report();
    assert_eq!((report.refused, report.lost, report.late), (0, 0, 0), "{report:?}");
    ears.map(|ear| ear[latency..latency + frames].to_vec())
}

#[test]
fn the_page_hears_what_is_rendered() {
    let folder = tempfile::tempdir().expect("a folder");
    let clangor = |arguments: &[&str]| crate::program::clangor(folder.path(), arguments);
    fs::write(folder.path().join("scene.toml"), SCENE).expect("written");
    clangor(&["simulate", "scene.toml", "-o", "run.timeline"]);
    clangor(&["render", "run.timeline", "-o", "run.wav"]);
    clangor(&["export", "web", "run.timeline"]);
    let (samples, rate) = crate::sound_file::samples(&folder.path().join("run.wav"));
    assert_eq!(rate, 48_000.0);
    let ears = replayed(&folder.path().join("run.replay"), samples.len() / 2);
    for (ear, name) in ears.iter().zip(["left", "right"]) {
        let offset = usize::from(name == "right");
        let rendered: Vec<f64> = samples.iter().skip(offset).step_by(2).map(|p| f64::from(*p)).collect();
        let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|p| p * p).sum::<f64>().sqrt();
        let apart =
            norm(&mut ear.iter().zip(&rendered).map(|(a, b)| a - b)) / norm(&mut rendered.iter().copied());
        // Seen: 0.021 and 0.023. Between pose events, bodies move in straight lines.
        assert!(apart < 0.05, "{name}: {apart}");
    }
}
