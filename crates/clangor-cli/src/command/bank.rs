//! `clangor bank`: the banks of ellipsoids that stand for small bodies when they click, and when they ring.

use std::path::Path;
use std::time::Instant;

use clangor_bake::soundbank::modal::ModalSoundbankOptions;
use clangor_core::medium::Medium;
use clangor_core::sound_model::files::ellipsoid_bank_file::BankFile;
use clangor_core::sound_model::files::modal_soundbank_file::ModalSoundbankFile;
use clangor_pipeline::formats::atomic_file::{check_folder, write_atomically};
use clangor_pipeline::formats::modal_soundbank::{bank_material, build_modal_soundbank};
use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::formats::soundbank::{EllipsoidBankOptions, build_bank};
use clangor_pipeline::session::named_body::preset;
use clangor_pipeline::stages::sound_models::SoundModelError;
use clangor_pipeline::stages::sound_models::{SoundFile, read_sound_file};
use serde_json::json;

use super::check_ending;
use crate::arguments::{Bank, BankAction, Global};
use crate::console::{Console, counted};
use crate::failure::Failure;

/// Error of the click of an ellipsoid unless another is asked for.
const ACCURACY: f64 = 1e-3;
/// What a bank leaves out, over the accuracy asked for.
const LEFT_OUT: f64 = 0.3;

pub(crate) fn run(options: &Bank, global: &Global, console: &Console) -> Result<(), Failure> {
    match &options.action {
        BankAction::Build { output, material: Some(material), accuracy, .. } => {
            build_modal(output.as_deref(), material, *accuracy, global, console)
        }
        BankAction::Build { output: Some(output), accuracy, max_wavenumber, .. } => {
            let accuracy = accuracy.unwrap_or(ACCURACY);
            build(output, &EllipsoidBankOptions { accuracy, max_wavenumber: *max_wavenumber }, console)
        }
        BankAction::Build { output: None, .. } => {
            Err(Failure::new("the bank of clicks needs a file: add -o BANK.safetensors"))
        }
        BankAction::Info { file } => match read_sound_file(file).map_err(Failure::new)? {
            SoundFile::Bank(bank) => {
                report(console, file, &bank);
                Ok(())
            }
            SoundFile::ModalSoundbank(bank) => {
                report_modal(console, file, &bank);
                Ok(())
            }
            SoundFile::Model(_) | SoundFile::Modal(_) | SoundFile::Pan(_) => Err(Failure::new(format_args!(
                "{} is the model of one body; see clangor inspect",
                file.display()
            ))),
        },
    }
}

/// Bakes every ellipsoid.
fn build(output: &Path, options: &EllipsoidBankOptions, console: &Console) -> Result<(), Failure> {
    check_ending(output, "safetensors")?;
    check_folder(output).map_err(Failure::new)?;
    let started = Instant::now();
    let progress = console.progress("bank", 1.0);
    let built = build_bank(options, &mut |done| progress.reached(done));
    drop(progress);
    let built = built.map_err(SoundModelError::from)?;
    let bytes = built.encode(LEFT_OUT * options.accuracy).map_err(Failure::new)?;
    // What is reported is what was stored.
    let stored = BankFile::decode(&bytes).map_err(Failure::new)?;
    write_atomically(output, &bytes).map_err(Failure::new)?;
    console.say(format_args!("built in {:.1} s", started.elapsed().as_secs_f64()));
    report(console, output, &stored);
    Ok(())
}

/// Bakes every ringing ellipsoid.
fn build_modal(
    output: Option<&Path>,
    name: &str,
    accuracy: Option<f64>,
    global: &Global,
    console: &Console,
) -> Result<(), Failure> {
    if let Some(output) = output {
        check_ending(output, "safetensors")?;
        check_folder(output).map_err(Failure::new)?;
    }
    let material = preset(name)?;
    let mut options = ModalSoundbankOptions::new(bank_material(&material, Medium::AIR));
    options.accuracy = accuracy.unwrap_or(options.accuracy);
    let started = Instant::now();
    let progress = console.progress("modal bank", 1.0);
    let built = build_modal_soundbank(&material.name, &options, &mut |done| progress.reached(done));
    drop(progress);
    let bytes = built.map_err(Failure::new)?.encode().map_err(Failure::new)?;
    // What is reported is what was stored.
    let stored = ModalSoundbankFile::decode(&bytes).map_err(Failure::new)?;
    let path = match (output, ModelCache::find(global.cache.as_deref())) {
        (Some(output), _) => {
            write_atomically(output, &bytes).map_err(Failure::new)?;
            output.to_path_buf()
        }
        (None, Some(cache)) => cache.write(&stored).map_err(Failure::new)?,
        (None, None) => {
            return Err(Failure::new("there is no cache: name a file with -o, or a cache with --cache"));
        }
    };
    console.say(format_args!("built in {:.1} s", started.elapsed().as_secs_f64()));
    report_modal(console, &path, &stored);
    Ok(())
}

