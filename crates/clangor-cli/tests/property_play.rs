//! `clangor play`, on ALSA's null device, which takes samples and drops them; and without any device.

#![cfg(all(feature = "playback", target_os = "linux"))]

mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Two bounces of a ball, and a coin that rings.
const SCENE: &str = r#"
version = 1

[simulation]
duration = 0.8

[render]
floor = "rigid"

[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0.0, 0.11, 0.0]

[[body]]
name = "coin"
shape = "coin"
material = "steel"
position = [0.5, 0.2, 0.0]
orientation = { axis = [1.0, 0.0, 0.6], degrees = 30.0 }

[[plane]]
material = "granite"

[[listener]]
name = "ears"
position = [0.2, 0.5, 0.8]
spacing = 0.17
"#;

/// Runs the program in a folder whose audio devices are those of `configuration`.
fn play(folder: &Path, configuration: &str, arguments: &[&str]) -> Output {
    fs::write(folder.join("asound.conf"), configuration).expect("written");
    fs::write(folder.join("scene.toml"), SCENE).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_clangor"));
    command.args(["play", "--quality", "draft", "--json"]).args(arguments).current_dir(folder);
    command.env("CLANGOR_CACHE", folder.join("cache")).env("ALSA_CONFIG_PATH", folder.join("asound.conf"));
    command.output().expect("runs")
}

const NULL: &str = "pcm.!default { type null }\n";

#[test]
fn a_scene_is_played_to_its_end_in_its_own_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let begun = Instant::now();
    let output = play(folder.path(), NULL, &["scene.toml"]);
    let (said, report) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{said}{report}");
    // A device that drops samples takes them at once, and is held back to 0.3 s ahead.
    assert!(begun.elapsed() > Duration::from_secs_f64(0.4), "{:?}", begun.elapsed());
    let played: Value = serde_json::from_str(&said).expect("JSON");
    let number = |name: &str| played[name].as_f64().unwrap_or(f64::NAN);
    // Seen: 16 impacts on the ball and the coin.
    assert!(number("impacts") >= 4.0 && number("taken") >= number("impacts"), "{said}");
    assert!(number("waves") >= 2.0 * 2.0 * 2.0, "two bodies, two ears, two ways: {said}");
    assert_eq!(number("objects"), 1.0, "the coin: {said}");
    for none in ["late", "lost", "refused", "left_out", "underruns"] {
        assert_eq!(number(none), 0.0, "{none}: {said}");
    }
    // Seen: 4.7 ms.
    assert!((0.0..0.02).contains(&number("engine_latency_s")), "{said}");
    assert!(number("device_latency_s") >= 0.0 && number("full_scale_pa") > 1e-3, "{said}");

    program::clangor(folder.path(), &["simulate", "scene.toml", "-o", "run.timeline"]);
    let part =
        play(folder.path(), NULL, &["run.timeline", "--from", "0.5", "--to", "0.6", "--full-scale", "3"]);
    let part: Value = serde_json::from_slice(&part.stdout).expect("JSON");
    assert_eq!((part["from_s"].as_f64(), part["full_scale_pa"].as_f64()), (Some(0.5), Some(3.0)));
    assert!(part["impacts"].as_u64() < played["impacts"].as_u64(), "{part}");
}

#[test]
fn without_a_device_it_says_so_before_it_simulates() {
    let folder = tempfile::tempdir().expect("a folder");
    for arguments in [&["scene.toml"][..], &["scene.toml", "--device", "organ"]] {
        let output = play(folder.path(), "# no device\n", arguments);
        let report = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{report}");
        assert!(report.contains("audio device") && !report.contains("panicked"), "{report}");
    }
    let listed = play(folder.path(), NULL, &["--devices"]);
    assert!(listed.status.success(), "{}", String::from_utf8_lossy(&listed.stderr));
}
