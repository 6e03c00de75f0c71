//! `clangor bank`: the bank of ellipsoids that stand for small bodies.

use std::path::Path;
use std::time::Instant;

use clangor::model::bank_file::BankFile;
use clangor_pipeline::atomic_file::{check_folder, write_atomically};
use clangor_pipeline::sound_models::{SoundFile, read_sound_file};
use clangor_pipeline::soundbank::{BankOptions, build_bank};
use serde_json::json;

use super::check_ending;
use crate::arguments::{Bank, BankAction};
use crate::console::{Console, counted};
use crate::failure::Failure;

/// What a bank leaves out, over the accuracy asked for.
const LEFT_OUT: f64 = 0.3;

pub(crate) fn run(options: &Bank, console: &Console) -> Result<(), Failure> {
    match &options.action {
        BankAction::Build { output, accuracy, max_wavenumber } => {
            let options = BankOptions { accuracy: *accuracy, max_wavenumber: *max_wavenumber };
            build(output, &options, console)
        }
        BankAction::Info { file } => match read_sound_file(file).map_err(Failure::new)? {
            SoundFile::Bank(bank) => {
                report(console, file, &bank);
                Ok(())
            }
            SoundFile::Model(_) | SoundFile::Modal(_) | SoundFile::Published(_) => Err(Failure::new(
                format_args!("{} is the model of one body; see clangor inspect", file.display()),
            )),
        },
    }
}

/// Bakes every ellipsoid.
fn build(output: &Path, options: &BankOptions, console: &Console) -> Result<(), Failure> {
    check_ending(output, "safetensors")?;
    check_folder(output).map_err(Failure::new)?;
    let started = Instant::now();
    let progress = console.progress("bank", 1.0);
    let built = build_bank(options, &mut |done| progress.reached(done));
    drop(progress);
    let bytes = built?.encode(LEFT_OUT * options.accuracy).map_err(Failure::new)?;
    // What is reported is what was stored.
    let stored = BankFile::decode(&bytes).map_err(Failure::new)?;
    write_atomically(output, &bytes).map_err(Failure::new)?;
    console.say(format_args!("built in {:.1} s", started.elapsed().as_secs_f64()));
    report(console, output, &stored);
    Ok(())
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
        "bank": path,
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
