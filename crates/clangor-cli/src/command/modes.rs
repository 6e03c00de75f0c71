//! `clangor modes`: at which frequencies a free body rings, for how long, and how sure that is.

use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

use clangor_bake::acceleration::BakeOptions;
use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::modal_analysis::{
    ModalAnalysis, ModalAnalysisError, ModalAnalysisOptions, ModalAnalysisProgress, modal_analysis,
    modal_analysis_and_system,
};
use clangor_core::material::Material;
use clangor_pipeline::formats::atomic_file::AtomicFile;
use clangor_pipeline::session::named_body::preset;
use clangor_pipeline::stages::load::load_named;
use clangor_pipeline::stages::sound_models::{AccelerationBake, SoundModelRequest};
use serde_json::json;

use crate::arguments::Modes;
use crate::console::{Console, counted, four_digits};
use crate::failure::Failure;

pub(crate) fn run(options: &Modes, console: &Console) -> Result<(), Failure> {
    let body = &*options.body.to_string_lossy();
    let material = material(options)?;
    let constants = ElasticConstants::of(&material).map_err(|e| cannot_ring(body, &e))?;
    let loaded = load_named(&options.body, options.scale).map_err(|e| cannot_ring(body, &e))?;
    loaded.warnings.iter().for_each(|warning| console.warn(format_args!("\"{body}\": {warning}")));
    // How a body is recognised does not depend on the band.
    let part = AccelerationBake(BakeOptions::new(1.0, 0.01));
    let request = SoundModelRequest::new(body, &loaded.surface, loaded.mass, part)
        .map_err(|e| cannot_ring(body, &e))?;
    if let Some(folder) = options.export.as_deref().filter(|folder| !folder.is_dir()) {
        return Err(Failure::new(format_args!("there is no folder {}", folder.display())));
    }
    let started = Instant::now();
    let progress = console.progress("find modes", 1.0);
    let mut on_progress = |p: &ModalAnalysisProgress| progress.reached(p.done);
    let settings = ModalAnalysisOptions {
        accuracy: options.accuracy,
        most_nodes: options.max_nodes,
        ..ModalAnalysisOptions::to(options.max_frequency)
    };
    // The matrices are of the whole body, which is then solved without its mirror planes.
    let found = match options.export {
        Some(_) => modal_analysis_and_system(request.geometry(), &constants, &settings, &mut on_progress),
        None => modal_analysis(request.geometry(), &constants, &settings, &mut on_progress)
            .map(|found| (found, None)),
    };
    let (found, system) = found.map_err(|error| match error {
        ModalAnalysisError::Interrupted => Failure::Interrupted,
        error => cannot_ring(body, &error),
    })?;
    drop(progress);
    let seconds = started.elapsed().as_secs_f64();
    for warning in &found.warnings {
        console.warn(format_args!("\"{body}\": {warning}"));
    }
    if let Some(folder) = &options.export {
        let system = system.ok_or_else(|| {
            Failure::new(format_args!("\"{body}\" is solved by its section and has no matrices to export"))
        })?;
        export(&system, folder)?;
    }
    report(&found, &material, seconds, options, console);
    Ok(())
}

fn cannot_ring(body: &str, error: &dyn std::fmt::Display) -> Failure {
    Failure::new(format_args!("\"{body}\": {error}"))
}

fn material(options: &Modes) -> Result<Material, Failure> {
    let mut material = preset(&options.material)?;
    material.density = options.density.unwrap_or(material.density);
    material.youngs_modulus = options.youngs_modulus.unwrap_or(material.youngs_modulus);
    material.poisson_ratio = options.poisson_ratio.unwrap_or(material.poisson_ratio);
    Ok(material)
}

fn report(found: &ModalAnalysis, material: &Material, seconds: f64, options: &Modes, console: &Console) {
    let known = found.modes.iter().all(|m| m.mesh_error.is_finite());
    console.say(format_args!(
        "{:>5} {:>13} {:>11} {:>14} {:>9}",
        "mode", "frequency", "mesh error", "damping ratio", "T60"
    ));
    for (k, mode) in found.modes.iter().enumerate() {
        let error = if known { format!("{:.2} %", 100.0 * mode.mesh_error) } else { "unknown".into() };
        console.say(format_args!(
            "{:>5} {:>10.1} Hz {error:>11} {:>14} {:>7} s",
            k + 1,
            mode.frequency,
            four_digits(material.damping.damping_ratio(mode.frequency)),
            four_digits(material.damping.t60(mode.frequency)),
        ));
    }
    console.say(format_args!(
        "{} below {} Hz, all of them by count; {} on {} nodes, residual {:.0e}, {seconds:.2} s",
        counted(found.modes.len(), "mode", "modes"),
        options.max_frequency,
        found.method,
        found.nodes,
        found.residual
    ));
    let of = |value: &dyn Fn(f64) -> f64| found.modes.iter().map(|m| value(m.frequency)).collect::<Vec<_>>();
    console.json(&json!({
        "frequencies_hz": of(&|f| f),
        "damping_ratios": of(&|f| material.damping.damping_ratio(f)),
        "t60_s": of(&|f| material.damping.t60(f)),
        // Null where no second mesh was possible.
        "convergence": found.modes.iter().map(|m| m.mesh_error).collect::<Vec<_>>(),
        // A spectrum with gaps is an error, and never comes here.
        "complete": true,
        "nodes": found.nodes,
        "method": found.method,
        "residual": found.residual,
        "max_frequency_hz": found.max_frequency,
        "seconds": seconds,
        "warnings": found.warnings,
    }));
}

/// Both matrices, their lower halves: <https://math.nist.gov/MatrixMarket/formats.html>.
fn export(system: &ElasticSystem, folder: &Path) -> Result<(), Failure> {
    let size = 3 * system.node_count();
    let write = |name: &str, of: &dyn Fn((usize, usize, f64, f64)) -> (usize, usize, f64)| {
        let entries = || system.entries().map(of).filter(|(_, _, value)| *value != 0.0);
        let mut file = AtomicFile::create(&folder.join(name)).map_err(Failure::new)?;
        let mut text = BufWriter::new(&mut file);
        let mut lines = || -> std::io::Result<()> {
            writeln!(text, "%%MatrixMarket matrix coordinate real symmetric")?;
            writeln!(text, "{size} {size} {}", entries().count())?;
            for (row, column, value) in entries() {
                writeln!(text, "{} {} {value:e}", row + 1, column + 1)?;
            }
            text.flush()
        };
        lines()
            .map_err(|e| Failure::new(format_args!("cannot write {}: {e}", folder.join(name).display())))?;
        drop(text);
        file.commit().map_err(Failure::new)
    };
    write("stiffness.mtx", &|(row, column, k, _)| (row, column, k))?;
    write("mass.mtx", &|(row, column, _, m)| (row, column, m))
}
