//! The Loewner matrix of a rational fit: the linearised residual as a function of the weights.
//!
//! Sample i and node j, which is a sample too, have for each function f with error scale 1/u
//!
//! ```text
//! d = u (f_i − f_j)/(s_i − s_j),   m = u (f_i − conj f_j)/(s_i − conj s_j)
//! N(s_i) − f_i D(s_i) = −Σ_j [ (d + m) Re w_j + i (d − m) Im w_j ]/u
//! ```
//!
//! Samples that are nodes have no rows. A node adds two real columns and takes away the rows of its sample.
//! The Gram matrix grows by the products of the new columns with all, and loses the products of these rows;
//! it is never rebuilt, unless they were most of a column, whose rounding would remain.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::FunctionSample;

/// Functions of a sample are padded to a multiple of the widest vectors.
const LANES: usize = 8;
/// Columns whose products share the reading of the new ones.
const SHARED: usize = 4;
/// Products below which threads cost more than they save.
const SERIAL: usize = 1 << 21;
/// Rows of a part of the residual, a multiple of the vectors.
const PART: usize = 4096;
/// A column whose square falls below this part has its products computed again.
const CANCELLED: f64 = 1e-2;

/// The columns of the nodes so far, and their products.
pub(super) struct LoewnerMatrix<'a> {
    samples: &'a [FunctionSample],
    /// Samples with rows, in the order of the rows.
    open: Vec<usize>,
    /// Rows of a sample: real parts of all functions, then imaginary parts, each padded by zeros.
    height: usize,
    nodes: Vec<usize>,
    /// Column after column, each with room for the rows of all samples.
    columns: Vec<f64>,
    /// Lower triangle of the Gram matrix, row after row.
    gram: Vec<f64>,
    /// Largest square of each column since its products were computed.
    squares: Vec<f64>,
}

impl<'a> LoewnerMatrix<'a> {
    /// A matrix without nodes; all samples have values of as many functions.
    pub(super) fn new(samples: &'a [FunctionSample]) -> Self {
        let functions = samples.first().map_or(0, |s| s.values.len());
        LoewnerMatrix {
            samples,
            open: (0..samples.len()).collect(),
            height: 2 * functions.max(1).next_multiple_of(LANES),
            nodes: Vec::new(),
            columns: Vec::new(),
            gram: Vec::new(),
            squares: Vec::new(),
        }
    }

    /// The samples that are nodes.
    pub(super) fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// The Gram matrix: row `a`, column `b` ≤ `a`; 2j is the real part of weight j, 2j + 1 the imaginary.
    pub(super) fn product(&self, a: usize, b: usize) -> f64 {
        self.gram[triangle(a) + b]
    }

    /// Makes a sample a node.
    pub(super) fn push(&mut self, sample: usize) {
        self.close(sample);
        let width = 2 * self.nodes.len();
        self.nodes.push(sample);
        let length = self.stride();
        self.columns.resize((width + 2) * length, 0.0);
        let (first, second) = self.columns[width * length..].split_at_mut(length);
        let rows = first.chunks_exact_mut(self.height).zip(second.chunks_exact_mut(self.height));
        for (i, (first, second)) in self.open.iter().zip(rows) {
            fill_rows(&self.samples[*i], &self.samples[sample], first, second);
        }
        self.add_products(width);
    }

    /// L w/u of all functions at each sample with rows, for the real and imaginary parts of the weights:
    /// sample, and the squares of the magnitudes. They are |N − f D|² in units of the error scales.
    pub(super) fn residual(&self, weights: &[f64]) -> Vec<(usize, Vec<f64>)> {
        let length = self.stride();
        let rows = self.open.len() * self.height;
        let mut sums = vec![0.0; rows];
        let part = |(n, sums): (usize, &mut [f64])| {
            let at = n * PART;
            Arch::new().dispatch(Combination { columns: &self.columns, length, at, weights, sums });
        };
        if rows * weights.len() < SERIAL {
            sums.chunks_mut(PART).enumerate().for_each(part);
        } else {
            sums.par_chunks_mut(PART).enumerate().for_each(part);
        }
        let magnitudes = |rows: &[f64]| {
            let (re, im) = rows.split_at(rows.len() / 2);
            re.iter().zip(im).map(|(re, im)| re * re + im * im).collect()
        };
        let functions = self.samples.first().map_or(0, |s| s.values.len());
        let of_sample = |(i, rows): (&usize, &[f64])| {
            let mut squares: Vec<f64> = magnitudes(rows);
            squares.truncate(functions);
            (*i, squares)
        };
        self.open.iter().zip(sums.chunks_exact(self.height)).map(of_sample).collect()
    }

