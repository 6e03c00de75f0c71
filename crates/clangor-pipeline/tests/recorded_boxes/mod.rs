//! Thirty boxes thrown onto a floor by PyBullet (`record.py`): the scene, and tables of their poses at
//! several rates.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use clangor_pipeline::formats::named_bodies::NamedBodies;
use clangor_pipeline::formats::pose_table::read_pose_table;
use clangor_pipeline::stages::load::{LoadedScene, load_scene};

/// Frames per second of the recording \[Hz\].
pub(crate) const RATE: u32 = 1000;

/// The folder of the recording.
pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recorded_boxes")
}

pub(crate) fn scene() -> LoadedScene {
    load_scene(&folder().join("boxes.toml"), &|_| ()).unwrap()
}

/// A table in a folder with the poses of every so many frames, z up.
pub(crate) fn poses(loaded: &LoadedScene, every: usize, folder: &Path) -> PathBuf {
    let table = read_pose_table(&self::folder().join("poses.parquet"), &NamedBodies::of(&loaded.world));
    let bodies = table.unwrap().bodies;
    let axes = ["position_x", "position_y", "position_z"];
    let turns = ["orientation_x", "orientation_y", "orientation_z", "orientation_w"];
    let mut text = format!("t,body,{},{}\n", axes.join(","), turns.join(","));
    for k in (0..bodies[0].1.len()).step_by(every) {
        for (body, frames) in &bodies {
            let frame = &frames[k];
            let [x, y, z] = frame.pose.position.to_array();
            let [a, b, c, d] = frame.pose.orientation.to_array();
            let number = body.index();
            writeln!(text, "{},{number},{x},{y},{z},{a},{b},{c},{d}", frame.time).unwrap();
        }
    }
    let path = folder.join(format!("poses-{every}.csv"));
    fs::write(&path, text).unwrap();
    path
}
