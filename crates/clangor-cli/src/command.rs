//! One module per command, and what they share: how a scene is loaded, and how a seed is replaced.

mod audio_file;
pub(crate) mod bake;
pub(crate) mod bank;
pub(crate) mod check;
mod collision_parts;
pub(crate) mod compare;
mod cost;
mod dataset;
mod drafts;
pub(crate) mod export;
mod impact_modes;
pub(crate) mod import;
pub(crate) mod inspect;
mod model_options;
pub(crate) mod modes;
pub(crate) mod play;
pub(crate) mod plot;
pub(crate) mod render;
pub(crate) mod serve;
mod session;
pub(crate) mod simulate;
mod sound_sources;
pub(crate) mod strike;
pub(crate) mod validate;

use std::path::Path;

use clangor_core::scene::Scene;
use clangor_pipeline::session::reseed;
use clangor_pipeline::stages::load::{LoadedScene, load_scene};

use crate::arguments::Global;
use crate::console::Console;
use crate::diagnostics::draw_warnings;
use crate::failure::Failure;

/// Loads a scene and prints its warnings; `adjust` changes what the command line overrides.
fn load(
    path: &Path,
    global: &Global,
    adjust: &dyn Fn(&mut Scene),
    console: &Console,
) -> Result<LoadedScene, Failure> {
    let loaded = load_scene(path, &|scene| {
        if let Some(seed) = global.seed {
            reseed(scene, seed);
        }
        adjust(scene);
    })?;
    for drawn in draw_warnings(path, &loaded.text, loaded.warnings.iter()) {
        console.drawn(drawn);
    }
    loaded.warnings.iter().for_each(|warning| console.keep_warning(warning.to_string()));
    Ok(loaded)
}

/// Rejects an output whose ending would hide what it is.
fn check_ending(output: &Path, ending: &str) -> Result<(), Failure> {
    if output.extension().is_some_and(|e| e == ending) {
        return Ok(());
    }
    Err(Failure::new(format_args!("{}: the output must end in .{ending}", output.display())))
}

/// Refuses an output that would replace the file it is made of.
fn refuse_overwriting(input: &Path, output: &Path) -> Result<(), Failure> {
    match (input.canonicalize(), output.canonicalize()) {
        (Ok(read), Ok(written)) if read == written => Err(Failure::new(format_args!(
            "{} would replace what it is made of; name another output with -o",
            output.display()
        ))),
        _ => Ok(()),
    }
}

/// Whether a path names a timeline folder and not a scene.
fn is_timeline(path: &Path) -> bool {
    path.is_dir() || path.extension().is_some_and(|e| e == "timeline")
}
