//! Outgoing multipoles of many surface motions, each at a wavenumber of its own.
//!
//! With one motion at a wavenumber, the incident waves of [`reception`](super::reception) are not needed at
//! the vertices. The transposed system gives an adjoint pressure ψ, and the multipoles are its integrals
//! with the waves:
//!
//! ```text
//! (½ − K − γH)ᵀ ψ = ⟨φᵢ, a_n⟩,      cₙₘ = θₙ ∮ ψ (u + γ ∂u/∂n) dS,      u = uₙ(k²r²) rⁿYₙₘ
//! ∂u/∂n = uₙ ∂(rⁿYₙₘ)/∂n − k² uₙ₊₁ (x·n) rⁿYₙₘ
//! ```
//!
//! The harmonics and their slopes do not depend on k. Those of some triangles are computed once for all
//! motions; each order is then two products of matrices, with the weights
//!
//! ```text
//! w ψ γ uₙ    and    w ψ (uₙ − γ k² (x·n) uₙ₊₁)
//! ```
//!
//! of all motions at the points of these triangles, w their quadrature weights.
//!
//! Waves that are shorter than two edges are beyond the triangles. There each point of the surface sends a
//! plane wave, as at high frequencies: p = a_n / ik. The field of this pressure is that of
//!
//! ```text
//! ψ = a_n,      since ∮ (a_n u − i/k a_n ∂u/∂n) dS = ∮ ψ (u + γ ∂u/∂n) dS with γ = −i/k
//! ```
//!
//! without a system. Bending waves that are shorter than those in air cancel in this integral as well.
//!
//! Not for surfaces with mirror planes, nor for many motions at one wavenumber: there the incident waves are
//! cheaper.

use std::ops::ControlFlow;

use clangor_core::math::radial::{regular, reverse_bessel};
use clangor_core::math::spherical_harmonics::count;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex64;
use rayon::prelude::*;

use super::dense_system::ClassSystem;
use super::incident_waves::POINTS;
use super::pair_rules::six_points;
use super::{MOST_ORDER, TriangleSolver, narrow, widen};
use crate::radiation::RadiationError;

/// Triangles whose points share a product: their harmonics to order 120 take 45 MB.
const BLOCK: usize = 32;
/// Systems between two calls of the progress, and their share of the work.
const TOGETHER: usize = 16;
const SOLVES: f64 = 0.5;
/// Iterations for the normal acceleration, and the step that is best for linear functions on triangles, whose
/// integrals are ¼ to 1 of those of one point: each takes away 0.4 of what is left, or more.
const ITERATIONS: usize = 10;
const STEP: f64 = 1.6;

/// A motion at its wavenumber.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoneMotion<'a> {
    /// In the unit of length of the surface.
    pub(crate) wavenumber: f64,
    /// Highest order of its multipoles, at most [`MOST_ORDER`].
    pub(crate) order: usize,
    /// ∫ φᵢ a_n dS at the vertices of the surface.
    pub(crate) loads: &'a [f64],
}

/// A motion with its adjoint pressure.
struct Adjoint {
    /// k times the radius of the multipoles.
    kappa: f64,
    /// iγ in that radius.
    coupling: f64,
    order: usize,
    /// ψ at the vertices of the panels.
    pressures: Vec<Complex64>,
}

/// A motion at the points of some triangles.
struct AtPoints {
    /// w ψ.
    weights: Vec<Complex64>,
    /// k² (x·n).
    along: Vec<f64>,
    /// uₙ to one order more than that of the motion, order by order at all points.
    radial: Vec<f64>,
}

