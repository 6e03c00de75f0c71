//! Products of a large dense matrix, or of its triangular factors, with few vectors.
//!
//! Every entry of the matrix is read once for a few operations: the time is that of reading it. A general
//! product walks along rows of the matrix, which lie a whole column apart in memory, and waits for each. Here
//! [`WIDTH`] neighbouring columns at a time are read from top to bottom, and triangular factors are solved
//! block by block ([`BLOCK`]), the rest of each block's columns as such a product.
//!
//! Not for many vectors: a general product reads the matrix once for all of them.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex32;

/// Most vectors for which this is faster than a general product.
pub(super) const FEW: usize = 32;
/// Columns that are read side by side.
const WIDTH: usize = 8;
/// Unknowns of a diagonal block.
const BLOCK: usize = 64;

/// Adds `factor` times a product to `sums`.
pub(super) fn add_product(
    mut sums: MatMut<'_, Complex32>,
    factor: f32,
    (matrix, vectors): (MatRef<'_, Complex32>, MatRef<'_, Complex32>),
) {
    let columns = matrix.ncols();
    for first in (0..columns).step_by(WIDTH) {
        let width = WIDTH.min(columns - first);
        let (matrix, vectors) = (matrix.subcols(first, width), vectors.subrows(first, width));
        matmul(sums.as_mut(), Accum::Add, matrix, vectors, Complex32::new(factor, 0.0), Par::Seq);
    }
}

/// Replaces x by the solution of L U x = `x`, both triangles in one matrix, the diagonal of L ones.
pub(super) fn solve_factors(both: MatRef<'_, Complex32>, mut x: MatMut<'_, Complex32>) {
    let size = both.nrows();
    let blocks = || (0..size).step_by(BLOCK).map(|first| (first, BLOCK.min(size - first)));
    // L from the top: each block, then what its unknowns leave of the rows below.
    for (first, width) in blocks() {
        let (above, mut below) = x.as_mut().split_at_row_mut(first + width);
        let mut own = above.subrows_mut(first, width);
        let block = both.submatrix(first, first, width, width);
        solve_unit_lower_triangular_in_place(block, own.as_mut(), Par::Seq);
        let rest = both.submatrix(first + width, first, size - first - width, width);
        add_product(below.as_mut(), -1.0, (rest, own.as_ref()));
    }
    // U from the bottom.
    for (first, width) in blocks().rev() {
        let (mut above, below) = x.as_mut().split_at_row_mut(first);
        let mut own = below.subrows_mut(0, width);
        let block = both.submatrix(first, first, width, width);
        solve_upper_triangular_in_place(block, own.as_mut(), Par::Seq);
        add_product(above.as_mut(), -1.0, (both.submatrix(0, first, first, width), own.as_ref()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of up to n^{−1/2}, the diagonal of about 2: its triangles are well conditioned.
    fn matrix(size: usize) -> Vec<Complex32> {
        let wave = |i: usize, rate: f32| (rate * i as f32 % 71.0).sin() / (size as f32).sqrt();
        let entry = |i: usize| {
            let own = if i.is_multiple_of(size + 1) { 2.0 } else { 0.0 };
            Complex32::new(own + wave(i, 1.7), wave(i, 2.3))
        };
        (0..size * size).map(entry).collect()
    }

    fn length(x: impl Iterator<Item = Complex32>) -> f32 {
        x.map(|z| z.norm_sqr()).sum::<f32>().sqrt()
    }

    #[test]
    fn products_and_solutions_with_few_vectors_are_those_by_definition() {
        for (size, count) in [(1, 1), (63, 2), (64, 3), (200, 3), (331, 7)] {
            let entries = matrix(size);
            let vectors: Vec<Complex32> = matrix(size.max(count))[..size * count].to_vec();
            let x = MatRef::from_column_major_slice(&vectors, size, count);
            let a = MatRef::from_column_major_slice(&entries, size, size);
            let mut sums = vec![Complex32::new(0.25, 0.0); size * count];
            add_product(MatMut::from_column_major_slice_mut(&mut sums, size, count), -2.0, (a, x));
            let by_definition = |row: usize, column: usize| {
                let sum: Complex32 = (0..size).map(|j| a[(row, j)] * x[(j, column)]).sum();
                0.25 - 2.0 * sum
            };
            let off = |k: usize| sums[k] - by_definition(k % size, k / size);
            let share = length((0..sums.len()).map(off)) / length(sums.iter().copied());
            // Triangles of the same matrix: L (U y) must be x again.
            let mut solution = vectors.clone();
            solve_factors(a, MatMut::from_column_major_slice_mut(&mut solution, size, count));
            let back = |k: usize| {
                let (row, column) = (k % size, k / size);
                let upper = |i: usize| -> Complex32 {
                    (i..size).map(|j| a[(i, j)] * solution[column * size + j]).sum()
                };
                (0..row).map(|i| a[(row, i)] * upper(i)).sum::<Complex32>() + upper(row) - vectors[k]
            };
            let left = length((0..size * count).step_by(5).map(back)) / length(vectors.iter().copied());
            println!("{size} unknowns, {count} vectors: {share:.1e}, {left:.1e}");
            // Residuals seen: 5e-7 and 4e-7.
            assert!(share < 1e-5 && left < 1e-4);
        }
    }
}
