//! \[PAN\] Table 1: the time to bake each of its nine models, and the size of the result.
//!
//! `cargo run --release -p clangor-validation --bin pan_table_1 [-- NAME …] [--frequency HZ]`
//!
//! Times are CPU time of the process over two cores; the paper's are hours of eight cores for the simulation
//! and the fit.

use std::ops::ControlFlow;

use clangor_bake::acceleration::BakeOptions;
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_pipeline::stages::sound_models::{AccelerationBake, SoundModelRequest, bake_model};
use clangor_validation::cpu_time::cpu_time;

/// Name, shape, accuracy, and the printed values of \[PAN\]: minutes of simulation and fit, megabytes at 40 ×
/// 80 and 5 × 10.
const MODELS: &[(&str, &str, f64, f64, f64, f64)] = &[
    ("ball", "sphere:0.0075", 1e-4, 6.0 + 57.7 / 60.0, 23.5, 0.42),
    ("bowl", "bowl", 1e-2, 42.0 + 35.0 / 60.0, 133.0, 2.15),
    ("coin", "coin", 3e-3, 141.0 + 21.3 / 60.0, 35.0, 0.6),
    ("dice", "die:0.015x0.0005", 3e-3, 17.0 + 45.3 / 60.0, 35.0, 0.6),
    ("rounded dice", "die", 3e-3, 17.0 + 2.2 / 60.0, 35.0, 0.6),
    ("key", "key", 1e-2, 64.0 + 25.4 / 60.0, 136.0, 2.3),
    ("key ring", "ring", 1e-2, 40.0 + 57.0 / 60.0, 46.0, 0.8),
    ("plate", "plate", 1e-2, 54.0 + 7.1 / 60.0, 108.0, 1.8),
    ("mug", "mug", 2e-2, 398.0, 1131.0, 19.0),
];

fn main() {
    let mut wanted: Vec<String> = std::env::args().skip(1).collect();
    let mut frequency = 20_000.0;
    if let Some(at) = wanted.iter().position(|a| a == "--frequency") {
        frequency = wanted[at + 1].parse().expect("a frequency in hertz");
        wanted.drain(at..at + 2);
    }
    println!(
        "| model | accuracy | CPU / 2 | solver | unknowns | solves | held-out error | size | \
         PAN: time · 40 × 80 · 5 × 10 |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for &(name, text, accuracy, minutes, fine, coarse) in MODELS {
        if !wanted.is_empty() && !wanted.iter().any(|w| w == name) {
            continue;
        }
        let (surface, mass) = Shape::parse(text).expect("a shape").surface().expect("a solid");
        let options = BakeOptions::new(std::f64::consts::TAU * frequency / Medium::AIR.sound_speed, accuracy);
        let request =
            SoundModelRequest::new(text, &surface, mass, AccelerationBake(options)).expect("a body");
        let start = cpu_time();
        match bake_model(&request, &mut |_| ControlFlow::Continue(())) {
            Ok(model) => {
                let seconds = 0.5 * (cpu_time() - start);
                let bytes = model.encode().expect("a sound model").len();
                let origin = &model.origin;
                println!(
                    "| {name} `{text}` | {accuracy:.0e} | {seconds:.2} s | {} | {} | {} | {:.1e} | \
                     {:.0} kB | {minutes:.0} min · {fine} MB · {coarse} MB |",
                    origin.method,
                    origin.unknowns,
                    origin.solves,
                    origin.held_out_error,
                    bytes as f64 / 1e3
                );
                origin.warnings.iter().for_each(|w| println!("warning: {w}"));
            }
            Err(error) => println!("| {name} `{text}` | {accuracy:.0e} | {error} |"),
        }
    }
}
