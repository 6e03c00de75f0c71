//! Adaptive frequencies: solve, fit, test where the fit is least certain, add the tested samples.
//!
//! The fit approximates the pressure without e^{−s|x|} at points on three spheres about the body: near,
//! middle and far. It covers all six motions at once. Errors are relative to the strongest motion at each
//! sphere and frequency. A test solves at frequencies that the fit has not used: the error there is the
//! evidence, and the new samples join the fit. With many resonances, [fits of each
//! motion](super::motion_fits) need fewer solves.

use std::ops::ControlFlow;

use clangor_core::math::radial::outgoing;
use clangor_core::math::spherical_harmonics::solid_harmonics;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use super::motion_fits::{MotionFits, doubt, kept_nodes, peaks_between};
use super::sketch::sketched;
use super::{BakeError, BakeProgress, Resumption, SolvedFrequency};
use crate::fitting::comparison::directions;
use crate::fitting::rational::{
    FunctionSample, NestedFits, RationalFit, error_at, fit_from, fit_nested, poles, residues,
};
use crate::radiation::{RadiationSample, RadiationSolver};

/// Distances, in bounding radii, at which the field is fitted.
const SPHERES: [f64; 3] = [1.2, 3.0, 100.0];
/// Directions on each.
const DIRECTIONS: usize = 24;
/// Lowest κ solved: below it every field equals its limit to 1e-4.
const LOWEST: f64 = 0.02;

/// Settings of the search for frequencies.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Band {
    /// Highest κ = kR.
    pub(super) highest: f64,
    /// Spacing of the first samples in κ.
    pub(super) spacing: f64,
    /// κ above the highest that are sampled too, ascending.
    pub(super) above: Vec<f64>,
    /// Order of the multipoles.
    pub(super) order: usize,
    /// Error of the fit that is accepted.
    pub(super) tolerance: f64,
    /// Most solves.
    pub(super) most_solves: usize,
}

/// The samples and the fit through them.
pub(super) struct FittedBand {
    /// All solves, and samples that stand for more, in order of frequency; those in the fit are complete.
    pub(super) samples: Vec<RadiationSample>,
    /// Frequencies solved.
    pub(super) solves: usize,
    /// The fit.
    pub(super) fit: RationalFit,
    /// Largest error of the last fit but one at held-out frequencies.
    pub(super) held_out: f64,
    /// Time \[R/c\] after which the response to a step of acceleration has decayed.
    pub(super) ring_time: f64,
}

/// Most fits after the first one of all motions together.
const MOST_REFITS: usize = 4;
/// Error of the common fit in that of the fits of each motion, where these miss the tolerance.
const COMMON_SHARE: f64 = 0.1;
/// Samples from which on motions are also fitted by themselves.
const MANY: usize = 40;
/// Samples up to which all motions are also fitted together: a matrix of 0.9 GB.
const MOST_TOGETHER: usize = 256;

