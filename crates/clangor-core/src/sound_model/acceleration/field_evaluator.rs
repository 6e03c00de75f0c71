//! A validated [`AccelerationField`], in a layout that makes one evaluation at its nodes take microseconds.
//!
//! The pressure at the nodes is a sum over terms, then over orders:
//!
//! ```text
//! v_j = Σ_n [τₙ(s_j)/(x θₙ(s_j))] Σ_terms of order n (z_i Y_nm) Q_j
//! τ₀ = 1,  τ₁ = s + 1/x,  τₙ = (2n−1)/x τₙ₋₁ + s² τₙ₋₂
//! ```
//!
//! where τₙ = θₙ(sx)/xⁿ stays in range at any distance, and θ₀ is replaced by 1/s². The inner sum is nearly
//! all of the work: real factors times complex values. Eight nodes make one group of 16 numbers side by side,
//! in single precision as they are stored. Up to three groups are summed at once, so that each factor is
//! loaded once for all of them; they are adjacent in memory. The outer sum is in double precision.
//!
//! The vector instructions are the widest of the machine, chosen at run time.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use crate::math::radial::reverse_bessel;
use crate::math::spherical_harmonics::{HarmonicTable, count, index};
use crate::sound_model::acceleration::field::{AccelerationField, Node, RIGID_DOFS, Term};

/// Nodes computed together.
pub const GROUP: usize = 8;
/// Groups summed at once.
const MOST_GROUPS: usize = 3;
/// Highest order evaluated.
pub const MAX_ORDER: usize = 100;

