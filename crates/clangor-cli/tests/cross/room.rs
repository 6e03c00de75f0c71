//! A ball that falls in a room, as a person renders it.

use std::fs;
use std::path::Path;

use crate::program::clangor;
use crate::sound_file::samples;

const BALL: &str = "version = 1\n[simulation]\nduration = 0.4\n[[body]]\nshape = \"sphere:0.01\"\n\
    material = \"steel\"\n\
                    position = [0, 0.1, 0]\n[[plane]]\nmaterial = \"granite\"\n[[listener]]\n\
                    position = [0.5, 1.2, 0.4]\n";

fn rendered(folder: &Path, rest: &str) -> Vec<f32> {
    fs::write(folder.join("scene.toml"), format!("{BALL}{rest}")).unwrap();
    clangor(folder, &["--quiet", "render", "scene.toml", "--parts", "acceleration", "-o", "scene.wav"]);
    samples(&folder.join("scene.wav")).0
}

fn room(absorption: &str, rest: &str) -> String {
    format!("[room]\nlowest = [-2, 0, -1]\nhighest = [1.5, 2.5, 3]\nabsorption = {absorption}\n{rest}\n")
}

fn energy(samples: &[f32]) -> f64 {
    samples.iter().map(|p| f64::from(*p).powi(2)).sum()
}

#[test]
fn a_room_of_one_wall_is_a_rigid_floor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let wall = rendered(path, &room("{ walls = 1.0, floor = 0.0 }", "images = 1\nlate = false"));
    let floor = rendered(path, "[render]\nfloor = \"rigid\"\n");
    let peak = floor.iter().fold(0.0f32, |m, p| m.max(p.abs()));
    let apart = wall.iter().zip(&floor).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    // Residual seen: 9e-15.
    assert!(apart <= 1e-6 * peak, "{apart} of {peak}");
    // A room that absorbs all is no room.
    let felt = rendered(path, &room("1.0", ""));
    let free = rendered(path, "");
    let apart = felt.iter().zip(&free).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart <= 1e-6 * peak, "{apart} of {peak}");
}

#[test]
fn a_plane_that_reflects_is_a_rigid_floor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let floor = rendered(path, "[render]\nfloor = \"rigid\"\n");
    // The first plane of the scene reflects.
    let reflecting = BALL.replace("[[plane]]\n", "[[plane]]\nreflects = true\n");
    fs::write(path.join("plane.toml"), reflecting).unwrap();
    clangor(path, &["--quiet", "render", "plane.toml", "--parts", "acceleration", "-o", "plane.wav"]);
    assert_eq!(samples(&path.join("plane.wav")).0, floor);
}

#[test]
fn a_room_goes_on_sounding() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let (free, early) = (rendered(path, ""), rendered(path, &room("0.2", "late = false")));
    let whole = rendered(path, &room("0.2", ""));
    let dull = rendered(path, &(room("0.2", "") + "[render]\nair_absorption = true\n"));
    // Seen: 2.8 and 1.5.
    let [free_energy, early_energy, whole_energy] = [&free, &early, &whole].map(|s| energy(s));
    assert!(early_energy > 2.0 * free_energy && whole_energy > 1.3 * early_energy);
    assert!(energy(&dull) < 0.99 * whole_energy);
    // Walls of 66 m² and 20 % hold 35 m³ for 0.39 s: between the first impact at 0.14 s and the second at
    // 0.36 s it falls by about 60 · 0.1/0.39 = 15 dB in a tenth of a second.
    let at = |time: f64| energy(&whole[(time * 48_000.0) as usize..][..960]);
    let fall = 10.0 * (at(0.2) / at(0.3)).log10();
    assert!((12.0..22.0).contains(&fall), "{fall} dB");
}
