//! A folder with a scene and files of recorded motion, and their import.

use std::fs;
use std::path::{Path, PathBuf};

use clangor_pipeline::interchange::file_frame::FileAxes;
use clangor_pipeline::interchange::motion_import::{MotionFiles, MotionSummary, import_motion};
use clangor_pipeline::motion::recording::LengthUnit;
use clangor_pipeline::stages::load::load_scene;
use tempfile::TempDir;

/// A scene of a ball of 1 cm in radius, 0.5 m above a floor, with more bodies between the two.
macro_rules! scene {
    ($($more:literal)?) => {
        concat!(
            "version = 1\n[[body]]\nname = \"ball\"\nshape = \"sphere:0.01\"\nmaterial = \"steel\"\n",
            "position = [0.0, 0.5, 0.0]\n",
            $($more,)?
            "[[plane]]\nname = \"floor\"\nmaterial = \"granite\"\n",
            "[[listener]]\nposition = [0.3, 0.4, 0.4]\n"
        )
    };
}
pub(crate) use scene;

/// A folder with `scene.toml` and files of these names and texts.
pub(crate) fn folder(scene: &str, files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [&[("scene.toml", scene)], files].concat() {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Imports the motion of glTF files and of tables, with contact lists, into `out.timeline`.
pub(crate) fn import(
    folder: &Path,
    motion: &[&str],
    contacts: &[&str],
    z_up: bool,
) -> Result<MotionSummary, String> {
    import_in(folder, motion, contacts, (z_up, LengthUnit::default()))
}

/// The same for files with these axes and this unit.
pub(crate) fn import_in(
    folder: &Path,
    motion: &[&str],
    contacts: &[&str],
    (z_up, unit): (bool, LengthUnit),
) -> Result<MotionSummary, String> {
    let loaded = load_scene(&folder.join("scene.toml"), &|_| ()).unwrap();
    let paths = |names: &[&str]| names.iter().map(|name| folder.join(name)).collect::<Vec<PathBuf>>();
    let (gltf, poses) = paths(motion).into_iter().partition(|p| p.extension().is_some_and(|e| e == "gltf"));
    let files = MotionFiles {
        gltf,
        poses,
        contacts: paths(contacts),
        axes: FileAxes { z_up, unit, ..FileAxes::default() },
        ..MotionFiles::default()
    };
    import_motion(&loaded, &files, &folder.join("out.timeline"), true).map_err(|error| error.to_string())
}
