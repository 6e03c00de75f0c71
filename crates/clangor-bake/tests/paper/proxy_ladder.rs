//! \[PROXY\] §5: storage against the tolerance ε of the wavelets, and the loss of accuracy.
//!
//! The fields here are known in closed form at every frequency; the ladder over ellipsoids of the published
//! bank is printed by `cargo run --release -p clangor-validation --bin pan_representation_ladder`.

use crate::exact_fields::{Ball, ball, cross, spectra};
use clangor_bake::reference::{Fit, PanFitError, PanOptions, fit, synthesize};
use clangor_core::reference::pan_representation::PanField;
use clangor_core::reference::pan_representation::directions::Directions;
use clangor_core::reference::pan_representation::pulse::pulse_spectrum;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;

/// R/c \[s\] of the published bank: A = 0.5 m.
const UNIT: f64 = 0.5 / 343.2;

/// h = 0.1 ms, 96 kHz, 2048 samples, N = 2 terms from M = 5 radii, 45 directions.
fn published(tolerance: f64) -> PanOptions {
    PanOptions {
        pulse: 1e-4 / UNIT,
        step: 1.0 / (96_000.0 * UNIT),
        length: 2048,
        terms: 2,
        radii: 5,
        directions: Directions::OCTANT_45,
        fit: Fit::Wavelets { tolerance },
    }
}

fn fitted(balls: &[Ball], options: &PanOptions) -> PanField {
    let wavenumbers = options.wavenumbers();
    fit(options, &|x| spectra(balls, x, &wavenumbers)).expect("valid options")
}

/// Relative L2 error of the pulses of each motion over directions at a distance; 0 for a silent motion.
fn errors(field: &PanField, balls: &[Ball], directions: &[DVec3], distance: f64) -> [f64; RIGID_DOFS] {
    let spacing = std::f64::consts::TAU / (field.length as f64 * field.step);
    let wavenumbers: Vec<f64> = (0..=field.length / 2).map(|m| m as f64 * spacing).collect();
    let pulse: Vec<f64> = wavenumbers.iter().map(|k| pulse_spectrum(*k, field.pulse)).collect();
    let mut sums = [[0.0; 2]; RIGID_DOFS];
    for v in directions {
        let exact = spectra(balls, *v * distance, &wavenumbers);
        for (degree, sum) in sums.iter_mut().enumerate() {
            let reference = synthesize(&exact[degree], &pulse, field.step, field.start);
            let mut z = [0.0; RIGID_DOFS];
            z[degree] = 1.0;
            let response = field.response(&z, *v * distance, f64::INFINITY);
            for (x, r) in response.samples.iter().zip(&reference) {
                sum[0] += (x - r) * (x - r);
                sum[1] += r * r;
            }
        }
    }
    sums.map(|[difference, size]| if size > 1e-20 { (difference / size).sqrt() } else { 0.0 })
}

fn worst(errors: [f64; RIGID_DOFS]) -> f64 {
    errors.into_iter().fold(0.0, f64::max)
}

/// 66 ellipsoids × 45 directions × 6 motions × N = 2 signals × 2048 numbers of 4 bytes are the printed 293
/// MB.
#[test]
fn the_published_bank_has_the_printed_size() {
    let options = published(0.01);
    let bytes = 66 * options.directions.count() * RIGID_DOFS * options.terms * options.length * 4;
    // 291 962 880.
    assert!((bytes as f64 / 293e6 - 1.0).abs() < 0.005, "{bytes}");
}

#[test]
fn a_tolerance_of_one_percent_keeps_five_percent_at_stored_directions() {
    for (name, balls) in [("ball", ball()), ("cross", cross())] {
        let options = published(0.01);
        let field = fitted(&balls, &options);
        let error = worst(errors(&field, &balls, &options.directions.vectors(), 2.0));
        // Seen: 0.9 % and 2.6 %, of which the series with N = 2 accounts for 3e-8 and 2.4 %.
        assert!(error < 0.05, "{name}: {error}");
        let everything = fitted(&balls, &published(0.0));
        let fit_alone = worst(errors(&everything, &balls, &options.directions.vectors(), 2.0));
        assert!(fit_alone < error, "{name}: {fit_alone}");
    }
}