/// Error in a field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// Arrays whose lengths contradict each other.
    #[error(
        "the field has {terms} terms and {nodes} nodes, which need {expected} values, but {real} real and \
        {imaginary} imaginary ones"
    )]
    Lengths {
        /// Number of terms.
        terms: usize,
        /// Number of nodes.
        nodes: usize,
        /// Terms times nodes.
        expected: usize,
        /// Number of real parts.
        real: usize,
        /// Number of imaginary parts.
        imaginary: usize,
    },
    /// No nodes.
    #[error("the field has no nodes in frequency")]
    NoNodes,
    /// A term that is undefined, or out of order.
    #[error(
        "term {index} of the field (n = {n}, m = {m}, degree {degree}) does not exist, comes twice or is \
        out of order"
    )]
    Term {
        /// Index of the term.
        index: usize,
        /// n.
        n: u8,
        /// m.
        m: i8,
        /// Degree of freedom.
        degree: u8,
    },
    /// A number that is not finite, or not positive where it must be.
    #[error("{what} of the field is {value}")]
    Number {
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Numbers at the nodes of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeGroup {
    /// Real parts.
    pub re: [f64; GROUP],
    /// Imaginary parts.
    pub im: [f64; GROUP],
}

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldEvaluator {
    /// Highest κ = kR of the field.
    pub max_wavenumber: f64,
    /// Decay time, in R/c.
    pub ring_time: f64,
    nodes: Vec<Node>,
    /// s at the nodes; the last group is padded with ones.
    places: Vec<NodeGroup>,
    /// 1/θₙ(s), or s² for n = 0: for each order, for each group.
    inverses: Vec<NodeGroup>,
    /// Ranges of the rows of each order.
    rows: Vec<Range<usize>>,
    /// Index of the factor of each row: degree times number of harmonics, plus harmonic.
    factors: Vec<u32>,
    /// For each order, each [`MOST_GROUPS`] groups, each row, each group: the values at its nodes, real parts
    /// first.
    values: Vec<[f32; 2 * GROUP]>,
    harmonics: HarmonicTable,
}

/// Memory for [`FieldEvaluator::at_nodes`], to be used again.
#[derive(Clone, Debug, Default)]
pub struct FieldScratch {
    harmonics: Vec<f64>,
    factors: Vec<f32>,
}

impl FieldEvaluator {
    /// Validates a field and computes its layout.
    ///
    /// # Errors
    /// [`FieldError`] for an inconsistent field, or numbers that are not finite.
    pub fn try_new(field: &AccelerationField) -> Result<Self, FieldError> {
        check(field)?;
        let order = field.order();
        let groups = field.nodes.len().div_ceil(GROUP);
        // s and 1/θₙ(s) at the nodes, by groups.
        let mut places = vec![NodeGroup { re: [1.0; GROUP], im: [0.0; GROUP] }; groups];
        let mut inverses = vec![NodeGroup::default(); (order + 1) * groups];
        let mut theta = Vec::new();
        for (j, node) in field.nodes.iter().enumerate() {
            let (group, lane) = (j / GROUP, j % GROUP);
            places[group].re[lane] = node.s.re;
            places[group].im[lane] = node.s.im;
            reverse_bessel(node.s, order, &mut theta);
            if let Some(value) = theta.iter().map(|t| t.norm()).find(|t| !t.is_finite() || *t > 1e300) {
                return Err(FieldError::Number { what: "the size of a wave at a node", value });
            }
            for n in 0..=order {
                let inverse = if n == 0 { node.s * node.s } else { theta[n].inv() };
                let at = &mut inverses[n * groups + group];
                (at.re[lane], at.im[lane]) = (inverse.re, inverse.im);
            }
        }
        // Terms of each order.
        let rows: Vec<Range<usize>> = (0..=order)
            .map(|n| {
                let first = field.terms.partition_point(|t| usize::from(t.n) < n);
                first..field.terms.partition_point(|t| usize::from(t.n) <= n)
            })
            .collect();
        // Index of the factor z_i Y_nm of each term.
        let factor =
            |t: &Term| usize::from(t.degree) * count(order) + index(usize::from(t.n), isize::from(t.m));
        let factors = field.terms.iter().map(|t| factor(t) as u32).collect();
        // Coefficients in the order in which they are summed.
        let mut values = Vec::with_capacity(groups * field.terms.len());
        for range in &rows {
            for first in (0..groups).step_by(MOST_GROUPS) {
                for row in range.clone() {
                    for group in first..groups.min(first + MOST_GROUPS) {
                        let mut lanes = [0.0; 2 * GROUP];
                        for lane in 0..GROUP.min(field.nodes.len() - group * GROUP) {
                            let at = row * field.nodes.len() + group * GROUP + lane;
                            lanes[lane] = field.real[at];
                            lanes[GROUP + lane] = field.imaginary[at];
                        }
                        values.push(lanes);
                    }
                }
            }
        }
        Ok(FieldEvaluator {
            max_wavenumber: field.max_wavenumber,
            ring_time: field.ring_time,
            nodes: field.nodes.clone(),
            places,
            inverses,
            rows,
            factors,
            values,
            harmonics: HarmonicTable::new(order),
        })
    }

    /// The nodes of the interpolation in frequency.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Highest order of any term.
    pub fn order(&self) -> usize {
        self.rows.len() - 1
    }

    /// p e^{s|x|}/(ρ R) at every node, for z = (a, R α), at `x` in units of R, |x| ≥ 1. Equals
    /// [`AccelerationField::at_nodes`] up to the rounding of single precision. Lanes without a node get zero.
    pub fn at_nodes(
        &self,
        z: &[f64; RIGID_DOFS],
        x: DVec3,
        scratch: &mut FieldScratch,
        values: &mut Vec<NodeGroup>,
    ) {
        let groups = self.places.len();
        values.clear();
        values.resize(groups, NodeGroup::default());
        // The range of single precision is smaller than that of impulses.
        let size = z.iter().fold(0.0f64, |m, z| m.max(z.abs()));
        let distance = x.length();
        if size == 0.0 {
            return;
        }
        self.harmonics.evaluate(x / distance, &mut scratch.harmonics);
        scratch.factors.clear();
        for z in z {
            let z = z / size;
            scratch.factors.extend(scratch.harmonics.iter().map(|y| (z * y) as f32));
        }
        let factors = &scratch.factors;
        Arch::new().dispatch(Sum { field: self, factors, nearness: 1.0 / distance, size, values });
    }
}

/// The sum over terms and orders, for the vector instructions of the machine.
struct Sum<'a> {
    field: &'a FieldEvaluator,
    factors: &'a [f32],
    /// 1/x.
    nearness: f64,
    /// Factor on everything.
    size: f64,
    values: &'a mut [NodeGroup],
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let groups = self.field.places.len();
        for first in (0..groups).step_by(MOST_GROUPS) {
            match groups - first {
                1 => sum_groups::<S, 1, 4>(simd, &mut self, first),
                2 => sum_groups::<S, 2, 2>(simd, &mut self, first),
                _ => sum_groups::<S, MOST_GROUPS, 2>(simd, &mut self, first),
            }
        }
    }
}

