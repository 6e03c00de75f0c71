//! Names of the files of a rendering: one per listener, and with stems one per listener and body.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clangor_core::body::{Body, Motion};
use clangor_core::synthesis::Listener;
use clangor_core::synthesis::SoundPart;

use super::error::RenderError;
use super::ground::is_ground;
use super::options::RenderOptions;
use crate::formats::atomic_file::check_folder;
use crate::formats::wav::WavError;

/// `output`, with the listener's name if there are several, and the stem's.
pub(super) fn file_name(
    output: &Path,
    options: &RenderOptions,
    listener: &Listener,
    stem: Option<(&str, SoundPart)>,
) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    // A name may hold anything; a file name may not.
    let safe = |text: &str| text.replace(|c: char| !(c.is_alphanumeric() || "-_ ".contains(c)), "_");
    if options.listeners.len() > 1 {
        name = format!("{name}.{}", safe(&listener.name));
    }
    if let Some((body, part)) = stem {
        name = format!("{name}.{}.{part}", safe(body));
    }
    match output.extension() {
        Some(extension) => output.with_file_name(format!("{name}.{}", extension.to_string_lossy())),
        None => output.with_file_name(name),
    }
}

/// Checks whether the files of a rendering can be written, before a long simulation.
///
/// # Errors
/// Those of [`render`](super::render) that do not depend on the impacts.
pub fn check_output(options: &RenderOptions, bodies: &[Body], output: &Path) -> Result<(), RenderError> {
    check_folder(output).map_err(WavError::from)?;
    options.check_sound()?;
    check_distinct(options, bodies, output)
}

/// Rejects names of listeners and bodies that differ, but make one file name.
fn check_distinct(options: &RenderOptions, bodies: &[Body], output: &Path) -> Result<(), RenderError> {
    let mut stems: Vec<Option<(&str, SoundPart)>> = vec![None];
    for body in bodies.iter().filter(|_| options.stems) {
        let parts: &[SoundPart] = match body.motion {
            Motion::Free | Motion::Guided(_) => &[SoundPart::Acceleration, SoundPart::Modal],
            _ if is_ground(body, options) => &[SoundPart::Ground],
            _ => &[SoundPart::Modal],
        };
        stems.extend(parts.iter().map(|part| Some((body.name.as_str(), *part))));
    }
    let mut files = BTreeMap::new();
    for listener in &options.listeners {
        for stem in &stems {
            let sound = match stem {
                None => format!("listener \"{}\"", listener.name),
                Some((body, _)) => format!("body \"{body}\" at listener \"{}\"", listener.name),
            };
            let path = file_name(output, options, listener, *stem);
            // Some file systems do not tell A from a.
            let key = path.to_string_lossy().to_lowercase();
            if let Some(first) = files.insert(key, sound.clone()) {
                return Err(RenderError::SameFile { first, second: sound, path });
            }
        }
    }
    Ok(())
}
