//! The dense system of one parity class, to which pairs of triangles add their couplings.

use num_complex::{Complex32, Complex64};

use super::geometry::{Block, Corners};
use super::layout::{GROUP, SUMS};

/// The unknowns of one parity class and the matrix of its system.
#[derive(Debug)]
pub(in crate::bem::triangles) struct ClassMatrix<'a> {
    /// Unknown of each vertex, `u32::MAX` without.
    pub(in crate::bem::triangles) unknowns: &'a [u32],
    /// Sign of each image.
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

    /// Adds the sums of a block of test functions against a group of sources.
    #[inline(always)]
    pub(super) fn add(&mut self, image: usize, block: &Block, sources: &[Corners], sums: &[f32]) {
        let sign = self.signs[image] as f32;
        let n = self.size;
        // Sum over the lanes of one vertex, with the sign of the image.
        let total = |sums: &[f32], corners: &Corners| {
            let (mut re, mut im) = (0.0, 0.0);
            for at in &corners.places {
                re += sums[*at as usize];
                im += sums[*at as usize + GROUP];
            }
            Complex32::new(sign * re, sign * im)
        };
        // Forward couplings: row of the test vertex, column of the source vertex.
        for corners in sources {
            let column = self.unknowns[corners.vertex as usize] as usize;
            if column >= n {
                continue;
            }
            let column = &mut self.matrix[column * n..][..n];
            for (vertex, sums) in block.vertices.iter().zip(sums.chunks_exact(SUMS * GROUP)) {
                if let Some(entry) = column.get_mut(self.unknowns[*vertex as usize] as usize) {
                    *entry += total(&sums[..SUMS / 2 * GROUP], corners);
                }
            }
        }
        // Backward couplings: the reverse.
        for (vertex, sums) in block.vertices.iter().zip(sums.chunks_exact(SUMS * GROUP)) {
            let column = self.unknowns[*vertex as usize] as usize;
            if column >= n {
                continue;
            }
            let column = &mut self.matrix[column * n..][..n];
            for corners in sources {
                if let Some(entry) = column.get_mut(self.unknowns[corners.vertex as usize] as usize) {
                    *entry += total(&sums[SUMS / 2 * GROUP..], corners);
                }
            }
        }
    }
}
