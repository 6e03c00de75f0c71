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
    bits: [u32; 3],
    heads: Vec<u32>,
}

impl Grid {
    /// A grid of cells `edge` wide [m] (infinite: one cell) with buckets for cells between two corners.
    pub(super) fn new(edge: f64, low: DVec3, high: DVec3, balls: usize) -> Self {
        // At least four per axis, so that the 27 cells about a ball are 27 buckets.
        let mut bits = [2; 3];
        let most = (4 * balls.max(16)).ilog2();
        let wanted = ((high - low) / edge).to_array();
        loop {
            let total: u32 = bits.iter().sum();
            let lack = |axis: usize| wanted[axis] / f64::from(1_u32 << bits[axis]);
            let Some(axis) = (0..3).filter(|&k| lack(k) > 1.0).max_by(|&a, &b| lack(a).total_cmp(&lack(b)))
            else {
                break;
            };
            if total >= most {
                break;
            }
            bits[axis] += 1;
        }
        Grid { edge, bits, heads: vec![NONE; 1 << bits.iter().sum::<u32>()] }
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
        let [x, y, z] = self.bits;
        let wrap = |at: i32, bits: u32| (at as u32) & ((1 << bits) - 1);
        (wrap(cell[2], z) << (x + y)) | (wrap(cell[1], y) << x) | wrap(cell[0], x)
    }

    /// First ball of a bucket.
    #[inline]
    pub(super) fn head(&self, bucket: u32) -> u32 {
        self.heads[bucket as usize]
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

    /// Buckets of the 27 cells about a cell.
    #[inline]
    pub(super) fn around(&self, cell: [i32; 3]) -> impl Iterator<Item = u32> + use<> {
        self.block(cell, [-1; 3], [1; 3])
    }

    /// Buckets of the nine cells that come into reach when a ball enters `cell` through face `exit` of the last one.
    #[inline]
    pub(super) fn ahead(&self, cell: [i32; 3], exit: u8) -> impl Iterator<Item = u32> + use<> {
        let (mut low, mut high) = ([-1; 3], [1; 3]);
        let axis = usize::from(exit / 2);
        if exit % 2 == 1 {
            low[axis] = 1;
        } else {
            high[axis] = -1;
        }
        self.block(cell, low, high)
    }

    #[inline]
    fn block(&self, cell: [i32; 3], low: [i32; 3], high: [i32; 3]) -> impl Iterator<Item = u32> + use<> {
        let [bx, by, bz] = self.bits;
        let wrap = |at: i32, bits: u32| (at as u32) & ((1 << bits) - 1);
        (low[2]..=high[2]).flat_map(move |k| {
            let slab = wrap(cell[2].wrapping_add(k), bz) << (bx + by);
            (low[1]..=high[1]).flat_map(move |j| {
                let row = slab | (wrap(cell[1].wrapping_add(j), by) << bx);
                (low[0]..=high[0]).map(move |i| row | wrap(cell[0].wrapping_add(i), bx))
            })
        })
    }
}
