//! The dense system of one parity class, to which pairs of triangles add their couplings.

use num_complex::{Complex32, Complex64};

use super::geometry::{Block, Corners};
use super::layout::{GROUP, SUMS};

/// The unknowns of one parity class and the matrix of its system.
#[derive(Debug)]
pub(in crate::bem::triangles) struct ClassMatrix<'a> {
    /// Unknown of each vertex, `u32::MAX` without.
    pub(in crate::bem::triangles) unknowns: &'a [u32],
    /// Sign of each image; 0 leaves it out.
    pub(in crate::bem::triangles) signs: &'a [f64],
    /// Column by column.
    pub(in crate::bem::triangles) matrix: Vec<Complex32>,
    pub(in crate::bem::triangles) size: usize,
}

impl ClassMatrix<'_> {
    /// Adds the coupling of a test vertex with an image of a source vertex.
    pub(in crate::bem::triangles) fn add_entry(
        &mut self,
        image: usize,
        row: u32,
        column: u32,
        value: Complex64,
    ) {
        let (row, column) = (self.unknowns[row as usize] as usize, self.unknowns[column as usize] as usize);
        if row < self.size && column < self.size {
            let value = value * self.signs[image];
            self.matrix[column * self.size + row] += Complex32::new(value.re as f32, value.im as f32);
        }
    }

    /// Adds the couplings of a block of test functions with a group of sources, as [`totals`] has them.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        image: usize,
        block: &Block,
        sources: &[Corners],
        totals: &[[Complex32; 2]],
    ) {
        let sign = self.signs[image] as f32;
        if sign == 0.0 {
            return;
        }
        let n = self.size;
        let height = block.vertices.len();
        // Forward couplings: row of the test vertex, column of the source vertex.
        for (corners, totals) in sources.iter().zip(totals.chunks_exact(height)) {
            let column = self.unknowns[corners.vertex as usize] as usize;
            if column >= n {
                continue;
            }
            let column = &mut self.matrix[column * n..][..n];
            for (vertex, [forward, _]) in block.vertices.iter().zip(totals) {
                if let Some(entry) = column.get_mut(self.unknowns[*vertex as usize] as usize) {
                    *entry += forward * sign;
                }
            }
        }
        // Backward couplings: the reverse.
        for (place, vertex) in block.vertices.iter().enumerate() {
            let column = self.unknowns[*vertex as usize] as usize;
            if column >= n {
                continue;
            }
            let column = &mut self.matrix[column * n..][..n];
            for (corners, totals) in sources.iter().zip(totals.chunks_exact(height)) {
                if let Some(entry) = column.get_mut(self.unknowns[corners.vertex as usize] as usize) {
                    *entry += totals[place][1] * sign;
                }
            }
        }
    }
}

/// Sums over the lanes of each vertex of a group of sources, source after source: for each vertex of a block
/// of test functions, forward and backward.
#[inline(always)]
pub(super) fn totals(sources: &[Corners], sums: &[f32], totals: &mut Vec<[Complex32; 2]>) {
    totals.clear();
    for corners in sources {
        totals.extend(sums.chunks_exact(SUMS * GROUP).map(|sums| {
            let mut total = [[0.0; 2]; 2];
            for at in &corners.places {
                let at = *at as usize;
                for (way, total) in total.iter_mut().enumerate() {
                    let first = way * SUMS / 2 * GROUP + at;
                    total[0] += sums[first];
                    total[1] += sums[first + GROUP];
                }
            }
            total.map(|[re, im]| Complex32::new(re, im))
        }));
    }
}