/// Solves and fits until frequencies held out are predicted to the tolerance.
pub(super) fn solve_band(
    solver: &dyn RadiationSolver,
    band: &Band,
    resumption: Resumption<'_>,
    progress: &mut dyn FnMut(&BakeProgress) -> ControlFlow<()>,
) -> Result<FittedBand, BakeError> {
    let mut solved = Solved::new(solver, band.order, resumption);
    let radius = solver.reference_radius();
    let mut pending = first_frequencies(band);
    let planned = pending.len() + TESTS;
    let mut samples: Vec<RadiationSample> = Vec::new();
    let mut functions: Vec<FunctionSample> = Vec::new();
    let mut last: Option<NestedFits> = None;
    let mut last_motions: Option<MotionFits> = None;
    let tolerance = 0.3 * band.tolerance;
    loop {
        // Solve the pending frequencies, batch by batch.
        for batch in pending.chunks(BATCH) {
            let planned = (samples.len() + pending.len() + TESTS).max(band.most_solves.min(planned));
            let done = samples.len() as f64 / planned as f64;
            if progress(&BakeProgress { done, stage: "solving for the field" }).is_break() {
                return Err(BakeError::Interrupted);
            }
            let wavenumbers: Vec<f64> = batch.iter().map(|kappa| kappa / radius).collect();
            samples.extend(solved.at(&wavenumbers)?);
        }
        // Held-out errors: the previous fits evaluated at the new samples.
        let tested = samples[functions.len()..].iter().map(|s| functions_of(s, radius)).collect::<Vec<_>>();
        let worst = |error: &dyn Fn(&FunctionSample) -> f64| tested.iter().map(error).fold(0.0, f64::max);
        let held_out = last.as_ref().map_or(f64::INFINITY, |NestedFits { best, .. }| {
            worst(&|t| error_at(&functions, &best.support, &best.nodes, t))
        });
        let by_motion = last_motions.as_ref().map_or(f64::INFINITY, |fits| worst(&|t| fits.error_at(t)));
        // Rational fit of all samples, and of each motion where there are many.
        functions.extend(tested);
        let now = (functions.len() <= MOST_TOGETHER).then(|| {
            fit_from(&functions, known_nodes(last.as_ref(), functions.len()), tolerance, functions.len())
        });
        let used_up = functions.len() + TESTS > band.most_solves;
        // Accept once a held-out error meets the tolerance or the solves are used up.
        let is_met = last.is_some() && (held_out <= band.tolerance || used_up && held_out <= by_motion);
        if let Some(now) = now.as_ref().filter(|_| is_met) {
            // A fit that went on from another one may have more nodes than it needs.
            let fit = match functions.len() < MANY {
                true => now.best.clone(),
                false => fit_nested(&functions, tolerance, functions.len()).best,
            };
            let ring_time = ring_time(&functions, &fit, band.highest);
            let order = ascending(&functions);
            let solves = samples.len();
            let fit = renumbered(fit, &order);
            return Ok(FittedBand { samples: reordered(samples, &order), fit, solves, held_out, ring_time });
        }
        let motions =
            (functions.len() >= MANY).then(|| MotionFits::new(&functions, tolerance, last_motions.as_ref()));
        if let Some(fits) = motions.as_ref().filter(|_| by_motion <= band.tolerance || used_up) {
            return Ok(common_fit(fits, &samples, (radius, band.highest, tolerance), by_motion));
        }
        // Next test frequencies: where the fits are least certain.
        let left = band.most_solves.saturating_sub(functions.len());
        pending = match &motions {
            Some(fits) => least_certain(&functions, left.clamp(TESTS, TESTS_OF_MANY), &|s| fits.doubt(s)),
            None => now.as_ref().map_or_else(Vec::new, |now| {
                least_certain(&functions, TESTS, &|s| doubt(&functions, now, s))
            }),
        };
        last = now;
        last_motions = motions;
    }
}

/// Nodes of the fit to the samples before, from which that to so many starts.
fn known_nodes(last: Option<&NestedFits>, samples: usize) -> &[usize] {
    last.filter(|_| samples >= MANY).map_or(&[], kept_nodes)
}

/// Initial κ: uniform, two near zero, and those above the highest.
fn first_frequencies(band: &Band) -> Vec<f64> {
    let steps = (band.highest / band.spacing).ceil().max(3.0) as usize;
    let mut kappas: Vec<f64> = (0..=steps).map(|k| band.highest * k as f64 / steps as f64).collect();
    kappas[0] = LOWEST.min(0.1 * band.highest);
    // At a distance, low frequencies consist of the first two orders only. One more sample keeps them
    // accurate.
    kappas.insert(1, (0.3 * kappas[1]).max(2.0 * kappas[0]));
    kappas.extend(&band.above);
    kappas
}

