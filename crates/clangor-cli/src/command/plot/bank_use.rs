//! `clangor plot bank-use`.

use std::path::Path;

use clangor_pipeline::formats::atomic_file::write_atomically;
use clangor_pipeline::formats::modal_soundbank::default_modal_soundbank;
use clangor_pipeline::plots::bank_use;
use clangor_pipeline::stages::fracture_report::FractureReport;
use clangor_pipeline::stages::sound_models::{SoundFile, read_sound_file};
use serde_json::json;

use super::canvas;
use crate::console::Console;
use crate::failure::Failure;

/// Which ellipsoids stand for how many pieces.
pub(super) fn draw(
    report: &Path,
    output: &Path,
    bank: Option<&Path>,
    console: &Console,
) -> Result<(), Failure> {
    let mut canvas = canvas(output, bank_use::WIDTH, bank_use::HEIGHT)?;
    let failure = |e: &dyn std::fmt::Display| Failure::new(format_args!("{}: {e}", report.display()));
    let text = std::fs::read(report).map_err(|e| failure(&e))?;
    let fractures: FractureReport = serde_json::from_slice(&text).map_err(|e| failure(&e))?;
    let ringing = fractures.ringing.filter(|ringing| !ringing.ellipsoids.is_empty());
    let ringing = ringing.ok_or_else(|| {
        failure(
            &"no piece rings as an ellipsoid in it; `clangor render SCENE --report FILE.json` says which do",
        )
    })?;
    let entries: Vec<[f64; 3]> = match bank {
        None => default_modal_soundbank().iter().flat_map(|bank| axes(bank.entries())).collect(),
        Some(path) => match read_sound_file(path).map_err(Failure::new)? {
            SoundFile::ModalSoundbank(file) => axes(file.bank.entries()).collect(),
            _ => {
                return Err(Failure::new(format_args!(
                    "{} is no bank of ringing ellipsoids",
                    path.display()
                )));
            }
        },
    };
    let name = report.file_stem().unwrap_or_default().to_string_lossy();
    let title = format!("Ellipsoids that ring for the pieces of {name}");
    bank_use::draw(&title, &ringing, &entries, canvas.as_mut());
    write_atomically(output, &canvas.encode().map_err(Failure::new)?).map_err(Failure::new)?;
    console.say(format_args!(
        "{}: {} pieces as {} ellipsoids",
        output.display(),
        ringing.proxy_pieces,
        ringing.ellipsoids.len()
    ));
    console.json(&json!({
        "picture": output.display().to_string(),
        "pieces": ringing.proxy_pieces,
        "ellipsoids": ringing.ellipsoids.len(),
    }));
    Ok(())
}

fn axes(
    entries: &[std::sync::Arc<clangor_core::sound_model::soundbank::modal_soundbank::RingingEllipsoid>],
) -> impl Iterator<Item = [f64; 3]> {
    entries.iter().map(|entry| entry.semi_axes.to_array())
}