    /// Room of a column.
    fn stride(&self) -> usize {
        self.samples.len() * self.height
    }

    /// Takes the rows of a sample away from all columns and from the Gram matrix. The rows of the last sample
    /// take their place.
    fn close(&mut self, sample: usize) {
        let Some(place) = self.open.iter().position(|i| *i == sample) else { return };
        let (length, height) = (self.stride(), self.height);
        let width = self.squares.len();
        // Products of these rows alone.
        let mut lost = vec![0.0; 2 * width];
        let block = |at: usize| Columns { values: &self.columns, length, rows: at..at + height };
        for first in (0..width).step_by(2) {
            let lost = &mut lost[..2 * (first + 2)];
            Arch::new().dispatch(Products {
                columns: block(place * height),
                range: [0, first + 2],
                first,
                products: lost,
            });
            for (b, pair) in lost.chunks_exact(2).enumerate() {
                for (c, value) in pair.iter().enumerate().filter(|(c, _)| first + c >= b) {
                    self.gram[triangle(first + c) + b] -= value;
                }
            }
        }
        self.open.swap_remove(place);
        let last = self.open.len();
        for column in self.columns.chunks_exact_mut(length) {
            column.copy_within(last * height..(last + 1) * height, place * height);
        }
        // Rounding of what was lost must not remain.
        let cancelled = |c: usize| self.gram[triangle(c) + c] < CANCELLED * self.squares[c];
        if (0..width).any(cancelled) {
            self.gram.clear();
            self.squares.clear();
            (0..width).step_by(2).for_each(|first| self.add_products(first));
        }
    }

    /// Appends the products of two columns with all before them and with themselves.
    fn add_products(&mut self, first: usize) {
        let rows = self.open.len() * self.height;
        let columns = Columns { values: &self.columns, length: self.stride(), rows: 0..rows };
        let mut products = vec![0.0; 2 * (first + 2)];
        let part = |(n, products): (usize, &mut [f64])| {
            let begin = 2 * SHARED * n;
            let range = [begin, begin + products.len() / 2];
            Arch::new().dispatch(Products { columns: columns.clone(), range, first, products });
        };
        if rows * first < SERIAL {
            products.chunks_mut(4 * SHARED).enumerate().for_each(part);
        } else {
            products.par_chunks_mut(4 * SHARED).enumerate().for_each(part);
        }
        for c in 0..2 {
            self.gram.extend(products.iter().skip(c).step_by(2).take(first + c + 1));
            self.squares.push(products[2 * (first + c) + c]);
        }
    }
}

/// Entries of a lower triangle before row `a`.
fn triangle(a: usize) -> usize {
    a * (a + 1) / 2
}

/// The rows of a sample in the two columns of a node.
fn fill_rows(sample: &FunctionSample, node: &FunctionSample, first: &mut [f64], second: &mut [f64]) {
    let (direct, mirrored) = (1.0 / (sample.s - node.s), 1.0 / (sample.s - node.s.conj()));
    let half = first.len() / 2;
    let (first_re, first_im) = first.split_at_mut(half);
    let (second_re, second_im) = second.split_at_mut(half);
    let values = sample.values.iter().zip(&node.values).zip(&sample.weights);
    for (v, ((value, at_node), weight)) in values.enumerate() {
        let d = (value - at_node) * direct * weight;
        let m = (value - at_node.conj()) * mirrored * weight;
        let (sum, difference) = (d + m, Complex64::I * (d - m));
        (first_re[v], first_im[v]) = (sum.re, sum.im);
        (second_re[v], second_im[v]) = (difference.re, difference.im);
    }
}