#[test]
fn storage_falls_with_the_tolerance_as_printed() {
    let printed = [26.0, 20.0, 16.0, 12.0, 7.3, 4.5, 2.6];
    let tolerances = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64];
    let balls = cross();
    let fields: Vec<PanField> = tolerances.iter().map(|e| fitted(&balls, &published(*e))).collect();
    let directions = Directions::OCTANT_45.vectors();
    let mut before = 0.0;
    for (field, (tolerance, megabytes)) in fields.iter().zip(tolerances.into_iter().zip(printed)) {
        let ratio = field.bytes() as f64 / fields[0].bytes() as f64;
        let error = worst(errors(field, &balls, &directions[..12], 2.0));
        assert!(error > before, "{tolerance}: {error}");
        before = error;
        // Six balls are not an ellipsoid: the error of the last step is 34 %, that of the others within 15 %.
        assert!((ratio / (megabytes / 26.0) - 1.0).abs() < 0.4, "{tolerance}: {ratio}");
    }
}

/// N = 2 is the complete series of a ball: the truncated SVD fits it at every distance.
#[test]
fn the_fit_of_all_samples_finds_the_two_terms_of_a_ball() {
    let options = PanOptions {
        pulse: 0.5,
        step: 0.05,
        length: 512,
        fit: Fit::TruncatedSvd { truncation: 1e-4 },
        ..published(0.0)
    };
    let field = fitted(&ball(), &options);
    for distance in [2.0, 4.0, 8.0, 100.0] {
        let error = worst(errors(&field, &ball(), &options.directions.vectors(), distance));
        // Residual seen: 2.2e-5 at 100 R, from the truncated singular values.
        assert!(error < 1e-4, "{distance} R: {error}");
    }
}

/// Beyond the radii of the fit, terms of higher order than N = 2 alias into 1/r. \[PAN\] §5 observed it as a
/// delay.
#[test]
fn the_error_grows_outwards_where_the_field_has_more_terms() {
    let options = published(0.0);
    let balls = cross();
    let field = fitted(&balls, &options);
    let directions = options.directions.vectors();
    let [near, middle, far] =
        [2.0, 8.0, 100.0].map(|distance| worst(errors(&field, &balls, &directions, distance)));
    // Seen: 2.4 %, 30 %, 60 %.
    assert!(near < 0.05 && middle > 0.1 && far > middle, "{near} {middle} {far}");
}

#[test]
fn linear_interpolation_between_directions_costs_more_than_the_fit() {
    let balls = cross();
    let between: Vec<DVec3> = (0..40)
        .map(|i| {
            let z = 1.0 - (f64::from(i) + 0.5) / 20.0;
            let a = 2.4 * f64::from(i);
            DVec3::new((1.0 - z * z).sqrt() * a.cos(), (1.0 - z * z).sqrt() * a.sin(), z)
        })
        .collect();
    let error = |directions: Directions| {
        let options = PanOptions { directions, ..published(0.0) };
        worst(errors(&fitted(&balls, &options), &balls, &between, 2.0))
    };
    let octant = error(Directions::OCTANT_45);
    let coarse = error(Directions::Angles { rows: 5, columns: 10 });
    // Seen: 30 % and 69 %.
    assert!(octant < 0.5 * coarse && octant > 0.1, "{octant} {coarse}");
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let good = PanOptions { length: 16, ..published(0.5) };
    let zero = |_| std::array::from_fn(|_| vec![num_complex::Complex64::ZERO; 9]);
    let silent = fit(&good, &zero).expect("a silent field");
    assert!(silent.response(&[1.0; RIGID_DOFS], DVec3::X * 2.0, 1.0).samples.iter().all(|x| *x == 0.0));
    for bad in [
        PanOptions { length: 17, ..good },
        PanOptions { length: 0, ..good },
        PanOptions { length: 1 << 17, ..good },
        PanOptions { terms: 0, ..good },
        PanOptions { terms: 3, radii: 2, ..good },
        PanOptions { pulse: f64::NAN, ..good },
        PanOptions { step: 0.0, ..good },
        PanOptions { directions: Directions::Octant { divisions: 0 }, ..good },
        PanOptions { fit: Fit::Wavelets { tolerance: 1.0 }, ..good },
        PanOptions { fit: Fit::TruncatedSvd { truncation: f64::NAN }, ..good },
    ] {
        assert!(matches!(fit(&bad, &zero), Err(PanFitError::BadOption { .. })), "{bad:?}");
    }
}