/// The sums of G groups from the `first`.
#[inline(always)]
fn sum_groups<S: Simd, const G: usize, const PARTS: usize>(simd: S, sum: &mut Sum<'_>, first: usize) {
    let Sum { field, factors, nearness, size, ref mut values } = *sum;
    let groups = field.places.len();
    let places = &field.places[first..first + G];
    // τₙ and τₙ₋₁.
    let mut here = [NodeGroup { re: [1.0; GROUP], im: [0.0; GROUP] }; G];
    let mut before = [NodeGroup::default(); G];
    let mut total = before;
    let mut begin = 0;
    for (n, range) in field.rows.iter().enumerate() {
        if n > 0 {
            for group in 0..G {
                let s = &places[group];
                let next = match n {
                    1 => first_order(s, nearness),
                    _ => step(s, &here[group], &before[group], nearness, n),
                };
                (before[group], here[group]) = (here[group], next);
            }
        }
        if range.is_empty() {
            continue;
        }
        let rows = &field.values[begin + first * range.len()..][..G * range.len()];
        begin += groups * range.len();
        let sums = contract::<S, G, PARTS>(simd, factors, &field.factors[range.clone()], rows);
        for group in 0..G {
            let inverse = &field.inverses[n * groups + first + group];
            add_order(&mut total[group], &here[group], inverse, &sums[group], size * nearness);
        }
    }
    values[first..first + G].copy_from_slice(&total);
}

/// τ₁ = s + 1/x.
#[inline(always)]
fn first_order(s: &NodeGroup, nearness: f64) -> NodeGroup {
    let mut next = *s;
    next.re.iter_mut().for_each(|re| *re += nearness);
    next
}

/// τₙ = (2n−1)/x τₙ₋₁ + s² τₙ₋₂.
#[inline(always)]
fn step(s: &NodeGroup, here: &NodeGroup, before: &NodeGroup, nearness: f64, n: usize) -> NodeGroup {
    let a = (2 * n - 1) as f64 * nearness;
    let mut next = NodeGroup::default();
    for lane in 0..GROUP {
        let (re, im) = (s.re[lane], s.im[lane]);
        let (square_re, square_im) = (re * re - im * im, 2.0 * re * im);
        next.re[lane] = a * here.re[lane] + (square_re * before.re[lane] - square_im * before.im[lane]);
        next.im[lane] = a * here.im[lane] + (square_re * before.im[lane] + square_im * before.re[lane]);
    }
    next
}

