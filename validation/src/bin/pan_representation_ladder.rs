//! \[PROXY\] §5: storage of the ellipsoid bank against the tolerance ε, and the limits of the error at ε =
//! 0.01.
//!
//! `cargo run --release -p clangor-validation --bin pan_representation_ladder -- [bank]`;
//! `only=ACROSS:ALONG` chooses spheroids.
//!
//! The paper's pulse needs kA = 80, which is solved for eight bodies of revolution. Up to kA = 20, where the
//! pulse is four times as long for the same body, the program's bank has all 66 ellipsoids and shows how well
//! the eight represent them.

use std::collections::BTreeMap;

use clangor_bake::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use clangor_bake::reference::{FieldSampler, Fit, PanOptions, fit, fit_at, fit_radii};
use clangor_core::geometry::meridian::Meridian;
use clangor_core::glam::DVec3;
use clangor_core::reference::pan_representation::PanField;
use clangor_core::reference::pan_representation::directions::Directions;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use clangor_core::sound_model::files::ellipsoid_bank_file::BankFile;
use num_complex::Complex64;
use rayon::prelude::*;

use clangor_validation::pan_representation::errors::{Push, directions, errors, pulse_errors, worst};
use clangor_validation::pan_representation::solved_field::SolvedField;

/// A = 0.5 m over the speed of sound \[s\].
const UNIT: f64 = 0.5 / 343.2;
/// ε and the printed sizes \[MB\] of the bank of 66.
const PRINTED: [(f64, f64); 7] =
    [(0.01, 26.0), (0.02, 20.0), (0.04, 16.0), (0.08, 12.0), (0.16, 7.3), (0.32, 4.5), (0.64, 2.6)];
/// Highest κ solved: at 80 the pulse of 0.1 ms is at 1 % of its peak.
const HIGHEST: f64 = 80.0;
/// Semi-axes across and along the axis of revolution, of the values of the bank, and the number of its 66
/// ellipsoids that each represents: those with the nearest shortest axis, shared by the flat and the long.
const SPHEROIDS: [(f64, f64, f64); 8] = [
    (1.0, 1.0, 2.0),
    (1.0, 0.81, 8.0),
    (1.0, 0.525, 9.0),
    (1.0, 0.24, 11.0),
    (1.0, 0.05, 8.0),
    (0.525, 1.0, 9.0),
    (0.24, 1.0, 11.0),
    (0.05, 1.0, 8.0),
];
/// Factor on the pulse and the samples for the bank that ends at kA = 20.
const STRETCH: f64 = 4.0;
/// Radii of further fits, besides those of \[PAN\].
const OTHER_RADII: [(&str, [f64; 5]); 4] = [
    ("2 to 2.5 R", [2.0, 2.12, 2.24, 2.37, 2.5]),
    ("2 to 3 R", [2.0, 2.22, 2.45, 2.71, 3.0]),
    ("2 to 4 R, those near 2 R denser", [2.0, 2.0, 2.0, 2.83, 4.0]),
    ("2 to 16 R", [2.0, 3.36, 5.66, 9.51, 16.0]),
];

type Spectra = [Vec<Complex64>; RIGID_DOFS];

fn options(tolerance: f64, stretch: f64) -> PanOptions {
    PanOptions {
        pulse: stretch * 1e-4 / UNIT,
        step: stretch / (96_000.0 * UNIT),
        length: 2048,
        terms: 2,
        radii: 5,
        directions: Directions::OCTANT_45,
        fit: Fit::Wavelets { tolerance },
    }
}

/// Cache of a field at the points of the fit, shared by seven tolerances.
struct Remembered<'a> {
    points: BTreeMap<[u64; 3], Spectra>,
    field: &'a (dyn Fn(DVec3) -> Spectra + Sync),
}

impl<'a> Remembered<'a> {
    fn new(field: &'a (dyn Fn(DVec3) -> Spectra + Sync)) -> Self {
        let places: Vec<DVec3> = Directions::OCTANT_45
            .vectors()
            .into_iter()
            .flat_map(|v| fit_radii(5).into_iter().map(move |r| v * r))
            .collect();
        let points = places.into_par_iter().map(|x| (key(x), field(x))).collect();
        Remembered { points, field }
    }

    fn at(&self, x: DVec3) -> Spectra {
        self.points.get(&key(x)).cloned().unwrap_or_else(|| (self.field)(x))
    }
}

fn key(x: DVec3) -> [u64; 3] {
    x.to_array().map(f64::to_bits)
}

fn main() {
    if std::env::args().any(|a| a == "bank") {
        print_bank();
    } else {
        print_spheroids();
    }
}

/// Prints the ladder of the spheroids; with `only=ACROSS:ALONG` among the arguments, of these bodies only.
fn print_spheroids() {
    println!("PROXY ladder: A = 0.5 m, h = 0.1 ms, 96 kHz, 2048 samples, 45 directions, N = 2, M = 5");
    let only: Vec<String> =
        std::env::args().filter_map(|a| a.strip_prefix("only=").map(str::to_owned)).collect();
    let mut totals = [0.0; PRINTED.len()];
    for (across, along, members) in SPHEROIDS {
        let name = format!("{across}:{along}");
        if !only.is_empty() && !only.contains(&name) {
            continue;
        }
        let Ok(meridian) = Meridian::spheroid(across, along) else { continue };
        let solver_options =
            AxisymmetricOptions { nodes_per_wavelength: 6.0, ..AxisymmetricOptions::new(HIGHEST) };
        let solver = AxisymmetricSolver::new(&meridian, DVec3::Z, solver_options);
        let solved = match SolvedField::new(&solver, &options(0.01, 1.0), HIGHEST, 2) {
            Ok(solved) => solved,
            Err(error) => {
                println!("{name}: {error}");
                continue;
            }
        };
        println!("{name} ({} solves)", solved.solves());
        let field = |x: DVec3| solved.spectra(x);
        let remembered = Remembered::new(&field);
        let bytes = body(&remembered);
        totals.iter_mut().zip(bytes).for_each(|(t, b)| *t += members * b as f64);
        series(&remembered);
    }
    if only.is_empty() {
        println!("eight bodies of revolution, kA to 80, for 66:");
        table(&totals);
    }
}

