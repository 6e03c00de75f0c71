//! Updates of the cells of a row in vectors of any width.
//!
//! Rows are some hundred cells long, and the widest vectors have 16. Cells that fill no vector would take as
//! long as all others if they were updated one by one: the last vector overlaps the one before it instead.
//! Its values are computed first, from what the row held, and set last. Each cell has the same bits whatever
//! the width.

use pulp::Simd;

use crate::bem::triangles::lanes::Lanes;

/// The cells of one vector of a row.
#[derive(Clone, Copy)]
pub(super) struct Block<S: Simd> {
    simd: S,
    first: usize,
}

impl<S: Simd> Block<S> {
    /// The values of a row here.
    #[inline(always)]
    pub(super) fn of(&self, row: &[f32]) -> Lanes<S> {
        Lanes::of(self.simd, S::as_simd_f32s(&row[self.first..self.first + S::F32_LANES]).0[0])
    }

    /// A number in every lane.
    #[inline(always)]
    pub(super) fn splat(&self, value: f32) -> Lanes<S> {
        Lanes::splat(self.simd, value)
    }

    #[inline(always)]
    fn set(&self, row: &mut [f32], values: Lanes<S>) {
        let own = &mut row[self.first..self.first + S::F32_LANES];
        S::as_mut_simd_f32s(own).0[0] = values.register();
    }
}

/// Replaces the cells 0 … n − 1 of a row by what `update` makes of them; n is at least the width of a vector,
/// as the least width of a grid provides.
#[inline(always)]
pub(super) fn update_row<S: Simd>(simd: S, row: &mut [f32], update: impl Fn(Block<S>, Lanes<S>) -> Lanes<S>) {
    let last = Block { simd, first: row.len() - S::F32_LANES };
    let of_last = update(last, last.of(row));
    for first in (0..last.first).step_by(S::F32_LANES) {
        let block = Block { simd, first };
        block.set(row, update(block, block.of(row)));
    }
    last.set(row, of_last);
}

/// The same for three rows of equal length at once.
#[inline(always)]
pub(super) fn update_rows<S: Simd>(
    simd: S,
    rows: [&mut [f32]; 3],
    update: impl Fn(Block<S>, [Lanes<S>; 3]) -> [Lanes<S>; 3],
) {
    let [a, b, c] = rows;
    let last = Block { simd, first: a.len() - S::F32_LANES };
    let of_last = update(last, [last.of(a), last.of(b), last.of(c)]);
    for first in (0..last.first).step_by(S::F32_LANES) {
        let block = Block { simd, first };
        let [x, y, z] = update(block, [block.of(a), block.of(b), block.of(c)]);
        block.set(a, x);
        block.set(b, y);
        block.set(c, z);
    }
    let [x, y, z] = of_last;
    last.set(a, x);
    last.set(b, y);
    last.set(c, z);
}
