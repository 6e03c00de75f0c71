//! Products of the matrices of a body with eight vectors at once, in vector registers.
//!
//! Each entry is read once for eight vectors and, by symmetry, for both its row and its column. Sums run in
//! the same order on every instruction set.

use glam::DMat3;
use pulp::{Simd, WithSimd};

/// Vectors of a product.
pub(super) const LANES: usize = 8;

type Lanes = [f64; LANES];

/// The matrix of a product.
#[derive(Clone, Copy)]
pub(super) enum Matrix<'a> {
    /// Factors of unit blocks.
    Scalars(&'a [f64]),
    /// 3 × 3 blocks.
    Blocks(&'a [DMat3]),
}

/// A product y = A x, with unknown 3n + c of vector k at `[(3n + c) · LANES + k]`.
pub(super) struct Product<'a> {
    /// Column starts and rows of the entries, row ≥ column.
    pub(super) starts: &'a [usize],
    pub(super) rows: &'a [u32],
    pub(super) matrix: Matrix<'a>,
    pub(super) x: &'a [f64],
    pub(super) y: &'a mut [f64],
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.y.fill(0.0);
        let x = self.x.as_chunks::<LANES>().0;
        let y = self.y.as_chunks_mut::<LANES>().0;
        // Each stored entry acts on its row and, mirrored, on its column.
        for (column, ends) in self.starts.windows(2).enumerate() {
            let own = [x[3 * column], x[3 * column + 1], x[3 * column + 2]];
            let mut sums = [[0.0; LANES]; 3];
            for entry in ends[0]..ends[1] {
                let row = self.rows[entry] as usize;
                let other = [x[3 * row], x[3 * row + 1], x[3 * row + 2]];
                match self.matrix {
                    Matrix::Scalars(scalars) => {
                        for c in 0..3 {
                            add(&mut sums[c], &other[c], scalars[entry]);
                            if row != column {
                                add(&mut y[3 * row + c], &own[c], scalars[entry]);
                            }
                        }
                    }
                    Matrix::Blocks(blocks) => {
                        let block = blocks[entry].to_cols_array_2d();
                        for c in 0..3 {
                            for r in 0..3 {
                                add(&mut sums[c], &other[r], block[c][r]);
                                if row != column {
                                    add(&mut y[3 * row + r], &own[c], block[c][r]);
                                }
                            }
                        }
                    }
                }
            }
            for c in 0..3 {
                add(&mut y[3 * column + c], &sums[c], 1.0);
            }
        }
    }
}

#[inline(always)]
fn add(y: &mut Lanes, x: &Lanes, factor: f64) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}
