//! \[PAN\] figs. 8 and 9: a bowl pushed along a half-sine of τ = 0.1 ms that begins τ/4 after the first
//! pulse, heard at 8 R between the stored directions.
//!
//! `cargo run --release -p clangor-validation --bin pan_representation_bowl`

use std::f64::consts::TAU;

use clangor_bake::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use clangor_bake::reference::{Fit, PanOptions, fit};
use clangor_core::glam::DVec3;
use clangor_core::reference::pan_representation::directions::Directions;
use clangor_core::shape::Shape;

use clangor_validation::pan_representation::errors::{Push, directions, errors, worst};
use clangor_validation::pan_representation::solved_field::SolvedField;

const SOUND_SPEED: f64 = 343.2;
/// h \[s\] of the bowl in \[PAN\] table 1, and its simulated time \[s\].
const PULSE: f64 = 24.332e-6;
const SIMULATED: f64 = 10e-3;
/// τ \[s\].
const CONTACT: f64 = 1e-4;
const LENGTH: usize = 1024;
const TRUNCATION: f64 = 1e-3;

fn main() {
    let Some(meridian) = Shape::parse("bowl").ok().and_then(|shape| shape.meridian()) else { return };
    let meridian = meridian.about_centre_of_mass();
    let radius = meridian.bounding_radius();
    let unit = radius / SOUND_SPEED;
    let highest = TAU * 0.8 / PULSE * unit;
    let solver_options =
        AxisymmetricOptions { nodes_per_wavelength: 6.0, ..AxisymmetricOptions::new(highest / radius) };
    let solver = AxisymmetricSolver::new(&meridian, DVec3::Z, solver_options);
    let options = |widening: f64, directions: Directions| PanOptions {
        pulse: widening * PULSE / unit,
        step: SIMULATED / LENGTH as f64 / unit,
        length: LENGTH,
        terms: 2,
        radii: 5,
        directions,
        fit: Fit::TruncatedSvd { truncation: TRUNCATION },
    };
    let fine = Directions::Angles { rows: 40, columns: 80 };
    let coarse = Directions::Angles { rows: 5, columns: 10 };
    // Reference field.
    let solved = match SolvedField::new(&solver, &options(1.0, fine), highest, 2) {
        Ok(solved) => solved,
        Err(error) => {
            println!("bowl: {error}");
            return;
        }
    };
    println!("PAN figs. 8, 9: bowl, R = {radius:.4} m, {} solves to κ = {highest:.1}", solved.solves());
    let listeners = directions(40);
    let spectra = |x: DVec3| solved.spectra(x);
    let contact = Push::HalfSine { duration: CONTACT / unit, onset: 0.25 * CONTACT / unit };
    // Only directions near the listeners are used; the others may be zero.
    let zero = solved.spectra(DVec3::Z * 2.0).map(|s| vec![num_complex::Complex64::ZERO; s.len()]);
    let around = |x: DVec3| {
        let near = listeners.iter().any(|l| l.dot(x) > 0.99 * x.length());
        if near { solved.spectra(x) } else { zero.clone() }
    };
    // Fit each representation and report its errors.
    let report = |name: &str, widening: f64, grid: Directions, masked: bool| {
        let options = options(widening, grid);
        let fitted = if masked { fit(&options, &around) } else { fit(&options, &spectra) };
        let Ok(field) = fitted else { return };
        for distance in [4.0, 8.0, 100.0] {
            let e = errors(&field, &spectra, contact, &listeners, distance);
            println!(
                "{name}, {distance} R: translations {:.1} %, rotations {:.1} %; {:.2} MB",
                100.0 * worst(&e[..3]),
                100.0 * worst(&e[3..]),
                field.bytes() as f64 * 1e-6
            );
        }
    };
    report("40 × 80, h", 1.0, fine, true);
    report("5 × 10, h", 1.0, coarse, false);
    report("40 × 80, 2h", 2.0, fine, true);
    report("40 × 80, 4h", 4.0, fine, true);
    report("40 × 80, 8h", 8.0, fine, true);
}
