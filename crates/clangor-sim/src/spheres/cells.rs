//! Cubic cells of a world's balls, and the Z-order in which both solvers store the balls.
//!
//! In Z-order, neighbours in space are neighbours in memory.

use clangor_core::body::World;
use glam::DVec3;

use super::bodies::Sphere;

/// Balls this much wider than the median one are kept out of the cells and compared with every ball.
const WIDE: f64 = 3.0;
/// Mean number of balls per cell that the cell width aims at.
const BALLS_PER_CELL: f64 = 0.2;
/// Up to this many balls are compared all with all.
const FEW: i32 = 12;
/// Cell coordinates are clamped to this, far beyond any scene, so that they fit an `i32`.
const FARTHEST: f64 = 1e9;

/// Cell width and extent of a world's balls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    /// Width of a cell \[m\]; infinite for a single cell.
    pub(super) edge: f64,
    /// Lowest corner of the balls in cells \[m\].
    pub(super) low: DVec3,
    /// Highest corner of the balls in cells \[m\].
    pub(super) high: DVec3,
    /// Largest radius of a ball in a cell \[m\].
    pub(super) widest: f64,
}

impl Cells {
    /// Chooses the cells of a world's balls and puts the balls in Z-order of their cells.
    pub(super) fn sort(world: &World, spheres: &mut [Sphere]) -> Self {
        let position = |index: usize| world.bodies[index].pose.position;
        let mut radii: Vec<f64> = spheres.iter().map(|s| s.radius).collect();
        radii.sort_by(f64::total_cmp);
        let widest = radii.get(radii.len() / 2).map_or(0.0, |median| WIDE * median);
        // Bounding box of the balls in cells.
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut inside, mut broadest) = (0, 0.0_f64);
        for &Sphere { body, radius } in spheres.iter().filter(|s| s.radius <= widest) {
            low = low.min(position(body) - radius);
            high = high.max(position(body) + radius);
            inside += 1;
            broadest = broadest.max(radius);
        }
        // Cells are at least as wide as the widest ball in them.
        let edge = if inside <= FEW {
            f64::INFINITY
        } else {
            let volume: f64 = (high - low).to_array().iter().product();
            let roomy = (volume * BALLS_PER_CELL / f64::from(inside)).cbrt();
            (2.0 * broadest * (1.0 + 1e-9)).max(roomy)
        };
        if inside == 0 {
            (low, high) = (DVec3::ZERO, DVec3::ZERO);
        }
        let cells = Cells { edge, low, high, widest };
        spheres.sort_by_key(|s| (interleave(cell_of(position(s.body) - low, edge)), s.body));
        cells
    }
}

/// The cell that holds a point, for cells of width `edge` \[m\].
pub(super) fn cell_of(point: DVec3, edge: f64) -> [i32; 3] {
    (point / edge).floor().clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST)).as_ivec3().to_array()
}

/// Z-order (Morton) code of a cell: the bits of its three coordinates interleaved.
pub(super) fn interleave(cell: [i32; 3]) -> u64 {
    const STEPS: [(u32, u64); 5] = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ];
    let spread = |x: i32| {
        let bits = x.clamp(0, (1 << 21) - 1) as u64;
        STEPS.iter().fold(bits, |code, &(by, mask)| (code | code << by) & mask)
    };
    spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2
}