/// One fit of all motions, to samples that the fits of each make.
fn common_fit(
    motions: &MotionFits,
    solved: &[RadiationSample],
    (radius, highest, tolerance): (f64, f64, f64),
    held_out: f64,
) -> FittedBand {
    // No closer than the fits of the motions are themselves: the rest would be poles of their errors.
    let tolerance = tolerance.max(COMMON_SHARE * held_out);
    let mut samples = motions.resampled(solved, radius);
    let mut functions: Vec<FunctionSample> = samples.par_iter().map(|s| functions_of(s, radius)).collect();
    // Several for each node, so that sums of the functions tell the nodes.
    let mut sums: Vec<FunctionSample> = functions.iter().map(sketched).collect();
    let mut fits = fit_nested(&sums, tolerance, sums.len());
    // Its own poles between the samples made are tested by samples there.
    for _ in 0..MOST_REFITS {
        let fit = &fits.best;
        let added: Vec<RadiationSample> = peaks_between(&functions, fit, tolerance)
            .into_iter()
            .map(|kappa| motions.sample_at(kappa, solved, radius))
            .filter(|sample| {
                let at = functions_of(sample, radius);
                error_at(&functions, &fit.support, &fit.nodes, &at) > tolerance
            })
            .collect();
        if added.is_empty() {
            break;
        }
        functions.extend(added.iter().map(|sample| functions_of(sample, radius)));
        sums.extend(functions[sums.len()..].iter().map(sketched));
        samples.extend(added);
        fits = fit_from(&sums, kept_nodes(&fits), tolerance, sums.len());
    }
    let fit = fits.best;
    for i in &fit.support {
        motions.add_surface(&mut samples[*i], solved, radius);
    }
    let ring_time = ring_time(&functions, &fit, highest);
    let order = ascending(&functions);
    let held_out = held_out.max(fit.error);
    let fit = renumbered(fit, &order);
    FittedBand { samples: reordered(samples, &order), fit, solves: solved.len(), held_out, ring_time }
}

/// Solutions, of this call or an earlier one.
struct Solved<'s, 'k> {
    solver: &'s dyn RadiationSolver,
    order: usize,
    /// In the order of the requests.
    all: Vec<SolvedFrequency>,
    keep: &'k mut dyn FnMut(&[SolvedFrequency]),
}

impl<'s, 'k> Solved<'s, 'k> {
    fn new(solver: &'s dyn RadiationSolver, order: usize, resumption: Resumption<'k>) -> Self {
        let Resumption { solved: mut all, keep } = resumption;
        let points = solver.surface().map_or(0, |surface| surface.vertices.len());
        all.retain(|SolvedFrequency { sample, .. }| {
            sample.coefficients.iter().all(|c| c.len() == (order + 1).pow(2))
                && sample.surface_pressure.len() == points
        });
        Solved { solver, order, all, keep }
    }

    /// The samples at these wavenumbers, stored or solved now. A batch is complete or absent.
    fn at(&mut self, wavenumbers: &[f64]) -> Result<Vec<RadiationSample>, BakeError> {
        let known = |k: &f64| self.all.iter().find(|s| s.asked.to_bits() == k.to_bits());
        if let Some(samples) = wavenumbers.iter().map(|k| known(k).map(|s| s.sample.clone())).collect() {
            return Ok(samples);
        }
        let samples = self.solver.solve(wavenumbers, self.order)?;
        let now = wavenumbers.iter().zip(&samples);
        self.all.extend(now.map(|(k, sample)| SolvedFrequency { asked: *k, sample: sample.clone() }));
        (self.keep)(&self.all);
        Ok(samples)
    }
}

/// Solves handed to the solver at once.
const BATCH: usize = 8;
/// Frequencies of a test.
const TESTS: usize = 4;
/// The same where motions are fitted by themselves: as many as a solver shares work between.
const TESTS_OF_MANY: usize = BATCH;

/// κ of the midpoints between samples with the largest `doubt`, at `most` so many.
fn least_certain(
    functions: &[FunctionSample],
    most: usize,
    doubt: &(dyn Fn(Complex64) -> f64 + Sync),
) -> Vec<f64> {
    let mut kappas: Vec<f64> = functions.iter().map(|f| f.s.im).collect();
    kappas.sort_by(f64::total_cmp);
    let mut gaps: Vec<(f64, f64)> = kappas
        .par_windows(2)
        .map(|pair| {
            let kappa = 0.5 * (pair[0] + pair[1]);
            let s = Complex64::new(functions[0].s.re, kappa);
            // Where both fits agree, wide gaps are less certain than narrow ones.
            (doubt(s) + 1e-9 * (pair[1] - pair[0]), kappa)
        })
        .collect();
    gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<f64> = gaps.iter().take(most).map(|g| g.1).collect();
    chosen.sort_by(f64::total_cmp);
    chosen
}

