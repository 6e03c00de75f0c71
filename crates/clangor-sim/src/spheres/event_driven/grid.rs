//! Neighbour search: cells of a regular grid, wrapped periodically into a fixed number of buckets.
//!
//! Cells are at least as wide as the widest ball, so that whatever touches a ball is in its cell or in one of
//! the 26 about it. The grid has no border: cell (i, j, k) lies in bucket (i mod X, j mod Y, k mod Z), and
//! balls of distant cells that share a bucket only cost a comparison. Lists are linked through the balls
//! themselves. Buckets of 4 × 2 × 2 cells share a cache line: the 27 cells about a ball lie in six lines on
//! average, against ten with rows.

use glam::DVec3;

use super::ball::Ball;

/// The end of a list.
pub(super) const NONE: u32 = u32::MAX;
/// The bucket of a ball that is in no cell.
pub(super) const NOWHERE: u32 = u32::MAX;
/// Cells per axis whose buckets share a cache line.
const BLOCK: [u32; 3] = [4, 2, 2];

/// Heads of the lists of balls.
pub(super) struct Grid {
    edge: f64,
    size: [u32; 3],
    heads: Vec<Block>,
}

/// Heads of the lists of a block of cells.
#[derive(Clone)]
#[repr(align(64))]
struct Block([u32; 16]);

/// First balls of some cells that are not empty.
pub(super) struct Heads {
    /// 27 at most.
    balls: [u32; 32],
    count: usize,
}

impl Heads {
    /// The balls.
    #[inline]
    pub(super) fn iter(&self) -> impl Iterator<Item = u32> {
        self.balls.iter().copied().take(self.count)
    }
}

impl Grid {
    /// A grid of cells `edge` wide \[m\] (infinite: one cell) with buckets for cells between two corners.
    pub(super) fn new(edge: f64, low: DVec3, high: DVec3, balls: usize) -> Self {
        // At least four per axis, so that the 27 cells about a ball are 27 buckets; one more than the balls
        // span, so that a box of balls does not wrap onto itself.
        let mut size =
            ((high - low) / edge).to_array().map(|cells| (cells.ceil() as u32).saturating_add(1).max(4));
        while size.iter().map(|&n| u64::from(n)).product::<u64>() > 8 * balls.max(16) as u64 {
            let widest =
                if size[0] >= size[1].max(size[2]) { 0 } else { 2 - usize::from(size[1] >= size[2]) };
            size[widest] = size[widest].div_ceil(2).max(4);
        }
        let size = std::array::from_fn(|axis| size[axis].next_multiple_of(BLOCK[axis]));
        let blocks = size.iter().map(|&n| n as usize).product::<usize>() / 16;
        Grid { edge, size, heads: vec![Block([NONE; 16]); blocks] }
    }

    /// Width of a cell \[m\].
    pub(super) fn edge(&self) -> f64 {
        self.edge
    }

    /// The bucket of a cell.
    #[inline]
    pub(super) fn bucket(&self, cell: [i32; 3]) -> u32 {
        (0..3).map(|axis| self.place(self.wrap(cell[axis], axis), axis)).sum()
    }

    /// Contribution of one coordinate of a cell to the number of its bucket.
    #[inline]
    fn place(&self, at: u32, axis: usize) -> u32 {
        match axis {
            0 => at / 4 * 16 + at % 4,
            1 => at / 2 * (4 * self.size[0]) + at % 2 * 4,
            _ => at / 2 * (2 * self.size[0] * self.size[1]) + at % 2 * 8,
        }
    }

    #[inline]
    fn wrap(&self, at: i32, axis: usize) -> u32 {
        // Cells are within ±10⁹, buckets per axis are fewer: nothing overflows.
        at.rem_euclid(self.size[axis] as i32) as u32
    }

    #[inline]
    fn head_mut(&mut self, bucket: u32) -> &mut u32 {
        &mut self.heads[bucket as usize / 16].0[bucket as usize % 16]
    }

    /// Empties all lists; the balls still have to be put back.
    pub(super) fn clear(&mut self) {
        self.heads.fill(Block([NONE; 16]));
    }

    /// Inserts a ball that is in no list into the list of its cell.
    pub(super) fn insert(&mut self, balls: &mut [Ball], ball: usize) {
        let bucket = self.bucket(balls[ball].cell);
        let first = std::mem::replace(self.head_mut(bucket), ball as u32);
        balls[ball].bucket = bucket;
        balls[ball].previous = NONE;
        balls[ball].next = first;
        if first != NONE {
            balls[first as usize].previous = ball as u32;
        }
    }

    /// Removes a ball from its list.
    pub(super) fn remove(&mut self, balls: &mut [Ball], ball: usize) {
        let (previous, next, bucket) = (balls[ball].previous, balls[ball].next, balls[ball].bucket);
        if previous == NONE {
            *self.head_mut(bucket) = next;
        } else {
            balls[previous as usize].next = next;
        }
        if next != NONE {
            balls[next as usize].previous = previous;
        }
        balls[ball].bucket = NOWHERE;
    }

    /// The first balls of the 27 cells about a cell, where there are any.
    #[inline]
    pub(super) fn around(&self, cell: [i32; 3]) -> Heads {
        self.block(cell, [0; 3], [2; 3])
    }

    /// The first balls of the nine cells that come into reach when a ball enters `cell` through face `exit`
    /// of the last one.
    #[inline]
    pub(super) fn ahead(&self, cell: [i32; 3], exit: u8) -> Heads {
        let (mut first, mut last) = ([0; 3], [2; 3]);
        let axis = usize::from(exit / 2);
        if exit % 2 == 1 {
            first[axis] = 2;
        } else {
            last[axis] = 0;
        }
        self.block(cell, first, last)
    }

    #[inline]
    fn block(&self, cell: [i32; 3], first: [usize; 3], last: [usize; 3]) -> Heads {
        let mut heads = Heads { balls: [NONE; 32], count: 0 };
        let near: [[u32; 3]; 3] = std::array::from_fn(|axis| {
            let middle = self.wrap(cell[axis], axis);
            let end = self.size[axis] - 1;
            let (below, above) = (middle.wrapping_sub(1).min(end), middle + 1);
            [below, middle, if above > end { 0 } else { above }].map(|at| self.place(at, axis))
        });
        for &z in &near[2][first[2]..=last[2]] {
            for &y in &near[1][first[1]..=last[1]] {
                for &x in &near[0][first[0]..=last[0]] {
                    let bucket = (x + y + z) as usize;
                    let head = self.heads[bucket / 16].0[bucket % 16];
                    // Branch-free, because empty cells are unpredictable. There are at most 27 heads, and the
                    // mask avoids the bounds check.
                    heads.balls[heads.count & 31] = head;
                    heads.count += usize::from(head != NONE);
                }
            }
        }
        heads
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_has_a_bucket_of_its_own() {
        let grid = Grid::new(1.0, DVec3::ZERO, DVec3::new(4.5, 6.5, 5.0), 1000);
        let [x, y, z] = grid.size.map(|n| n as i32);
        let cells = (0..x).flat_map(|i| (0..y).flat_map(move |j| (0..z).map(move |k| [i, j, k])));
        let mut buckets: Vec<u32> = cells.map(|cell| grid.bucket(cell)).collect();
        buckets.sort_unstable();
        assert_eq!(buckets, (0..grid.size.iter().product()).collect::<Vec<_>>());
        assert_eq!(buckets.len(), 16 * grid.heads.len());
        assert_eq!(grid.bucket([-1, y, z + 1]), grid.bucket([x - 1, 0, 1]));
    }
}
