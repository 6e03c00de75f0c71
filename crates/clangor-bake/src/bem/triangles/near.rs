//! The part of the system that couples touching or nearly touching triangles, at any wavenumber of the band.
//!
//! Such a pair spans at most a few triangles, so that its integrals hardly change with k. With kr ≤ kρ on all
//! near pairs, Q wavenumbers k_q determine the real parts (even in k) and the imaginary parts (odd) as
//! polynomials of degree 2Q − 1 to (kρ/2)^{2Q}·2/(2Q)!. They are integrated once at the k_q, and each solve
//! interpolates them.

use std::f64::consts::PI;

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use super::pair_integrals::{Block, PairIntegrator};
use super::pair_rules::TouchingRules;
use super::panels::Panels;
use crate::effort::Effort;

/// Required bound of the interpolation error in k.
const INTERPOLATION: f64 = 1e-6;
/// The same for drafts.
const INTERPOLATION_OF_DRAFTS: f64 = 1e-3;

/// Values of an entry at one wavenumber: real part, and imaginary part over k, of the double layer and of the
/// hypersingular operator.
const PARTS: usize = 4;

/// Triangles whose pairs are integrated before they are added up.
const BATCH: usize = 512;

/// The near part of the system over the triangles of one cell of the mirror symmetry.
#[derive(Clone, Debug)]
pub(super) struct NearSystem {
    /// Wavenumbers k_q, in 1/R.
    nodes: Vec<f64>,
    /// One coupling per mirror image of the sources, the sources themselves first.
    pub(super) images: Vec<NearImage>,
    /// S a_n and K' a_n of each vertex and motion, PARTS per node.
    loads: Vec<f64>,
    /// ⟨φ_i, a_n⟩ of each vertex.
    pub(super) data: Vec<[f64; RIGID_DOFS]>,
}