/// What is in a bank of ringing ellipsoids.
pub(super) fn report_modal(console: &Console, path: &Path, file: &ModalSoundbankFile) {
    let (bank, origin) = (&file.bank, &file.origin);
    let entries = bank.entries();
    let bytes = std::fs::metadata(path).map_or(0, |m| m.len());
    let modes: usize = entries.iter().map(|entry| entry.modes.len()).sum();
    let order = entries.iter().flat_map(|e| &e.modes).map(|m| m.order).max().unwrap_or(0);
    let material = bank.material();
    console.say(format_args!(
        "{}: {} of {}, {}, {:.3} MB",
        path.display(),
        counted(entries.len(), "ringing ellipsoid", "ringing ellipsoids"),
        origin.material,
        counted(modes, "mode", "modes"),
        bytes as f64 * 1e-6
    ));
    console.say(format_args!(
        "to {:.0} Hz for bodies up to {:.3} m with a lowest frequency from {:.0} Hz; shapes to degree {}, \
         multipoles to order {order}",
        origin.max_frequency,
        origin.largest_size,
        origin.least_first_frequency,
        bank.degree()
    ));
    let ellipsoids = entries.iter().map(|e| {
        json!({
            "semi_axes": e.semi_axes.to_array(),
            "modes": e.modes.len(),
            "first_frequency_hz": e.modes.first().map(|m| m.frequency),
            "max_frequency_hz": e.max_frequency,
        })
    });
    console.json(&json!({
        "bank": path.display().to_string(),
        "bytes": bytes,
        "ellipsoids": ellipsoids.collect::<Vec<_>>(),
        "modes": modes,
        "material": origin.material,
        "youngs_modulus_pa": material.youngs_modulus,
        "density_kg_m3": material.density,
        "poisson_ratio": material.poisson_ratio,
        "sound_speed_m_s": material.medium.sound_speed,
        "asked_accuracy": origin.asked_accuracy,
        "spacing": origin.spacing,
        "program": origin.program,
    }));
}

/// What is in a bank.
pub(super) fn report(console: &Console, path: &Path, file: &BankFile) {
    let entries = file.bank.entries();
    let bytes = std::fs::metadata(path).map_or(0, |m| m.len());
    let band = entries.iter().map(|e| e.field.max_wavenumber).fold(f64::INFINITY, f64::min);
    let order = entries.iter().map(|e| e.field.order()).max().unwrap_or(0);
    let nodes: usize = entries.iter().map(|e| e.field.nodes.len()).sum();
    console.say(format_args!(
        "{}: {} to kA = {band:.3}, {:.3} MB",
        path.display(),
        counted(entries.len(), "ellipsoid", "ellipsoids"),
        bytes as f64 * 1e-6
    ));
    console.say(format_args!(
        "multipoles to order {order}, {:.1} nodes in frequency on average",
        nodes as f64 / entries.len().max(1) as f64
    ));
    console.say(format_args!(
        "{}, {} solved; error between them up to {:.1e}, asked for {:.1e}",
        if file.origin.method.is_empty() { "solver not named" } else { &file.origin.method },
        counted(file.origin.solves as usize, "frequency", "frequencies"),
        file.origin.held_out_error,
        file.origin.asked_accuracy
    ));
    let ellipsoids = entries.iter().map(|e| {
        json!({
            "b": e.b,
            "c": e.c,
            "order": e.field.order(),
            "nodes": e.field.nodes.len(),
            "coefficients": e.field.terms.len(),
        })
    });
    console.json(&json!({
        "bank": path.display().to_string(),
        "bytes": bytes,
        "max_ka": band,
        "ellipsoids": ellipsoids.collect::<Vec<_>>(),
        "method": file.origin.method,
        "solves": file.origin.solves,
        "held_out_error": file.origin.held_out_error,
        "asked_accuracy": file.origin.asked_accuracy,
        "program": file.origin.program,
    }));
}