/// Σ factor · values over the rows of one order and G groups, in PARTS alternating sums, so that an addition
/// does not depend on the one before it.
#[inline(always)]
fn contract<S: Simd, const G: usize, const PARTS: usize>(
    simd: S,
    factors: &[f32],
    places: &[u32],
    rows: &[[f32; 2 * GROUP]],
) -> [[f32; 2 * GROUP]; G] {
    let mut parts = [[[0.0; 2 * GROUP]; G]; PARTS];
    let (turns, rest) = places.as_chunks::<PARTS>();
    let (rows, _) = rows.as_chunks::<G>();
    let (row_turns, row_rest) = rows.as_chunks::<PARTS>();
    for (places, rows) in turns.iter().zip(row_turns) {
        for ((part, place), row) in parts.iter_mut().zip(places).zip(rows) {
            add_row(simd, part, factors[*place as usize], row);
        }
    }
    for (place, row) in rest.iter().zip(row_rest) {
        add_row(simd, &mut parts[0], factors[*place as usize], row);
    }
    let mut total = parts[0];
    for part in &parts[1..] {
        total.as_flattened_mut().iter_mut().zip(part.as_flattened()).for_each(|(t, p)| *t += p);
    }
    total
}

/// Adds factor · row.
#[inline(always)]
fn add_row<S: Simd, const G: usize>(
    simd: S,
    sums: &mut [[f32; 2 * GROUP]; G],
    factor: f32,
    row: &[[f32; 2 * GROUP]; G],
) {
    let factor = simd.splat_f32s(factor);
    let registers = S::as_simd_f32s(row.as_flattened()).0;
    for (sum, register) in S::as_mut_simd_f32s(sums.as_flattened_mut()).0.iter_mut().zip(registers) {
        *sum = simd.mul_add_e_f32s(factor, *register, *sum);
    }
}

/// Adds scale · τ · (1/θ) · sums.
#[inline(always)]
fn add_order(
    value: &mut NodeGroup,
    tau: &NodeGroup,
    inverse: &NodeGroup,
    sums: &[f32; 2 * GROUP],
    scale: f64,
) {
    for lane in 0..GROUP {
        let (re, im) = (scale * f64::from(sums[lane]), scale * f64::from(sums[GROUP + lane]));
        let factor_re = tau.re[lane] * inverse.re[lane] - tau.im[lane] * inverse.im[lane];
        let factor_im = tau.re[lane] * inverse.im[lane] + tau.im[lane] * inverse.re[lane];
        value.re[lane] += factor_re * re - factor_im * im;
        value.im[lane] += factor_re * im + factor_im * re;
    }
}