/// Couplings with one image.
#[derive(Clone, Debug)]
pub(super) struct NearImage {
    /// Pairs of triangles (test, source), test ≤ source, that are in here.
    pub(super) pairs: Vec<(u32, u32)>,
    /// First entry of each row, one more than rows.
    rows: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl NearSystem {
    /// Integrates the near pairs for wavenumbers up to `highest` [1/R].
    pub(super) fn new(panels: &Panels, images: &[DVec3], highest: f64, effort: Effort) -> Self {
        let rules = TouchingRules::of(effort);
        let mirrored: Vec<Panels> = images.iter().map(|signs| panels.image(*signs)).collect();
        let separation = rules.separation();
        let pairs: Vec<Vec<(u32, u32)>> =
            mirrored.iter().map(|source| near_pairs(panels, source, separation)).collect();
        let reach = mirrored
            .iter()
            .zip(&pairs)
            .flat_map(|(source, pairs)| pairs.iter().map(move |pair| (source, pair)))
            .map(|(source, &(t, s))| {
                let (t, s) = (t as usize, s as usize);
                panels.centroids[t].distance(source.centroids[s]) + panels.radii[t] + source.radii[s]
            })
            .fold(0.0, f64::max);
        let error = if effort == Effort::Draft { INTERPOLATION_OF_DRAFTS } else { INTERPOLATION };
        let nodes = nodes(highest, reach, error);
        let vertices = panels.vertices.len();
        let mut loads = vec![0.0; vertices * RIGID_DOFS * nodes.len() * PARTS];
        let images = images
            .iter()
            .zip(&mirrored)
            .zip(pairs)
            .map(|((signs, source), pairs)| {
                let integrator =
                    PairIntegrator { test: panels, source, signs: *signs, rules: &rules, nodes: &nodes };
                NearImage::new(&integrator, pairs, &mut loads)
            })
            .collect::<Vec<_>>();
        let mut system = Self { nodes, images, loads, data: vec![[0.0; RIGID_DOFS]; vertices] };
        system.add_masses(panels);
        system
    }

    /// ½⟨φ_i, φ_j⟩ and ⟨φ_i, a_n⟩.
    fn add_masses(&mut self, panels: &Panels) {
        let count = self.nodes.len();
        for t in 0..panels.triangles.len() {
            let motions = panels.motions(t);
            for (i, row) in panels.triangles[t].iter().enumerate() {
                for (j, column) in panels.triangles[t].iter().enumerate() {
                    let mass = panels.areas[t] / if i == j { 6.0 } else { 12.0 };
                    let image = &mut self.images[0];
                    let first = image.entry(*row, *column) * count * PARTS;
                    for q in 0..count {
                        image.values[first + q * PARTS] += 0.5 * mass;
                    }
                    for (sum, a) in self.data[*row as usize].iter_mut().zip(motions[j]) {
                        *sum += mass * a;
                    }
                }
            }
        }
    }

    /// Lagrange's weights of the nodes, as functions of k².
    fn weights(&self, wavenumber: f64) -> Vec<f64> {
        let square = |k: f64| k * k;
        (0..self.nodes.len())
            .map(|q| {
                let others = self.nodes.iter().enumerate().filter(|(p, _)| *p != q);
                others
                    .map(|(_, k)| (square(wavenumber) - square(*k)) / (square(self.nodes[q]) - square(*k)))
                    .product()
            })
            .collect()
    }

    /// Whether the interpolation holds at a wavenumber [1/R].
    pub(super) fn covers(&self, highest: f64) -> bool {
        let last = self.nodes.iter().copied().fold(0.0, f64::max);
        highest * (PI / (4.0 * self.nodes.len() as f64)).cos() <= last * (1.0 + 1e-9)
    }

    /// Calls `add(image, row, column, ½M − K + γW)` for every near entry, γ = −i`coupling`.
    pub(super) fn for_each(
        &self,
        wavenumber: f64,
        coupling: f64,
        mut add: impl FnMut(usize, u32, u32, Complex64),
    ) {
        let weights = self.weights(wavenumber);
        for (g, image) in self.images.iter().enumerate() {
            let mut entries = image.values.chunks_exact(PARTS * weights.len());
            for row in 0..image.rows.len() - 1 {
                for e in image.rows[row]..image.rows[row + 1] {
                    let [double, hyper] = interpolate(&weights, wavenumber, entries.next().unwrap_or(&[]));
                    let value = double + Complex64::new(0.0, -coupling) * hyper;
                    add(g, row as u32, image.columns[e as usize], value);
                }
            }
        }
    }

    /// Near part of ⟨φ_i, S a + γ(½ + K')a⟩ of each vertex and motion, ½a included.
    pub(super) fn loads(&self, wavenumber: f64, coupling: f64) -> Vec<[Complex64; RIGID_DOFS]> {
        let weights = self.weights(wavenumber);
        let mut values = self.loads.chunks_exact(PARTS * weights.len());
        let gamma = Complex64::new(0.0, -coupling);
        self.data
            .iter()
            .map(|data| {
                std::array::from_fn(|d| {
                    let [single, adjoint] = interpolate(&weights, wavenumber, values.next().unwrap_or(&[]));
                    single + gamma * (0.5 * data[d] + adjoint)
                })
            })
            .collect()
    }
}

/// The two complex values of an entry at a wavenumber.
fn interpolate(weights: &[f64], wavenumber: f64, values: &[f64]) -> [Complex64; 2] {
    let mut sums = [0.0; PARTS];
    for (weight, values) in weights.iter().zip(values.chunks_exact(PARTS)) {
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += weight * value;
        }
    }
    [Complex64::new(sums[0], wavenumber * sums[1]), Complex64::new(sums[2], wavenumber * sums[3])]
}

/// Positive Chebyshev points of [−highest, highest], as many as the error bound needs.
fn nodes(highest: f64, reach: f64, error: f64) -> Vec<f64> {
    let phase = 0.5 * highest * reach;
    let mut bound = 2.0;
    let mut count = 0;
    while count < 2 || (bound > error && count < 16) {
        count += 1;
        bound *= phase * phase / ((2 * count * (2 * count - 1)) as f64);
    }
    // At k = 0 any small interval serves.
    let highest = highest.max(1e-3);
    (0..count).map(|q| highest * (PI * (q as f64 + 0.5) / (2 * count) as f64).cos()).collect()
}

/// Pairs closer than a separation, in the sum of their radii, each once.
fn near_pairs(test: &Panels, source: &Panels, separation: f64) -> Vec<(u32, u32)> {
    let count = test.triangles.len();
    (0..count)
        .into_par_iter()
        .map(|t| {
            let near = |s: &usize| {
                let limit = separation * (test.radii[t] + source.radii[*s]);
                test.centroids[t].distance_squared(source.centroids[*s]) <= limit * limit
            };
            (t..count).filter(near).map(|s| (t as u32, s as u32)).collect::<Vec<_>>()
        })
        .collect::<Vec<_>>()
        .concat()
}