/// Some rows of the columns.
#[derive(Clone)]
struct Columns<'a> {
    values: &'a [f64],
    length: usize,
    rows: std::ops::Range<usize>,
}

impl<'a> Columns<'a> {
    #[inline(always)]
    fn vectors<S: Simd>(&self, column: usize) -> &'a [S::f64s] {
        S::as_simd_f64s(&self.values[column * self.length..][self.rows.clone()]).0
    }
}

/// Products of columns `range` with the columns `first` and `first + 1`.
struct Products<'a> {
    columns: Columns<'a>,
    range: [usize; 2],
    first: usize,
    products: &'a mut [f64],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Products { columns, range: [mut at, end], first, products } = self;
        let pair = [columns.vectors::<S>(first), columns.vectors::<S>(first + 1)];
        let mut products = products.as_chunks_mut::<2>().0.iter_mut();
        while at + SHARED <= end {
            let shared = [at, at + 1, at + 2, at + 3].map(
                #[inline(always)]
                |c| columns.vectors::<S>(c),
            );
            // The sums come first: the other order would take one product too many.
            for (sums, product) in dot_pairs::<S, SHARED>(simd, shared, pair).into_iter().zip(&mut products) {
                *product = sums;
            }
            at += SHARED;
        }
        while at < end {
            let [sums] = dot_pairs::<S, 1>(simd, [columns.vectors::<S>(at)], pair);
            if let Some(product) = products.next() {
                *product = sums;
            }
            at += 1;
        }
    }
}

/// Products of N columns with a pair; each has the same bits whatever N is.
#[inline(always)]
fn dot_pairs<S: Simd, const N: usize>(
    simd: S,
    columns: [&[S::f64s]; N],
    [x, y]: [&[S::f64s]; 2],
) -> [[f64; 2]; N] {
    let mut sums = [[simd.splat_f64s(0.0); 2]; N];
    for row in 0..x.len().min(y.len()) {
        let (x, y) = (x[row], y[row]);
        for n in 0..N {
            let value = columns[n][row];
            sums[n][0] = simd.mul_add_e_f64s(value, x, sums[n][0]);
            sums[n][1] = simd.mul_add_e_f64s(value, y, sums[n][1]);
        }
    }
    let mut products = [[0.0; 2]; N];
    for n in 0..N {
        products[n] = [simd.reduce_sum_f64s(sums[n][0]), simd.reduce_sum_f64s(sums[n][1])];
    }
    products
}

/// Σ_c weight_c column_c of rows from `at` on.
struct Combination<'a> {
    columns: &'a [f64],
    length: usize,
    at: usize,
    weights: &'a [f64],
    sums: &'a mut [f64],
}

