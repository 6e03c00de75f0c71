//! Breaking that goes wrong half-way: what happened until then is kept, and the reason is report.

use std::fs;
use std::path::Path;
use std::process::Output;

use clangor_pipeline::formats::timeline_file::TimelineReader;

use crate::program::{clangor, run};

/// A tile just above the floor that falls on it.
fn scene(folder: &Path, fracture: &str, more: &str) {
    let text = format!(
        "version = 1\n[simulation]\nduration = 0.05\ntime_step = 0.0001\n[material.tough]\n\
         base = \"ceramic\"\n\
         fracture_energy = 60\n[[body]]\nname = \"tile\"\nshape = \"box:0.12x0.006x0.12\"\n\
         material = \"tough\"\n\
         position = [0, 0.03, 0]\norientation = {{ axis = [0.3, 0, 1], degrees = 12 }}\n\
         velocity = [0, -4, 0]\n\
         fracture = {{ edge = 0.01{fracture} }}\n[[plane]]\nmaterial = \"granite\"\n{more}"
    );
    fs::write(folder.join("tile.toml"), text).unwrap();
}

fn simulate(folder: &Path) -> Output {
    run(folder, &["simulate", "tile.toml", "-o", "tile.timeline"])
}

#[test]
fn a_run_that_fails_keeps_the_timeline_so_far() {
    let folder = tempfile::tempdir().unwrap();
    // What hangs on a spring cannot break: nothing says on which piece the spring would be.
    scene(folder.path(), "", "[[spring]]\nbody = \"tile\"\nto = [0, 0.2, 0]\nstiffness = 1.0\n");
    let output = simulate(folder.path());
    let report = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{report}");
    assert!(report.contains("breaks at t = ") && report.contains("; what happened until "), "{report}");
    assert!(!folder.path().join("tile.timeline").exists());
    let kept = TimelineReader::open(&folder.path().join("tile.partial.timeline")).unwrap();
    // The impact that would have broken it is the last that happened: after 24 mm at 4 m/s.
    let duration = kept.header().origin.duration;
    assert!((0.001..0.01).contains(&duration), "{duration}");
    assert!(kept.rows().contacts > 0 && kept.rows().poses > 0, "{:?}", kept.rows());
    // It can be rendered as far as it goes.
    let render = ["render", "tile.partial.timeline", "-o", "tile.wav", "--acceleration", "sphere"];
    clangor(folder.path(), &[&render[..], &["--parts", "acceleration", "--listener", "0,1,1"]].concat());
}

#[test]
fn a_run_that_cannot_begin_keeps_nothing() {
    let folder = tempfile::tempdir().unwrap();
    scene(
        folder.path(),
        "",
        "[[body]]\nname = \"other\"\nshape = \"sphere:0.02\"\nmaterial = \"steel\"\n\
         position = [0, 0.03, 0]\n",
    );
    let output = simulate(folder.path());
    let report = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && report.contains("overlap"), "{report}");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["tile.toml"]);
}

#[test]
fn runaway_fragmentation_is_capped_and_told() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), ", most_pieces = 4", "");
    let output = simulate(folder.path());
    let report = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{report}");
    assert!(report.contains("in as many pieces as allowed already"), "{report}");
    let timeline = TimelineReader::open(&folder.path().join("tile.timeline")).unwrap();
    let whole = timeline.births().iter().filter(|body| body.life.death == f64::INFINITY).count();
    assert!((2..=4).contains(&whole), "{whole} pieces");
    assert_eq!(timeline.header().origin.duration, 0.05);
}
