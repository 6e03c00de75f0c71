//! Integrals of G and its normal derivatives over a near pair of triangles, at several wavenumbers.
//!
//! For each pair of shape functions: ∫∫ φ_i(x) φ_j(y) {G, ∂G/∂n_y, ∂G/∂n_x}. Points are collected in blocks,
//! and the sums over a block run in vector registers.

use std::f64::consts::PI;

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::pair_rules::{Shares, TouchingRules, close_pair, leading};
use super::panels::Panels;

/// Points per block.
const POINTS: usize = 64;

/// Lanes of a partial sum.
const LANES: usize = 8;

/// Integrals of one pair at one wavenumber; index 3i + j, i of the test triangle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Block {
    /// Of G.
    pub(super) value: [Complex64; 9],
    /// Of ∂G/∂n_y, y on the source.
    pub(super) by_source: [Complex64; 9],
    /// Of ∂G/∂n_x, x on the test triangle.
    pub(super) by_test: [Complex64; 9],
}

/// Inputs shared by the integrals of all pairs.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairIntegrator<'a> {
    pub(super) test: &'a Panels,
    /// The test panels, or their image.
    pub(super) source: &'a Panels,
    /// Signs of the reflection that made the image.
    pub(super) signs: DVec3,
    pub(super) rules: &'a TouchingRules,
    /// Wavenumbers [1/R].
    pub(super) nodes: &'a [f64],
}

/// A block of points, lane by lane.
struct Points {
    filled: usize,
    distance: [f64; POINTS],
    /// (x − y)·n_y / r² and (x − y)·n_x / r².
    source_slope: [f64; POINTS],
    test_slope: [f64; POINTS],
    /// Weight · φ_i φ_j / (4πr).
    shapes: [[f64; POINTS]; 9],
}

impl PairIntegrator<'_> {
    /// Sign of a rigid motion under the reflection.
    pub(super) fn parity(&self, degree: usize) -> f64 {
        parity(self.signs, degree)
    }

    /// The integrals of a pair, one block per node.
    pub(super) fn integrate(&self, t: usize, s: usize) -> Vec<Block> {
        let arch = pulp::Arch::new();
        let mut blocks = vec![Block::default(); self.nodes.len()];
        let mut points = Points::new();
        let area = self.test.areas[t] * self.source.areas[s] / (4.0 * PI);
        // Collect quadrature points; evaluate the kernels once a block is full.
        let mut add = |u: Shares, v: Shares, weight: f64| {
            let (x, y) = (self.test.point(t, u), self.source.point(s, v));
            points.push(x - y, self.test.normals[t], self.source.normals[s], u, v, area * weight);
            if points.filled == POINTS {
                arch.dispatch(Sums { points: &points, nodes: self.nodes, blocks: &mut blocks });
                points.clear();
            }
        };
        // Separate pair: subdivision. Touching pair: Sauter and Schwab's rule, with shared corners first.
        let shared = self.shared(t, s);
        if shared.is_empty() {
            close_pair(self.test, self.source, ((t, s), self.rules), &mut add);
        } else {
            let (p, q) =
                (leading(self.test.triangles[t], &shared), leading(self.source.triangles[s], &shared));
            for point in self.rules.sharing(shared.len()) {
                let (mut u, mut v) = ([0.0; 3], [0.0; 3]);
                for c in 0..3 {
                    u[p[c]] = point.test[c];
                    v[q[c]] = point.source[c];
                }
                add(u, v, point.weight);
            }
        }
        if points.filled > 0 {
            arch.dispatch(Sums { points: &points, nodes: self.nodes, blocks: &mut blocks });
        }
        blocks
    }

    /// Shared corners: the same vertex, on every plane of reflection.
    fn shared(&self, t: usize, s: usize) -> Vec<u32> {
        let on_planes = |v: u32| self.test.vertices[v as usize] == self.source.vertices[v as usize];
        let source = self.source.triangles[s];
        self.test.triangles[t].into_iter().filter(|v| source.contains(v) && on_planes(*v)).collect()
    }
}

/// Sign of a rigid motion under a reflection: translations are vectors, rotations axial vectors.
pub(crate) fn parity(signs: DVec3, degree: usize) -> f64 {
    let sign = signs.to_array()[degree % 3];
    if degree < RIGID_DOFS / 2 { sign } else { sign * signs.x * signs.y * signs.z }
}

