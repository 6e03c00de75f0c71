//! Dense systems of the boundary elements in single precision: their factors, and solutions with them.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::linalg::matmul::matmul;
use faer::perm::{PermRef, permute_rows_in_place, permute_rows_in_place_scratch};
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::{Complex32, Complex64};

use super::few_columns::{FEW, add_product, solve_factors};

/// Equations of the six motions at one wavenumber, lengths in R.
#[derive(Clone, Debug)]
pub struct DenseSystem {
    pub(super) wavenumber: f64,
    pub(super) systems: Vec<ClassSystem>,
}

/// Equations of the motions of one parity class.
#[derive(Clone, Debug)]
pub(super) struct ClassSystem {
    pub(super) size: usize,
    /// Column by column.
    pub(super) matrix: Vec<Complex32>,
    pub(super) right: Vec<Complex32>,
}

/// A factorised matrix.
#[derive(Clone, Debug)]
pub(super) struct Factors {
    size: usize,
    /// Both triangles, column by column.
    both: Vec<Complex32>,
    forward: Vec<usize>,
    backward: Vec<usize>,
}

/// Which matrix of a factorisation is solved.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Own,
    Transposed,
}

impl DenseSystem {
    /// Wavenumber [1/m].
    pub fn wavenumber(&self) -> f64 {
        self.wavenumber
    }

    /// The unknowns of each parity class, one motion after the other.
    pub fn solve(self) -> Vec<Vec<Complex32>> {
        self.systems.into_iter().map(ClassSystem::solve).collect()
    }
}

impl ClassSystem {
    /// The unknowns of each motion, one motion after the other.
    pub(super) fn solve(self) -> Vec<Complex32> {
        let Self { size, matrix, mut right } = self;
        Factors::new(matrix, size).solve(&mut right);
        right
    }

    /// The same for the transposed matrix.
    pub(super) fn solve_transposed(self) -> Vec<Complex32> {
        let Self { size, matrix, mut right } = self;
        Factors::new(matrix, size).solve_side(&mut right, Side::Transposed);
        right
    }
}

impl Factors {
    /// Factorises a matrix, column by column, in place.
    pub(super) fn new(mut matrix: Vec<Complex32>, size: usize) -> Self {
        let (mut forward, mut backward) = (vec![0_usize; size], vec![0_usize; size]);
        let need = factor::lu_in_place_scratch::<usize, Complex32>(size, size, Par::Seq, Default::default());
        factor::lu_in_place(
            MatMut::from_column_major_slice_mut(&mut matrix, size, size),
            &mut forward,
            &mut backward,
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(need)),
            Default::default(),
        );
        Self { size, both: matrix, forward, backward }
    }

    /// Replaces right-hand sides, one after the other, by the solutions.
    pub(super) fn solve(&self, right: &mut [Complex32]) {
        self.solve_side(right, Side::Own);
    }

    fn solve_side(&self, right: &mut [Complex32], side: Side) {
        let size = self.size;
        let columns = right.len() / size.max(1);
        let factors = MatRef::from_column_major_slice(&self.both, size, size);
        let permutation = PermRef::new_checked(&self.forward, &self.backward, size);
        let mut unknowns = MatMut::from_column_major_slice_mut(right, size, columns);
        let need = solve::solve_in_place_scratch::<usize, Complex32>(size, columns, Par::Seq)
            .or(solve::solve_transpose_in_place_scratch::<usize, Complex32>(size, columns, Par::Seq))
            .or(permute_rows_in_place_scratch::<usize, Complex32>(size, columns));
        let mut buffer = MemBuffer::new(need);
        let stack = MemStack::new(&mut buffer);
        match side {
            Side::Own if columns <= FEW => {
                permute_rows_in_place(unknowns.as_mut(), permutation, stack);
                solve_factors(factors, unknowns);
            }
            Side::Own => solve::solve_in_place(factors, factors, permutation, unknowns, Par::Seq, stack),
            Side::Transposed => {
                solve::solve_transpose_in_place(factors, factors, permutation, unknowns, Par::Seq, stack);
            }
        }
    }
}

/// The product of a square matrix, column by column, with a few vectors, one after the other.
pub(super) fn product(matrix: &[Complex32], size: usize, vectors: &[Complex32]) -> Vec<Complex32> {
    let columns = vectors.len() / size.max(1);
    let mut product = vec![Complex32::ZERO; size * columns];
    let sums = MatMut::from_column_major_slice_mut(&mut product, size, columns);
    let matrix = MatRef::from_column_major_slice(matrix, size, size);
    add_product(sums, 1.0, (matrix, MatRef::from_column_major_slice(vectors, size, columns)));
    product
}

/// The sums of products of columns, Σᵢ aᵢ bᵢ, for each pair of `left` and `right`, column by column of
/// `left`. They are formed in double precision: high multipoles are small differences.
pub(super) fn paired_sums(left: &[Complex32], right: &[Complex64], size: usize) -> Vec<Complex64> {
    /// Columns that are widened at once, so that they stay in the cache.
    const TOGETHER: usize = 16;
    let [lefts, rights] = [left.len(), right.len()].map(|length| length / size.max(1));
    let mut sums = vec![Complex64::ZERO; lefts * rights];
    let others = MatRef::from_column_major_slice(right, size, rights);
    let blocks = left.chunks(TOGETHER * size.max(1)).zip(sums.chunks_mut(TOGETHER * rights.max(1)));
    let mut wide: Vec<Complex64> = Vec::new();
    for (block, sums) in blocks {
        wide.clear();
        wide.extend(block.iter().map(|z| Complex64::new(f64::from(z.re), f64::from(z.im))));
        let columns = block.len() / size.max(1);
        matmul(
            MatMut::from_column_major_slice_mut(sums, rights, columns),
            Accum::Replace,
            others.transpose(),
            MatRef::from_column_major_slice(&wide, size, columns),
            Complex64::new(1.0, 0.0),
            Par::Seq,
        );
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_pairs_are_those_of_each_pair() {
        let (size, lefts, rights) = (5, 37, 3);
        let value = |i: usize| Complex64::new((0.7 * i as f64).sin(), (1.3 * i as f64).cos());
        let left: Vec<Complex32> = (0..size * lefts).map(|i| Complex32::new(i as f32, -0.5)).collect();
        let right: Vec<Complex64> = (0..size * rights).map(value).collect();
        let sums = paired_sums(&left, &right, size);
        assert_eq!(sums.len(), lefts * rights);
        for (a, left) in left.chunks(size).enumerate() {
            for (b, right) in right.chunks(size).enumerate() {
                let pairs = left.iter().zip(right);
                let sum: Complex64 =
                    pairs.map(|(x, y)| Complex64::new(f64::from(x.re), f64::from(x.im)) * y).sum();
                assert!((sums[a * rights + b] - sum).norm() < 1e-11 * (1.0 + sum.norm()), "{a} {b}");
            }
        }
    }
}