/// Time \[R/c\] until the poles of the band have decayed by 100 dB, each from its own strength.
fn ring_time(functions: &[FunctionSample], fit: &RationalFit, highest: f64) -> f64 {
    let strengths: Vec<(f64, f64)> = poles(&fit.nodes)
        .into_iter()
        .filter(|pole| pole.im.abs() < 1.1 * highest && pole.re < 0.0)
        .map(|pole| {
            let residues = residues(functions, &fit.support, &fit.nodes, pole);
            // Relative to the strongest motion, near and far alike: weights of the nearest sample.
            let near = functions
                .iter()
                .min_by(|a, b| (a.s.im - pole.im.abs()).abs().total_cmp(&(b.s.im - pole.im.abs()).abs()));
            let strength =
                near.map_or(0.0, |f| residues.iter().zip(&f.weights).map(|(r, w)| r * w).fold(0.0, f64::max));
            (strength, -pole.re)
        })
        .collect();
    let loudest = strengths.iter().map(|s| s.0).fold(0.0, f64::max);
    let folds = |strength: f64| (1e5 * strength / loudest).ln();
    // A wave from the far side of the body passes R/c after one from its centre.
    strengths.iter().map(|(strength, decay)| folds(*strength) / decay).fold(0.0, f64::max) + 1.0
}

/// Order of samples by frequency.
fn ascending(functions: &[FunctionSample]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..functions.len()).collect();
    order.sort_by(|&a, &b| functions[a].s.im.total_cmp(&functions[b].s.im));
    order
}

fn reordered(samples: Vec<RadiationSample>, order: &[usize]) -> Vec<RadiationSample> {
    let mut slots: Vec<Option<RadiationSample>> = samples.into_iter().map(Some).collect();
    order.iter().filter_map(|&i| slots[i].take()).collect()
}

fn renumbered(mut fit: RationalFit, order: &[usize]) -> RationalFit {
    for i in &mut fit.support {
        *i = order.iter().position(|o| o == i).unwrap_or(*i);
    }
    fit
}

/// The fitted functions, from the multipoles of a solve.
pub(super) fn functions_of(sample: &RadiationSample, radius: f64) -> FunctionSample {
    let s = Complex64::I * sample.wavenumber * radius;
    let order = (sample.coefficients[0].len() as f64).sqrt() as usize - 1;
    // Spherical harmonics in the directions of the fit.
    let directions: Vec<Vec<f64>> = rotated_directions()
        .map(|direction| {
            let mut harmonics = Vec::new();
            solid_harmonics(direction, order, &mut harmonics);
            harmonics
        })
        .collect();
    let mut radial = Vec::new();
    let mut values = Vec::with_capacity(SPHERES.len() * DIRECTIONS * RIGID_DOFS);
    let mut weights = Vec::with_capacity(values.capacity());
    // Radial functions at the distance of the sphere, then the sum over orders in each direction.
    for x in SPHERES {
        outgoing(s, x, order, &mut radial);
        let mut loudest = 0.0_f64;
        for degree in 0..RIGID_DOFS {
            // Rotations at equal surface speed: z = R α.
            let unit = if degree < 3 { radius } else { radius * radius };
            let mut square = 0.0;
            for harmonics in &directions {
                let coefficients = &sample.coefficients[degree];
                let of_order = |n: usize| -> Complex64 {
                    let range = n * n..(n + 1) * (n + 1);
                    coefficients[range.clone()].iter().zip(&harmonics[range]).map(|(c, y)| c * y).sum()
                };
                let sum: Complex64 = radial.iter().enumerate().map(|(n, r)| r * of_order(n)).sum();
                square += sum.norm_sqr() / (unit * unit);
                values.push(sum / unit);
            }
            loudest = loudest.max((square / DIRECTIONS as f64).sqrt());
        }
        // Weights normalise each sphere by its strongest motion.
        weights.extend(std::iter::repeat_n(1.0 / loudest.max(f64::MIN_POSITIVE), RIGID_DOFS * DIRECTIONS));
    }
    FunctionSample { s, values, weights, group: DIRECTIONS }
}

/// Directions of the fit, rotated so that no body axis coincides with the axis of the spiral.
fn rotated_directions() -> impl Iterator<Item = DVec3> {
    directions(DIRECTIONS).map(|d| DVec3::new(0.6 * d.x - 0.8 * d.z, d.y, 0.8 * d.x + 0.6 * d.z))
}
