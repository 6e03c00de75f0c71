//! Interpolation of a field from its nodes in frequency to the bins of a grid.
//!
//! Values v_j at the nodes s_j, and conj(v_j) at their mirrors, are interpolated to s = iω_k R/c. With c_j =
//! 1/((s − s_j)(s − conj s_j)), the mirrored pairs of nodes are real-linear in two real numbers per node:
//!
//! ```text
//! v(s) = (s Σ_j Re(w_j v_j) c_j − Σ_j Re(w_j v_j conj s_j) c_j) / D,   D = the same with v = 1
//! ```
//!
//! c_j and 1/D depend on the field, its size and the grid only. An [`Interpolation`] holds them, and a bin
//! costs four multiplications per node, or two where all nodes are on the imaginary axis and c_j is real.
//! With many sizes of bodies, reading these tables from memory limits the speed. Therefore c_j is kept in
//! single precision, like the v_j. D is computed from the rounded c_j, so that constants stay constants.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::band_end_fade::fade;
use super::field_source::FieldSource;
use super::lowpass;
use super::spectrum::{Grid, LANES};
use crate::sound_model::acceleration::field::Node;

/// Replaces κ = 0, where a node may be.
pub(super) const LEAST_WAVENUMBER: f64 = 1e-12;

/// Complex numbers at consecutive bins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bins {
    pub(super) re: [f64; LANES],
    pub(super) im: [f64; LANES],
}

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Interpolation {
    nodes: usize,
    /// Re c_j: for each group of bins, for each node.
    pairs_re: Vec<[f32; LANES]>,
    /// Im c_j; empty if all are zero.
    pairs_im: Vec<[f32; LANES]>,
    /// Fade / D for each group of bins.
    pub(super) inverse: Vec<Bins>,
    /// The fade, up to the last bin that is not zero; empty where it is 1 everywhere.
    pub(super) gains: Vec<f64>,
}

impl Interpolation {
    /// The interpolation for a source with this R/c \[s\].
    pub(super) fn of(source: &FieldSource, crossing: f64, grid: &Grid) -> Self {
        let nodes = source.field.nodes();
        let (centre, half_width) = fade(source.max_frequency(source.radius / crossing));
        let whole = centre - half_width >= grid.spacing_hz * grid.omega.len() as f64;
        let place = |k: usize| (grid.spacing_hz * k as f64 - centre) / half_width;
        let gains = if whole { Vec::new() } else { lowpass::transition(place) };
        let groups = if whole { grid.omega.len() / LANES } else { gains.len().div_ceil(LANES) };
        let groups = groups.min(grid.omega.len() / LANES);
        let damped = nodes.iter().any(|node| node.s.re != 0.0);
        let table = Interpolation {
            nodes: nodes.len(),
            pairs_re: vec![[0.0f32; LANES]; groups * nodes.len()],
            pairs_im: vec![[0.0f32; LANES]; if damped { groups * nodes.len() } else { 0 }],
            inverse: vec![Bins::default(); groups],
            gains,
        };
        Arch::new().dispatch(Filling { table, nodes, crossing, omega: &grid.omega })
    }

    /// Memory that it occupies \[bytes\].
    pub(super) fn size(&self) -> usize {
        size_of_val(&self.pairs_re[..])
            + size_of_val(&self.pairs_im[..])
            + size_of_val(&self.inverse[..])
            + size_of_val(&self.gains[..])
    }

    /// Σ_j a_j c_j and Σ_j g_j c_j at a group of bins, for `weighted` (a_j, g_j).
    #[inline(always)]
    pub(super) fn sums<S: Simd>(&self, simd: S, weighted: &[(f64, f64)], group: usize) -> (Bins, Bins) {
        let range = group * self.nodes..(group + 1) * self.nodes;
        let (mut slope, mut level) = (Bins::default(), Bins::default());
        (slope.re, level.re) = node_sums(simd, weighted, &self.pairs_re[range.clone()]);
        if !self.pairs_im.is_empty() {
            (slope.im, level.im) = node_sums(simd, weighted, &self.pairs_im[range]);
        }
        (slope, level)
    }
}