/// Rejects fields that would put NaN or wrong values into the sound.
fn check(field: &AccelerationField) -> Result<(), FieldError> {
    let AccelerationField { nodes, terms, real, imaginary, .. } = field;
    let expected = terms.len() * nodes.len();
    if real.len() != expected || imaginary.len() != expected {
        let (terms, nodes, real, imaginary) = (terms.len(), nodes.len(), real.len(), imaginary.len());
        return Err(FieldError::Lengths { terms, nodes, expected, real, imaginary });
    }
    if nodes.is_empty() {
        return Err(FieldError::NoNodes);
    }
    for (index, term) in terms.iter().enumerate() {
        let exists = usize::from(term.n) <= MAX_ORDER
            && isize::from(term.m).unsigned_abs() <= usize::from(term.n)
            && usize::from(term.degree) < RIGID_DOFS;
        if !exists || (index > 0 && terms[index - 1] >= *term) {
            return Err(FieldError::Term { index, n: term.n, m: term.m, degree: term.degree });
        }
    }
    let number = |what, value: f64, fine: bool| {
        if fine && value.is_finite() { Ok(()) } else { Err(FieldError::Number { what, value }) }
    };
    number("the highest wavenumber", field.max_wavenumber, field.max_wavenumber > 0.0)?;
    number("the ring time", field.ring_time, field.ring_time > 0.0)?;
    for node in nodes {
        let Complex64 { re, im } = node.s;
        // θₙ has no zero where waves do not grow.
        number("the real part of a node", re, re >= 0.0)?;
        number("the imaginary part of a node", im, true)?;
        number("the real part of a weight", node.weight.re, true)?;
        number("the imaginary part of a weight", node.weight.im, true)?;
    }
    for value in real.iter().chain(imaginary) {
        number("a coefficient", f64::from(*value), true)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// A field with every term up to `order`, of random coefficients.
    fn random_field(order: usize, nodes: usize) -> AccelerationField {
        let mut random = SplitMix::new(7);
        let mut number = || random.uniform(-0.5, 0.5);
        let terms: Vec<Term> = (0..=order as u8)
            .flat_map(|n| (-(n as i8)..=n as i8).map(move |m| (n, m)))
            .flat_map(|(n, m)| (0..6).map(move |degree| Term { n, m, degree }))
            .collect();
        let nodes: Vec<Node> = (0..nodes)
            .map(|j| Node {
                s: Complex64::new(0.1, 0.7 * j as f64),
                weight: Complex64::new(number(), number()),
            })
            .collect();
        let count = terms.len() * nodes.len();
        AccelerationField {
            max_wavenumber: 10.0,
            ring_time: 10.0,
            real: (0..count).map(|_| number() as f32).collect(),
            imaginary: (0..count).map(|_| number() as f32).collect(),
            nodes,
            terms,
        }
    }

    #[test]
    fn plays_what_the_field_says() {
        let (mut scratch, mut values) = (FieldScratch::default(), Vec::new());
        for (order, nodes) in [(0, 1), (1, 3), (12, 16), (30, 21)] {
            let field = random_field(order, nodes);
            let playable = FieldEvaluator::try_new(&field).unwrap();
            for (x, size) in [(DVec3::new(0.6, -0.9, 0.3), 1.0), (DVec3::new(40.0, 3.0, 8e4), 1e-60)] {
                let z = [1.0, -0.3, 0.2, 0.0, 0.4, -0.7].map(|z| z * size);
                let expected = field.at_nodes(&z, x);
                playable.at_nodes(&z, x, &mut scratch, &mut values);
                let largest = expected.iter().map(|v| v.norm()).fold(0.0, f64::max);
                for (j, e) in expected.iter().enumerate() {
                    let v = Complex64::new(values[j / GROUP].re[j % GROUP], values[j / GROUP].im[j % GROUP]);
                    // Residual seen: 2e-7, of single precision.
                    assert!((v - e).norm() < 1e-6 * largest, "{order} {j}: {v} against {e}");
                }
            }
        }
    }

    #[test]
    fn fields_that_contradict_themselves_are_refused() {
        let good = random_field(2, 4);
        assert!(FieldEvaluator::try_new(&good).is_ok());
        let mut short = good.clone();
        short.real.pop();
        assert!(matches!(FieldEvaluator::try_new(&short), Err(FieldError::Lengths { .. })));
        let empty = AccelerationField { nodes: vec![], real: vec![], imaginary: vec![], ..good.clone() };
        assert_eq!(FieldEvaluator::try_new(&empty), Err(FieldError::NoNodes));
        let mut twice = good.clone();
        twice.terms[3] = twice.terms[2];
        assert!(matches!(FieldEvaluator::try_new(&twice), Err(FieldError::Term { index: 3, .. })));
        let mut high = good.clone();
        high.terms[0].m = 1;
        assert!(matches!(FieldEvaluator::try_new(&high), Err(FieldError::Term { index: 0, .. })));
        let mut growing = good.clone();
        growing.nodes[1].s.re = -0.1;
        assert!(matches!(FieldEvaluator::try_new(&growing), Err(FieldError::Number { .. })));
        for bad in [f32::NAN, f32::INFINITY] {
            let mut field = good.clone();
            field.imaginary[9] = bad;
            assert!(matches!(FieldEvaluator::try_new(&field), Err(FieldError::Number { .. })));
        }
        let silent = AccelerationField { ring_time: f64::NAN, ..good };
        assert!(matches!(FieldEvaluator::try_new(&silent), Err(FieldError::Number { .. })));
    }
}