impl NearImage {
    fn new(integrator: &PairIntegrator<'_>, pairs: Vec<(u32, u32)>, loads: &mut [f64]) -> Self {
        let (test, source) = (integrator.test, integrator.source);
        // Sparsity pattern: the vertex pairs of all near triangle pairs, in compressed rows.
        let mut entries: Vec<(u32, u32)> = pairs
            .iter()
            .flat_map(|&(t, s)| {
                let (u, v) = (test.triangles[t as usize], test.triangles[s as usize]);
                u.into_iter().flat_map(move |i| v.into_iter().flat_map(move |j| [(i, j), (j, i)]))
            })
            .collect();
        entries.sort_unstable();
        entries.dedup();
        let mut rows = vec![0; test.vertices.len() + 1];
        for (i, _) in &entries {
            rows[*i as usize + 1] += 1;
        }
        for i in 1..rows.len() {
            rows[i] += rows[i - 1];
        }
        let columns: Vec<u32> = entries.iter().map(|(_, j)| *j).collect();
        let values = vec![0.0; columns.len() * integrator.nodes.len() * PARTS];
        let mut image = Self { pairs: Vec::new(), rows, columns, values };
        // Singular and near-singular integrals, in parallel batches; summed in order.
        for batch in pairs.chunks(BATCH) {
            let blocks: Vec<Vec<Block>> =
                batch.par_iter().map(|&(t, s)| integrator.integrate(t as usize, s as usize)).collect();
            for (&(t, s), blocks) in batch.iter().zip(&blocks) {
                let (t, s) = (t as usize, s as usize);
                image.add(integrator, blocks, (test, t), (source, s), false, loads);
                // Exchanging test and source gives the other half of the pair. A triangle and its own image
                // have only one.
                if t != s {
                    image.add(integrator, blocks, (source, s), (test, t), true, loads);
                }
            }
        }
        image.pairs = pairs;
        image
    }

    fn entry(&self, row: u32, column: u32) -> usize {
        let range = self.rows[row as usize] as usize..self.rows[row as usize + 1] as usize;
        range.start + self.columns[range.clone()].partition_point(|c| *c < column)
    }

    /// Adds a block, with its first triangle as the test or exchanged.
    fn add(
        &mut self,
        integrator: &PairIntegrator<'_>,
        blocks: &[Block],
        (test, t): (&Panels, usize),
        (source, s): (&Panels, usize),
        exchanged: bool,
        loads: &mut [f64],
    ) {
        let count = integrator.nodes.len();
        let aligned = test.normals[t].dot(source.normals[s]);
        let motions = source.motions(s);
        let (u, v) = (test.triangles[t], source.triangles[s]);
        for (i, row) in u.iter().enumerate() {
            for (j, column) in v.iter().enumerate() {
                let at = if exchanged { 3 * j + i } else { 3 * i + j };
                let curls = test.curls[t][i].dot(source.curls[s][j]);
                let first = self.entry(*row, *column) * count * PARTS;
                for (q, (block, &k)) in blocks.iter().zip(integrator.nodes).enumerate() {
                    let (double, adjoint) = if exchanged {
                        (&block.by_test, &block.by_source)
                    } else {
                        (&block.by_source, &block.by_test)
                    };
                    let total: Complex64 = block.value.iter().sum();
                    // Hypersingular term, integrated by parts: curls and normals.
                    let hyper = total * curls - block.value[at] * (k * k * aligned);
                    let value = &mut self.values[first + q * PARTS..][..PARTS];
                    let layer = -double[at];
                    for (sum, part) in value.iter_mut().zip([layer.re, layer.im / k, hyper.re, hyper.im / k])
                    {
                        *sum += part;
                    }
                    // Loads of the six motions by the single and the adjoint double layer.
                    let (single, adjoint) = (block.value[at], adjoint[at]);
                    for d in 0..RIGID_DOFS {
                        // A mirrored test function has the sign of the motion under the reflection.
                        let a = motions[j][d] * if exchanged { integrator.parity(d) } else { 1.0 };
                        let load =
                            &mut loads[((*row as usize * RIGID_DOFS + d) * count + q) * PARTS..][..PARTS];
                        let parts = [single.re, single.im / k, adjoint.re, adjoint.im / k];
                        for (sum, part) in load.iter_mut().zip(parts) {
                            *sum += a * part;
                        }
                    }
                }
            }
        }
    }
}
