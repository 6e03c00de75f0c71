//! Which balls are near: cells of a regular grid, wrapped around into a fixed number of buckets.
//!
//! Cells are at least as wide as the widest ball, so that whatever touches a ball is in its cell or in one of the 26
//! about it. The grid has no border: cell (i, j, k) lies in bucket (i mod X, j mod Y, k mod Z), and balls of distant
//! cells that share a bucket cost a comparison, nothing else. Lists are linked through the balls themselves.

use glam::DVec3;

use super::ball::Ball;

/// The end of a list.
pub(super) const NONE: u32 = u32::MAX;
/// The bucket of a ball that is in no cell.
pub(super) const NOWHERE: u32 = u32::MAX;
/// Cells farther out than this are not told apart; far beyond any scene, it keeps the integers finite.
const FARTHEST: f64 = 1e9;

/// Heads of the lists of balls.
pub(super) struct Grid {
    edge: f64,
    size: [u32; 3],
    heads: Vec<u32>,
}

impl Grid {
    /// A grid of cells `edge` wide [m] (infinite: one cell) with buckets for cells between two corners.
    pub(super) fn new(edge: f64, low: DVec3, high: DVec3, balls: usize) -> Self {
        // At least four per axis, so that the 27 cells about a ball are 27 buckets; one more than the balls span, so
        // that a box of balls does not wrap onto itself.
        let mut size =
            ((high - low) / edge).to_array().map(|cells| (cells.ceil() as u32).saturating_add(1).max(4));
        while size.iter().map(|&n| u64::from(n)).product::<u64>() > 8 * balls.max(16) as u64 {
            let widest =
                if size[0] >= size[1].max(size[2]) { 0 } else { 2 - usize::from(size[1] >= size[2]) };
            size[widest] = size[widest].div_ceil(2).max(4);
        }
        Grid { edge, size, heads: vec![NONE; size.iter().map(|&n| n as usize).product()] }
    }

    /// Width of a cell [m].
    pub(super) fn edge(&self) -> f64 {
        self.edge
    }

    /// The cell that holds a point.
    pub(super) fn cell_of(&self, point: DVec3) -> [i32; 3] {
        (point / self.edge)
            .floor()
            .clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST))
            .as_ivec3()
            .to_array()
    }

    /// The bucket of a cell.
    #[inline]
    pub(super) fn bucket(&self, cell: [i32; 3]) -> u32 {
        let [x, y, z] = std::array::from_fn(|axis| self.wrap(cell[axis], axis));
        (z * self.size[1] + y) * self.size[0] + x
    }

    #[inline]
    fn wrap(&self, at: i32, axis: usize) -> u32 {
        // Cells are within ±10⁹, buckets per axis are fewer: nothing overflows.
        at.rem_euclid(self.size[axis] as i32) as u32
    }

    /// First ball of a bucket.
    #[inline]
    pub(super) fn head(&self, bucket: u32) -> u32 {
        self.heads[bucket as usize]
    }

    /// Empties all lists; the balls still have to be put back.
    pub(super) fn clear(&mut self) {
        self.heads.fill(NONE);
    }

    /// Puts a ball that is in no list into the list of its cell.
    pub(super) fn insert(&mut self, balls: &mut [Ball], ball: usize) {
        let bucket = self.bucket(balls[ball].cell);
        let first = std::mem::replace(&mut self.heads[bucket as usize], ball as u32);
        balls[ball].bucket = bucket;
        balls[ball].previous = NONE;
        balls[ball].next = first;
        if first != NONE {
            balls[first as usize].previous = ball as u32;
        }
    }

    /// Takes a ball out of its list.
    pub(super) fn remove(&mut self, balls: &mut [Ball], ball: usize) {
        let (previous, next, bucket) = (balls[ball].previous, balls[ball].next, balls[ball].bucket);
        if previous == NONE {
            self.heads[bucket as usize] = next;
        } else {
            balls[previous as usize].next = next;
        }
        if next != NONE {
            balls[next as usize].previous = previous;
        }
        balls[ball].bucket = NOWHERE;
    }

    /// Calls `act` with the buckets of the 27 cells about a cell.
    #[inline]
    pub(super) fn around(&self, cell: [i32; 3], act: impl FnMut(u32)) {
        self.block(cell, [0; 3], [2; 3], act);
    }

    /// Calls `act` with the buckets of the nine cells that come into reach when a ball enters `cell` through face
    /// `exit` of the last one.
    #[inline]
    pub(super) fn ahead(&self, cell: [i32; 3], exit: u8, act: impl FnMut(u32)) {
        let (mut first, mut last) = ([0; 3], [2; 3]);
        let axis = usize::from(exit / 2);
        if exit % 2 == 1 {
            first[axis] = 2;
        } else {
            last[axis] = 0;
        }
        self.block(cell, first, last, act);
    }

    #[inline]
    fn block(&self, cell: [i32; 3], first: [usize; 3], last: [usize; 3], mut act: impl FnMut(u32)) {
        let near: [[u32; 3]; 3] = std::array::from_fn(|axis| {
            let middle = self.wrap(cell[axis], axis);
            let end = self.size[axis] - 1;
            let (below, above) = (middle.wrapping_sub(1).min(end), middle + 1);
            [below, middle, if above > end { 0 } else { above }]
        });
        for &z in &near[2][first[2]..=last[2]] {
            for &y in &near[1][first[1]..=last[1]] {
                let row = (z * self.size[1] + y) * self.size[0];
                for &x in &near[0][first[0]..=last[0]] {
                    act(row + x);
                }
            }
        }
    }
}