impl TriangleSolver {
    /// What [`radiate`](Self::radiate) gives for each motion alone; of a surface without mirror planes.
    /// Beyond a wavenumber `highest`, by plane waves. `progress` gets the share that is done.
    ///
    /// # Errors
    /// [`RadiationError::NotFinite`] and [`RadiationError::Interrupted`].
    pub(crate) fn radiate_each(
        &self,
        motions: &[LoneMotion<'_>],
        (radius, highest): (f64, f64),
        progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Vec<Vec<Complex64>>, RadiationError> {
        let scale = self.radius / radius;
        // The highest orders first: the motions of each order are then the first ones.
        let mut sorted: Vec<usize> = (0..motions.len()).collect();
        sorted.sort_by_key(|m| std::cmp::Reverse(motions[*m].order));
        let mut adjoints: Vec<Adjoint> = Vec::with_capacity(motions.len());
        for batch in sorted.chunks(TOGETHER) {
            if progress(SOLVES * adjoints.len() as f64 / motions.len() as f64).is_break() {
                return Err(RadiationError::Interrupted);
            }
            let solve = |m: &usize| self.adjoint(&motions[*m], (radius, highest));
            let solved: Vec<Adjoint> = batch.par_iter().map(solve).collect();
            adjoints.extend(solved);
        }
        let most = adjoints.first().map_or(0, |adjoint| adjoint.order);
        let of_order = |n: usize| adjoints.iter().take_while(|adjoint| adjoint.order >= n).count();
        // Real and imaginary parts of the integrals of each order: of each harmonic, motion by motion.
        let mut integrals: Vec<Vec<f64>> =
            (0..=most).map(|n| vec![0.0; 2 * of_order(n) * (2 * n + 1)]).collect();
        let triangles = self.panels.triangles.len();
        let share = 2 * POINTS * count(most);
        let mut harmonics = vec![0.0; BLOCK.min(triangles) * share];
        for first in (0..triangles).step_by(BLOCK) {
            if progress(SOLVES + (1.0 - SOLVES) * first as f64 / triangles as f64).is_break() {
                return Err(RadiationError::Interrupted);
            }
            let block = first..(first + BLOCK).min(triangles);
            let harmonics = &mut harmonics[..block.len() * share];
            // Harmonics and weights at the points of the block.
            harmonics.par_chunks_exact_mut(share).enumerate().for_each(|(t, values)| {
                self.harmonics_on(first + t, scale, most, values);
            });
            let at_points: Vec<AtPoints> =
                adjoints.par_iter().map(|adjoint| self.at_points(adjoint, block.clone(), scale)).collect();
            // Products order by order.
            let harmonics = &*harmonics;
            integrals.par_iter_mut().enumerate().for_each(|(n, sums)| {
                let here = adjoints.iter().zip(&at_points).take(of_order(n)).collect::<Vec<_>>();
                add_order(n, (harmonics, count(most)), &here, sums);
            });
        }
        // Frequency-dependent factors of the orders.
        let mut coefficients = vec![Vec::new(); motions.len()];
        for (at, (adjoint, m)) in adjoints.iter().zip(&sorted).enumerate() {
            let mut theta = Vec::new();
            reverse_bessel(Complex64::new(0.0, adjoint.kappa), adjoint.order, &mut theta);
            for (n, theta) in theta.iter().enumerate() {
                let rows = integrals[n].chunks_exact(2 * of_order(n));
                coefficients[*m]
                    .extend(rows.map(|row| theta * Complex64::new(row[2 * at], row[2 * at + 1]) / radius));
            }
            if !coefficients[*m].iter().all(|c| c.is_finite()) {
                return Err(RadiationError::NotFinite { wavenumber: motions[*m].wavenumber });
            }
        }
        Ok(coefficients)
    }

    /// The adjoint pressure of a motion.
    fn adjoint(&self, motion: &LoneMotion<'_>, (radius, highest): (f64, f64)) -> Adjoint {
        let LoneMotion { wavenumber, order, loads } = *motion;
        let pressures = match wavenumber <= highest {
            true => self.solved_adjoint(wavenumber, loads),
            false => self.accelerations(loads),
        };
        let coupling = self.coupling(wavenumber * self.radius) * self.radius / radius;
        Adjoint { kappa: wavenumber * radius, coupling, order: order.min(MOST_ORDER), pressures }
    }

    /// The solution of the transposed system of a motion.
    fn solved_adjoint(&self, wavenumber: f64, loads: &[f64]) -> Vec<Complex64> {
        let classes = self.all_classes();
        let mut pressures = vec![Complex64::ZERO; self.panels.vertices.len()];
        for (class, matrix) in classes.iter().zip(self.matrices(wavenumber, &classes)) {
            let mut right = vec![Complex64::ZERO; class.size];
            for ((vertex, _), load) in self.origin.iter().zip(loads) {
                // A vertex without triangles does not occur in the panels.
                let unknown = class.unknowns.get(*vertex as usize).map_or(usize::MAX, |u| *u as usize);
                if let Some(sum) = right.get_mut(unknown) {
                    *sum += load;
                }
            }
            let right = right.into_iter().map(narrow).collect();
            let solution = ClassSystem { size: class.size, matrix, right }.solve_transposed();
            for (vertex, psi) in class.vertices().zip(solution) {
                pressures[vertex] = widen(psi);
            }
        }
        pressures
    }

    /// The normal acceleration a_n at the vertices of the panels, in their units, by iteration of
    /// Σⱼ ∮ φᵢ φⱼ dS aⱼ = ∮ φᵢ a_n dS.
    fn accelerations(&self, loads: &[f64]) -> Vec<Complex64> {
        let count = self.panels.vertices.len();
        let (mut right, mut areas) = (vec![0.0; count], vec![0.0; count]);
        for ((vertex, _), load) in self.origin.iter().zip(loads) {
            if let Some(sum) = right.get_mut(*vertex as usize) {
                *sum += load;
            }
        }
        let triangles = || self.panels.triangles.iter().zip(&self.panels.areas);
        for (corners, area) in triangles() {
            corners.iter().for_each(|v| areas[*v as usize] += area / 3.0);
        }
        let mut found = vec![0.0; count];
        for _ in 0..ITERATIONS {
            let mut rest = right.clone();
            for (corners, area) in triangles() {
                let sum: f64 = corners.iter().map(|v| found[*v as usize]).sum();
                corners.iter().for_each(|v| rest[*v as usize] -= area / 12.0 * (found[*v as usize] + sum));
            }
            found.iter_mut().zip(rest.iter().zip(&areas)).for_each(|(a, (rest, area))| {
                *a += STEP * rest / area;
            });
        }
        found.into_iter().map(|a| Complex64::new(a, 0.0)).collect()
    }

    /// A motion at the quadrature points of some triangles.
    fn at_points(&self, adjoint: &Adjoint, block: std::ops::Range<usize>, scale: f64) -> AtPoints {
        let square = adjoint.kappa * adjoint.kappa;
        let mut functions = Vec::new();
        let points = POINTS * block.len();
        let radial = vec![0.0; (adjoint.order + 2) * points];
        let mut at = AtPoints { weights: Vec::new(), along: Vec::new(), radial };
        for t in block {
            let psi = self.panels.triangles[t].map(|v| adjoint.pressures[v as usize]);
            for (shares, weight) in six_points() {
                let x = self.panels.point(t, shares) * scale;
                let between: Complex64 = shares.iter().zip(psi).map(|(share, psi)| psi * *share).sum();
                let point = at.weights.len();
                at.weights.push(between * (weight * self.panels.areas[t]));
                at.along.push(square * x.dot(self.panels.normals[t]));
                regular((square * x.length_squared()).into(), adjoint.order + 1, &mut functions);
                for (n, function) in functions.iter().enumerate() {
                    at.radial[n * points + point] = function.re;
                }
            }
        }
        at
    }
}

/// Adds the integrals of one order over some points: their harmonics and slopes, `stored` of each, and the
/// motions that have this order.
fn add_order(
    n: usize,
    (harmonics, stored): (&[f64], usize),
    motions: &[(&Adjoint, &AtPoints)],
    sums: &mut [f64],
) {
    let points = motions.first().map_or(0, |(_, at)| at.weights.len());
    let parts = 2 * motions.len();
    // Real and imaginary parts of each motion at all points.
    let (mut of_slopes, mut of_values) = (vec![0.0; parts * points], vec![0.0; parts * points]);
    let rows = of_slopes.chunks_exact_mut(2 * points).zip(of_values.chunks_exact_mut(2 * points));
    for ((adjoint, at), (slopes, values)) in motions.iter().zip(rows) {
        let radial = &at.radial[n * points..][..2 * points];
        let (here, above) = radial.split_at(points);
        let (slopes, values) = (slopes.split_at_mut(points), values.split_at_mut(points));
        // γ = −i times the coupling.
        let gamma = Complex64::new(0.0, -adjoint.coupling);
        for p in 0..points {
            let slope = at.weights[p] * gamma * here[p];
            let value = at.weights[p] * (here[p] - gamma * (at.along[p] * above[p]));
            (slopes.0[p], slopes.1[p]) = (slope.re, slope.im);
            (values.0[p], values.1[p]) = (value.re, value.im);
        }
    }
    // Row by row: harmonics of this order at each point.
    let (low, width) = (n * n, 2 * n + 1);
    let of_order = |first: usize| {
        MatRef::from_row_major_slice_with_stride(&harmonics[first..], points, width, 2 * stored)
    };
    let mut sums = MatMut::from_column_major_slice_mut(sums, parts, width);
    for (weights, first) in [(&of_slopes, stored + low), (&of_values, low)] {
        let weights = MatRef::from_row_major_slice(weights, parts, points);
        matmul(sums.as_mut(), Accum::Add, weights, of_order(first), 1.0, Par::Seq);
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::shape::Shape;

    use super::super::Equation;
    use super::*;

    #[test]
    fn motions_one_by_one_radiate_as_by_incident_waves() {
        let mesh = Shape::parse("box:0.05x0.03x0.02").expect("a box").mesh();
        let mesh = clangor_core::geometry::refine::refine_to_edge(&mesh, 0.012);
        let solver = TriangleSolver::try_new(&mesh, 400.0, Equation::BurtonMiller).expect("small");
        let load = |f: f64| (0..mesh.vertices.len()).map(|v| (f * v as f64).sin()).collect::<Vec<f64>>();
        let loads = [load(0.3), load(1.7), load(2.9)];
        let lone = |m: usize| LoneMotion {
            wavenumber: [300.0, 80.0, 400.0][m],
            order: [12, 6, 14][m],
            loads: &loads[m],
        };
        let motions: Vec<LoneMotion<'_>> = (0..3).map(lone).collect();
        let each =
            solver.radiate_each(&motions, (0.04, 400.0), &mut |_| ControlFlow::Continue(())).expect("finite");
        let mut worst = 0.0_f64;
        for (motion, own) in motions.iter().zip(&each) {
            let LoneMotion { wavenumber, order, loads } = *motion;
            let loads = [loads.to_vec()];
            let waves = solver.radiate(wavenumber, order, 0.04, &loads, None).expect("finite");
            assert_eq!(own.len(), waves[0].len());
            let size = waves[0].iter().map(|c| c.norm()).fold(0.0, f64::max);
            for (a, b) in own.iter().zip(&waves[0]) {
                worst = worst.max((a - b).norm() / size);
            }
        }
        println!("Largest difference {worst:.1e} of the largest multipole");
        assert!(worst < 1e-5, "{worst}");
    }

    /// The pressure of a sphere that breathes is a R/(1 + iκ), that of plane waves a R/iκ. With the harmonic
    /// j₀(kr) the first has the monopole j₀ − κ j₁/(1 + iκ), the second j₀ + i j₁.
    #[test]
    fn plane_waves_are_those_of_high_frequencies() {
        let mesh = Shape::parse("sphere:0.05@0.0045").expect("a ball").mesh();
        let solver = TriangleSolver::try_new(&mesh, 300.0, Equation::BurtonMiller).expect("small");
        let mut loads = vec![0.0; mesh.vertices.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            corners.iter().for_each(|v| loads[*v as usize] += mesh.area_vector(t).length() / 3.0);
        }
        let (mut worst, mut furthest) = (0.0_f64, 0.0_f64);
        for kappa in [5.0_f64, 10.0] {
            let motion = [LoneMotion { wavenumber: kappa / 0.05, order: 0, loads: &loads }];
            let monopole = |highest: f64| {
                let each = solver.radiate_each(&motion, (0.05, highest), &mut |_| ControlFlow::Continue(()));
                each.expect("finite")[0][0]
            };
            let ratio = monopole(0.0) / monopole(f64::INFINITY);
            let (j0, i) = (kappa.sin() / kappa, Complex64::I);
            let j1 = (j0 - kappa.cos()) / kappa;
            let closed = (j0 + i * j1) / (j0 - kappa * j1 / (1.0 + i * kappa));
            worst = worst.max((ratio / closed - 1.0).norm());
            furthest = furthest.max((closed - 1.0).norm());
        }
        // Seen: 6.6e-3, where plane waves are off by up to 0.10.
        println!("{worst:.1e}, waves {furthest:.2}");
        assert!(worst < 0.02, "{worst}");
    }
}