impl WithSimd for Combination<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Combination { columns, length, at, weights, sums } = self;
        let rows = at..at + sums.len();
        let columns = Columns { values: columns, length, rows };
        let (sums, _) = S::as_mut_simd_f64s(sums);
        for (n, weights) in weights.chunks_exact(2).enumerate() {
            let [x, y] = [columns.vectors::<S>(2 * n), columns.vectors::<S>(2 * n + 1)];
            let (u, v) = (simd.splat_f64s(weights[0]), simd.splat_f64s(weights[1]));
            for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
                *sum = simd.mul_add_e_f64s(v, *y, simd.mul_add_e_f64s(u, *x, *sum));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Any numbers; the samples from `loud` on are a million times larger.
    fn samples(count: usize, functions: usize, loud: usize) -> Vec<FunctionSample> {
        let number = |i: usize, v: usize| Complex64::new((1 + i * i + 3 * v) as f64, (i + v * v) as f64);
        let value = |i: usize, v: usize| {
            let z = number(i, v);
            let size = if i >= loud { 1e6 } else { 1.0 };
            size * Complex64::new(z.re.sin(), z.im.cos())
        };
        (0..count)
            .map(|i| FunctionSample {
                s: Complex64::new(0.01, 0.1 + 0.3 * i as f64),
                values: (0..functions).map(|v| value(i, v)).collect(),
                weights: (0..functions).map(|v| 0.5 + 0.1 * v as f64).collect(),
                group: 1,
            })
            .collect()
    }

    /// The Gram matrix by its definition, rows of a sample after another.
    fn direct(samples: &[FunctionSample], nodes: &[usize]) -> Vec<Vec<f64>> {
        let width = 2 * nodes.len();
        let mut gram = vec![vec![0.0; width]; width];
        for sample in (0..samples.len()).filter(|i| !nodes.contains(i)).map(|i| &samples[i]) {
            for (v, value) in sample.values.iter().enumerate() {
                let row: Vec<Complex64> = nodes
                    .iter()
                    .flat_map(|j| {
                        let node = &samples[*j];
                        let u = sample.weights[v];
                        let d = u * (value - node.values[v]) / (sample.s - node.s);
                        let m = u * (value - node.values[v].conj()) / (sample.s - node.s.conj());
                        [d + m, Complex64::I * (d - m)]
                    })
                    .collect();
                for a in 0..width {
                    for b in 0..width {
                        gram[a][b] += (row[a].conj() * row[b]).re;
                    }
                }
            }
        }
        gram
    }

    /// Largest deviation from the definition, relative to the sizes of the two columns.
    fn worst(samples: &[FunctionSample], nodes: &[usize]) -> f64 {
        let mut matrix = LoewnerMatrix::new(samples);
        nodes.iter().for_each(|node| matrix.push(*node));
        let gram = direct(samples, nodes);
        let mut worst = 0.0_f64;
        for a in 0..gram.len() {
            for b in 0..=a {
                let scale = (gram[a][a] * gram[b][b]).sqrt();
                worst = worst.max((matrix.product(a, b) - gram[a][b]).abs() / scale);
            }
        }
        worst
    }

    #[test]
    fn the_gram_matrix_grows_as_defined() {
        let samples = samples(17, 11, 17);
        for count in 1..9 {
            let nodes: Vec<usize> = (0..count).map(|n| (5 * n + 3) % 17).collect();
            let error = worst(&samples, &nodes);
            // Rounding of some hundred terms.
            assert!(error < 1e-13, "{count} nodes: {error:e}");
        }
    }

    #[test]
    fn loud_samples_leave_no_rounding_behind() {
        // All loud samples become nodes: what remains is 1e-12 of what was there.
        let samples = samples(17, 11, 14);
        let error = worst(&samples, &[0, 14, 16, 3, 15]);
        // The first node's columns keep only quiet rows; subtraction alone would leave the
        // rounding of 1e12 times their squares.
        assert!(error < 1e-13, "{error:e}");
    }

    #[test]
    fn the_residual_is_the_matrix_times_the_weights() {
        let samples = samples(9, 5, 9);
        let mut matrix = LoewnerMatrix::new(&samples);
        [2, 7, 4].iter().for_each(|node| matrix.push(*node));
        let weights = [0.3, -0.2, 0.5, 0.1, -0.4, 0.6];
        let gram = direct(&samples, &[2, 7, 4]);
        let expected: f64 = (0..6)
            .flat_map(|a| (0..6).map(move |b| (a, b)))
            .map(|(a, b)| weights[a] * weights[b] * gram[a][b])
            .sum();
        let residual = matrix.residual(&weights);
        assert_eq!(residual.len(), 6);
        let found: f64 = residual.iter().flat_map(|(_, squares)| squares).sum();
        // Rounding of the two sums.
        assert!((found / expected - 1.0).abs() < 1e-13, "{found} {expected}");
    }

    #[test]
    fn threads_change_no_bits() {
        // Large enough that both loops use them.
        let samples = samples(400, 200, 400);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut matrix = LoewnerMatrix::new(&samples);
                (0..9).for_each(|n| matrix.push(7 * n + 1));
                let weights: Vec<f64> = (0..18).map(|c| (c as f64).cos()).collect();
                let residual = matrix.residual(&weights);
                (matrix.gram, residual)
            })
        };
        assert!(run(1) == run(3));
    }
}