impl Points {
    fn new() -> Self {
        Self {
            filled: 0,
            distance: [1.0; POINTS],
            source_slope: [0.0; POINTS],
            test_slope: [0.0; POINTS],
            shapes: [[0.0; POINTS]; 9],
        }
    }

    fn push(&mut self, d: DVec3, n_test: DVec3, n_source: DVec3, u: Shares, v: Shares, weight: f64) {
        let p = self.filled;
        let distance = d.length().max(1e-30);
        let inverse = 1.0 / distance;
        self.distance[p] = distance;
        self.source_slope[p] = d.dot(n_source) * inverse * inverse;
        self.test_slope[p] = d.dot(n_test) * inverse * inverse;
        for (i, u) in u.iter().enumerate() {
            for (j, v) in v.iter().enumerate() {
                self.shapes[3 * i + j][p] = weight * inverse * u * v;
            }
        }
        self.filled += 1;
    }

    /// Starts a new block. Unfilled points have zero weight.
    fn clear(&mut self) {
        self.filled = 0;
        self.shapes = [[0.0; POINTS]; 9];
    }
}

/// Adds a block of points to the integrals, compiled for the instruction set at hand.
struct Sums<'a> {
    points: &'a Points,
    nodes: &'a [f64],
    blocks: &'a mut [Block],
}

impl WithSimd for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { points, nodes, blocks } = self;
        let (mut sine, mut cosine) = ([0.0; POINTS], [0.0; POINTS]);
        // −(1 + ikr) e^{−ikr}, which is 4πr² dG/dr.
        let (mut slope, mut odd_slope) = ([0.0; POINTS], [0.0; POINTS]);
        for (k, block) in nodes.iter().zip(blocks) {
            turn(&points.distance, k / (2.0 * PI), &mut sine, &mut cosine);
            for p in 0..POINTS {
                let phase = k * points.distance[p];
                slope[p] = -(cosine[p] + phase * sine[p]);
                odd_slope[p] = sine[p] - phase * cosine[p];
            }
            // ∂r/∂n_x = d·n_x/r, ∂r/∂n_y = −d·n_y/r.
            let test = [product(&points.test_slope, &slope), product(&points.test_slope, &odd_slope)];
            let source = [product(&points.source_slope, &slope), product(&points.source_slope, &odd_slope)];
            for (c, shape) in points.shapes.iter().enumerate() {
                block.value[c] += Complex64::new(dot(shape, &cosine), -dot(shape, &sine));
                block.by_test[c] += Complex64::new(dot(shape, &test[0]), dot(shape, &test[1]));
                block.by_source[c] -= Complex64::new(dot(shape, &source[0]), dot(shape, &source[1]));
            }
        }
    }
}

#[inline(always)]
fn product(a: &[f64; POINTS], b: &[f64; POINTS]) -> [f64; POINTS] {
    let mut out = [0.0; POINTS];
    for p in 0..POINTS {
        out[p] = a[p] * b[p];
    }
    out
}

#[inline(always)]
fn dot(a: &[f64; POINTS], b: &[f64; POINTS]) -> f64 {
    let mut sums = [0.0; LANES];
    for p in 0..POINTS / LANES {
        for l in 0..LANES {
            sums[l] += a[p * LANES + l] * b[p * LANES + l];
        }
    }
    ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]))
}

/// sin and cos of 2π·`rate`·x, by Taylor's polynomials on a quarter turn either side and the double angle.
#[inline(always)]
fn turn(x: &[f64; POINTS], rate: f64, sine: &mut [f64; POINTS], cosine: &mut [f64; POINTS]) {
    // Adding 1.5·2⁵² leaves no bits for a fraction.
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    for p in 0..POINTS {
        let turns = x[p] * rate;
        let half_angle = PI * (turns - ((turns + MAGIC) - MAGIC));
        let z = half_angle * half_angle;
        let (mut s, mut c) = (1.0, 1.0);
        for m in (1..10).rev() {
            let m = m as f64;
            s = 1.0 - s * z * (1.0 / ((2.0 * m) * (2.0 * m + 1.0)));
            c = 1.0 - c * z * (1.0 / ((2.0 * m) * (2.0 * m - 1.0)));
        }
        let s = s * half_angle;
        sine[p] = 2.0 * s * c;
        cosine[p] = 1.0 - 2.0 * s * s;
    }
}