/// Σ_j a_j c_j and Σ_j g_j c_j for real parts or imaginary ones.
#[inline(always)]
fn node_sums<S: Simd>(
    simd: S,
    weighted: &[(f64, f64)],
    pairs: &[[f32; LANES]],
) -> ([f64; LANES], [f64; LANES]) {
    // Separate sums for even and odd nodes, so that an addition does not depend on the one before it.
    let mut even = ([0.0; LANES], [0.0; LANES]);
    let mut odd = even;
    let (twos, rest) = weighted.as_chunks::<2>();
    let (pair_twos, pair_rest) = pairs.as_chunks::<2>();
    for (two, pair) in twos.iter().zip(pair_twos) {
        add(simd, &mut even, two[0], &pair[0]);
        add(simd, &mut odd, two[1], &pair[1]);
    }
    for (weighted, pair) in rest.iter().zip(pair_rest) {
        add(simd, &mut even, *weighted, pair);
    }
    (
        std::array::from_fn(|lane| even.0[lane] + odd.0[lane]),
        std::array::from_fn(|lane| even.1[lane] + odd.1[lane]),
    )
}

/// Adds a c and g c.
#[inline(always)]
fn add<S: Simd>(simd: S, sums: &mut ([f64; LANES], [f64; LANES]), (a, g): (f64, f64), pair: &[f32; LANES]) {
    let c = pair.map(f64::from);
    let (a, g) = (simd.splat_f64s(a), simd.splat_f64s(g));
    let columns = S::as_simd_f64s(&c).0;
    for (sum, c) in S::as_mut_simd_f64s(&mut sums.0).0.iter_mut().zip(columns) {
        *sum = simd.mul_add_e_f64s(a, *c, *sum);
    }
    for (sum, c) in S::as_mut_simd_f64s(&mut sums.1).0.iter_mut().zip(columns) {
        *sum = simd.mul_add_e_f64s(g, *c, *sum);
    }
}

/// Fills a table, with the vector instructions of the machine.
struct Filling<'a> {
    table: Interpolation,
    nodes: &'a [Node],
    crossing: f64,
    omega: &'a [f64],
}

impl WithSimd for Filling<'_> {
    type Output = Interpolation;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Interpolation {
        let Filling { mut table, nodes, crossing, omega } = self;
        let (count, damped) = (nodes.len(), !table.pairs_im.is_empty());
        for (group, omega) in omega.as_chunks::<LANES>().0.iter().take(table.inverse.len()).enumerate() {
            let wavenumber = omega.map(|w| (w * crossing).max(LEAST_WAVENUMBER));
            let mut below = Bins::default();
            for (j, node) in nodes.iter().enumerate() {
                let square = node.s.norm_sqr();
                let weight_at_place = (node.weight * node.s.conj()).re;
                let (mut pair_re, mut pair_im) = ([0.0; LANES], [0.0; LANES]);
                for lane in 0..LANES {
                    let k = wavenumber[lane];
                    let re = square - k * k;
                    let im = -2.0 * node.s.re * k;
                    let size = re * re + im * im;
                    // At a node: a point close beside it, where its pair outweighs all others by far.
                    let (re, size) =
                        if size > 0.0 { (re, size) } else { (1e-16 * square, 1e-32 * square * square) };
                    let (re, im) = ((re / size) as f32, (-im / size) as f32);
                    (pair_re[lane], pair_im[lane]) = (re, im);
                    let (re, im) = (f64::from(re), f64::from(im));
                    below.re[lane] -= k * node.weight.re * im + weight_at_place * re;
                    below.im[lane] += k * node.weight.re * re - weight_at_place * im;
                }
                table.pairs_re[group * count + j] = pair_re;
                if damped {
                    table.pairs_im[group * count + j] = pair_im;
                }
            }
            for lane in 0..LANES {
                let inverted = Complex64::new(below.re[lane], below.im[lane]).inv();
                let gain = if table.gains.is_empty() {
                    1.0
                } else {
                    table.gains.get(group * LANES + lane).copied().unwrap_or(0.0)
                };
                let value = if inverted.is_finite() { gain * inverted } else { Complex64::ZERO };
                (table.inverse[group].re[lane], table.inverse[group].im[lane]) = (value.re, value.im);
            }
        }
        table
    }
}
