//! \[PROXY\] §5: storage of the ellipsoid bank against the tolerance ε.

use clangor::geometry::meridian::Meridian;
use clangor::model::published::PublishedField;
use clangor::model::published::directions::Directions;
use clangor::model::published::signals::Signals;
use clangor_bake::helmholtz::revolution::{RevolutionOptions, RevolutionSolver};
use clangor_bake::published::{Fit, PublishedOptions, fit};
use glam::DVec3;

use crate::measure::{Push, directions, errors, worst};
use crate::solved_field::SolvedField;

/// A = 0.5 m over the speed of sound \[s\].
const UNIT: f64 = 0.5 / 343.2;
/// ε and the printed sizes [MB] of the bank of 66.
const PRINTED: [(f64, f64); 7] =
    [(0.01, 26.0), (0.02, 20.0), (0.04, 16.0), (0.08, 12.0), (0.16, 7.3), (0.32, 4.5), (0.64, 2.6)];
/// Highest κ solved: at 80 the pulse of 0.1 ms is at 1 % of its peak.
const HIGHEST: f64 = 80.0;
/// Semi-axes across and along the axis of revolution, of the values of the bank, and for how many of its 66 ellipsoids each
/// stands: those with the nearest shortest axis, shared by the flat and the long.
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

fn options(tolerance: f64) -> PublishedOptions {
    PublishedOptions {
        pulse: 1e-4 / UNIT,
        step: 1.0 / (96_000.0 * UNIT),
        length: 2048,
        terms: 2,
        radii: 5,
        directions: Directions::OCTANT_45,
        fit: Fit::Wavelets { tolerance },
    }
}

/// Prints the ladder.
pub(crate) fn print() {
    println!("PROXY ladder: A = 0.5 m, h = 0.1 ms, 96 kHz, 2048 samples, 45 directions, N = 2, M = 5");
    let mut totals = [0.0; PRINTED.len()];
    let mut entries = [0.0; PRINTED.len()];
    for (across, along, members) in SPHEROIDS {
        let Ok(meridian) = Meridian::spheroid(across, along) else { continue };
        let solver_options =
            RevolutionOptions { nodes_per_wavelength: 6.0, ..RevolutionOptions::new(HIGHEST) };
        let solver = RevolutionSolver::new(&meridian, DVec3::Z, solver_options);
        let solved = match SolvedField::new(&solver, &options(0.01), HIGHEST, 2) {
            Ok(solved) => solved,
            Err(error) => {
                println!("{across} : {along}: {error}");
                continue;
            }
        };
        let spectra = |x: DVec3| solved.spectra(x);
        let ladder: Vec<PublishedField> =
            PRINTED.iter().filter_map(|(e, _)| fit(&options(*e), &spectra).ok()).collect();
        let stored = Directions::OCTANT_45.vectors();
        let at_stored: Vec<String> = ladder
            .iter()
            .map(|f| format!("{:.1}", 100.0 * worst(&errors(f, &spectra, Push::Pulse, &stored[..9], 2.0))))
            .collect();
        let between = worst(&errors(&ladder[0], &spectra, Push::Pulse, &directions(40), 2.0));
        let bytes: Vec<usize> = ladder.iter().map(PublishedField::bytes).collect();
        for (i, field) in ladder.iter().enumerate() {
            totals[i] += members * field.bytes() as f64;
            if let Signals::Wavelets(sparse) = &field.signals {
                entries[i] += members * sparse.places.len() as f64;
            }
        }
        println!(
            "{across} : {along} ({} solves): bytes {bytes:?}; worst motion at stored directions, 2 R [%]: {}; between \
             directions at ε = 0.01: {:.1} %",
            solved.solves(),
            at_stored.join(" "),
            100.0 * between
        );
    }
    for (i, (tolerance, megabytes)) in PRINTED.into_iter().enumerate() {
        let ratio = totals[i] / totals[0];
        println!(
            "ε = {tolerance}: {:.2} MB for 66; relative {ratio:.3}, printed {:.3} ({:+.0} %); entries alone {:.3}",
            totals[i] * 1e-6,
            megabytes / 26.0,
            100.0 * (ratio * 26.0 / megabytes - 1.0),
            entries[i] / entries[0],
        );
    }
}
