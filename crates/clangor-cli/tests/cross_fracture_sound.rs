//! What a person does with a scene that breaks: simulate, inspect, render, render the timeline again.

mod program;
mod sound_file;

use std::fs;
use std::path::Path;

use program::clangor;
use sound_file::samples;

/// A tile just above the floor; `released` says whether its cracks drive the pieces apart.
fn scene(folder: &Path, name: &str, released: bool) {
    let text = format!(
        "version = 1\n[simulation]\nduration = 0.05\ntime_step = 0.0001\n[material.tough]\nbase = \"ceramic\"\n\
         fracture_energy = 150\n[[body]]\nname = \"tile\"\nshape = \"box:0.12x0.006x0.12\"\nmaterial = \"tough\"\n\
         position = [0, 0.03, 0]\norientation = {{ axis = [0.3, 0, 1], degrees = 12 }}\nvelocity = [0, -4, 0]\n\
         fracture = {{ edge = 0.01, crack_impulses = {released} }}\n[[plane]]\nmaterial = \"granite\"\n\
         [[listener]]\nposition = [0, 0.4, 1]\n"
    );
    fs::write(folder.join(name), text).unwrap();
}

/// ∫ p² dt \[Pa² s\] over the first milliseconds from the first sound on.
fn onset(path: &Path, milliseconds: f64) -> f64 {
    let (samples, rate) = samples(path);
    let samples: Vec<f64> = samples.into_iter().map(f64::from).collect();
    let peak = samples.iter().map(|p| p.abs()).fold(0.0, f64::max);
    let first = samples.iter().position(|p| p.abs() > 1e-3 * peak).unwrap();
    let length = (1e-3 * milliseconds * rate) as usize;
    samples[first..].iter().take(length).map(|p| p * p).sum::<f64>() / rate
}

#[test]
fn a_breaking_scene_is_kept_and_rendered_again() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "tile.toml", true);
    let told: serde_json::Value = serde_json::from_str(&clangor(
        folder.path(),
        &["--json", "simulate", "tile.toml", "-o", "tile.timeline"],
    ))
    .unwrap();
    let births = told["births"].as_u64().unwrap();
    println!("{} fractures, {births} births", told["fractures"]);
    assert!(births >= 2 && told["breaking"]["solved"].as_u64().unwrap() > 0, "{told}");
    let inspected: serde_json::Value =
        serde_json::from_str(&clangor(folder.path(), &["--json", "inspect", "tile.timeline"])).unwrap();
    assert_eq!(inspected["births"].as_u64().unwrap(), births);
    let parts = ["--parts", "acceleration", "--quality", "draft"];
    clangor(folder.path(), &[&["render", "tile.toml", "-o", "direct.wav"][..], &parts].concat());
    clangor(folder.path(), &[&["render", "tile.timeline", "-o", "again.wav"][..], &parts].concat());
    let [direct, again] = ["direct.wav", "again.wav"].map(|name| onset(&folder.path().join(name), 50.0));
    // The file keeps points and impulses in single precision; 1e-6 seen.
    assert!(direct > 0.0 && (again / direct - 1.0).abs() < 1e-4, "{direct} {again}");
}