/// Errors at the stored directions for every ε; bytes.
fn body(field: &Remembered) -> Vec<usize> {
    let spectra = |x: DVec3| field.at(x);
    let stored = Directions::OCTANT_45.vectors();
    let (mut own, mut level, mut bytes) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (tolerance, _)) in PRINTED.into_iter().enumerate() {
        let Ok(fitted) = fit(&options(tolerance, 1.0), &spectra) else { continue };
        let found = pulse_errors(&fitted, &spectra, &stored, 2.0);
        own.push(format!("{:.1}", 100.0 * worst(&found.own)));
        level.push(format!("{:.1}", 100.0 * found.level.into_iter().fold(0.0, f64::max)));
        bytes.push(fitted.bytes());
        if i == 0 {
            let each: Vec<String> = (0..RIGID_DOFS)
                .map(|d| {
                    let own = found.own[d].map_or("silent".into(), |e| format!("{:.1} %", 100.0 * e));
                    format!("{own} of {:.2}", found.loudness[d])
                })
                .collect();
            let between = worst(&errors(&fitted, &spectra, Push::Pulse, &directions(40), 2.0));
            println!(
                "  ε = 0.01, 2 R: six motions, error of size (1 is the loudest): {}; between directions \
                 {:.1} %",
                each.join(", "),
                100.0 * between
            );
        }
    }
    println!("  worst motion against itself [%]: {}", own.join(" "));
    println!("  worst against the loudest [%]: {}", level.join(" "));
    let relative: Vec<String> = bytes.iter().map(|b| format!("{:.3}", *b as f64 / bytes[0] as f64)).collect();
    println!("  bytes {bytes:?}, relative {}", relative.join(" "));
    bytes
}

/// Error of the series alone, ε = 0: worst motion relative to itself, and to the strongest.
fn series(field: &Remembered) {
    let spectra = |x: DVec3| field.at(x);
    let stored = Directions::OCTANT_45.vectors();
    let report = |name: &str, fitted: &PanField| {
        let at: Vec<String> = [2.0, 2.0 * 2.0_f64.sqrt(), 4.0, 16.0, 100.0]
            .into_iter()
            .map(|distance| {
                let found = pulse_errors(fitted, &spectra, &stored, distance);
                let level = found.level.into_iter().fold(0.0, f64::max);
                format!("{:.2} ({:.2})", 100.0 * worst(&found.own), 100.0 * level)
            })
            .collect();
        println!("  {name}: at 2, 2.83, 4, 16, 100 R [%]: {}", at.join(", "));
    };
    for (tolerance, terms) in [(0.0, 2), (0.0, 3), (0.0, 4), (0.01, 3)] {
        if let Ok(fitted) = fit(&PanOptions { terms, ..options(tolerance, 1.0) }, &spectra) {
            report(&format!("ε = {tolerance}, N = {terms}"), &fitted);
        }
    }
    for (name, radii) in OTHER_RADII {
        for tolerance in [0.0, 0.01] {
            if let Ok(fitted) = fit_at(&options(tolerance, 1.0), &radii, &spectra) {
                report(&format!("ε = {tolerance}, N = 2, radii {name}"), &fitted);
            }
        }
    }
}

fn table(totals: &[f64]) {
    for ((tolerance, megabytes), total) in PRINTED.into_iter().zip(totals) {
        let ratio = total / totals[0];
        println!(
            "  ε = {tolerance}: {:.2} MB for 66; relative {ratio:.3}, printed {:.3} ({:+.1} %)",
            total * 1e-6,
            megabytes / 26.0,
            100.0 * (ratio * 26.0 / megabytes - 1.0),
        );
    }
}

/// Prints the ladder for all 66 ellipsoids to kA = 20, once from all and once from the eight spheroids.
fn print_bank() {
    let decoded = BankFile::decode(include_bytes!("../../../data/ellipsoid_bank.safetensors"));
    let Ok(file) = decoded else { return };
    let (mut all, mut eight) = ([0.0; PRINTED.len()], [0.0; PRINTED.len()]);
    for entry in file.bank.entries() {
        let sampler = FieldSampler::new(&entry.field, &options(0.01, STRETCH).wavenumbers());
        let field = |x: DVec3| sampler.spectra(x);
        let remembered = Remembered::new(&field);
        let spectra = |x: DVec3| remembered.at(x);
        // The bank has A ≥ B ≥ C along x, y, z: 1 : 1 : C is flat, 1 : B : B long.
        let same = |v: f64, w: f64| (v - w).abs() < 1e-6;
        let members = SPHEROIDS.iter().find(|(across, along, _)| {
            if *along < 1.0 {
                same(entry.b, 1.0) && same(entry.c, *along)
            } else {
                same(entry.b, *across) && same(entry.c, *across)
            }
        });
        for (i, (tolerance, _)) in PRINTED.into_iter().enumerate() {
            let Ok(fitted) = fit(&options(tolerance, STRETCH), &spectra) else { continue };
            let bytes = fitted.bytes() as f64;
            all[i] += bytes;
            eight[i] += members.map_or(0.0, |m| m.2 * bytes);
        }
    }
    println!("all 66, kA to 20:");
    table(&all);
    println!("the eight for 66, kA to 20:");
    table(&eight);
}
