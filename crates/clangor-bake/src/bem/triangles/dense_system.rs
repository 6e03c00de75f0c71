//! Dense systems of the boundary elements in single precision: their factors, and solutions with them.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::linalg::matmul::matmul;
use faer::perm::PermRef;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex32;

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
        let unknowns = MatMut::from_column_major_slice_mut(right, size, columns);
        let need = solve::solve_in_place_scratch::<usize, Complex32>(size, columns, Par::Seq)
            .or(solve::solve_transpose_in_place_scratch::<usize, Complex32>(size, columns, Par::Seq));
        let mut buffer = MemBuffer::new(need);
        let stack = MemStack::new(&mut buffer);
        match side {
            Side::Own => solve::solve_in_place(factors, factors, permutation, unknowns, Par::Seq, stack),
            Side::Transposed => {
                solve::solve_transpose_in_place(factors, factors, permutation, unknowns, Par::Seq, stack);
            }
        }
    }
}

/// The product of a square matrix, column by column, with vectors one after the other.
pub(super) fn product(matrix: &[Complex32], size: usize, vectors: &[Complex32]) -> Vec<Complex32> {
    let columns = vectors.len() / size.max(1);
    let mut product = vec![Complex32::ZERO; size * columns];
    matmul(
        MatMut::from_column_major_slice_mut(&mut product, size, columns),
        Accum::Replace,
        MatRef::from_column_major_slice(matrix, size, size),
        MatRef::from_column_major_slice(vectors, size, columns),
        Complex32::new(1.0, 0.0),
        Par::Seq,
    );
    product
}
