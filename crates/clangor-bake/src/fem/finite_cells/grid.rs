//! The grid of cubes around a body.
//!
//! A grid may be shifted against the body by any part of a cell. Of eight positions, that with the fewest
//! cells is taken: fewer nodes for the same resolution.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

/// Distance that the surface keeps from the outer faces of the grid, in cells, against rounding.
const MARGIN: f64 = 1e-12;
/// Distance of the points that find the cells of a position, in cells.
const PROBES: f64 = 0.25;

/// A grid of cubes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellGrid {
    /// Lowest corner \[m\].
    pub(crate) origin: DVec3,
    /// Edge of the cells \[m\].
    pub(crate) edge: f64,
    /// Cells along the axes.
    pub(crate) counts: [usize; 3],
}

impl CellGrid {
    /// A grid around a surface with cells of an edge \[m\].
    pub(crate) fn around(surface: &TriMesh, edge: f64) -> Self {
        let points = probes(surface, PROBES * edge);
        let (low, high) = surface.bounds();
        let aligned = |shifted: usize| {
            let counts: [usize; 3] = std::array::from_fn(|a| {
                let extent = (high[a] - low[a]) / edge;
                (extent * (1.0 + MARGIN)).ceil().max(1.0) as usize + (shifted >> a & 1)
            });
            let extent = DVec3::from_array(counts.map(|n| n as f64)) * edge;
            CellGrid { origin: 0.5 * (low + high) - 0.5 * extent, edge, counts }
        };
        let cells = |grid: &CellGrid| {
            let mut cells: Vec<[usize; 3]> = points.iter().map(|p| grid.place_of(grid.scaled(*p))).collect();
            cells.sort_unstable();
            cells.dedup();
            cells.len()
        };
        let positions: Vec<CellGrid> = (0..8).map(aligned).collect();
        let counts: Vec<usize> = positions.iter().map(cells).collect();
        let best = (1..8).fold(0, |best, k| if counts[k] < counts[best] { k } else { best });
        positions[best]
    }

    /// A point in units of cells from the lowest corner, inside the grid.
    pub(super) fn scaled(&self, at: DVec3) -> DVec3 {
        let counts = DVec3::from_array(self.counts.map(|n| n as f64));
        ((at - self.origin) / self.edge).clamp(DVec3::splat(MARGIN), counts - MARGIN)
    }

    fn place_of(&self, scaled: DVec3) -> [usize; 3] {
        scaled.to_array().map(|x| x.floor() as usize)
    }

    /// The cell of a scaled point; `None` outside the grid.
    pub(super) fn place(&self, scaled: DVec3) -> Option<[usize; 3]> {
        let inside = (0..3).all(|a| scaled[a] >= 0.0 && scaled[a] < self.counts[a] as f64);
        inside.then(|| self.place_of(scaled))
    }

    /// Middle of a cell \[m\].
    pub(super) fn middle(&self, place: [usize; 3]) -> DVec3 {
        self.origin + self.edge * DVec3::from_array(place.map(|n| n as f64 + 0.5))
    }
}

/// Points on a surface, at most `distance` \[m\] apart along the sides of triangles.
fn probes(surface: &TriMesh, distance: f64) -> Vec<DVec3> {
    let mut points = surface.vertices.clone();
    for t in 0..surface.triangles.len() {
        let [a, b, c] = surface.corners(t);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let parts = (longest / distance).ceil().max(1.0) as usize;
        if parts > 1 {
            for (i, j) in (0..=parts).flat_map(|i| (0..=parts - i).map(move |j| (i, j))) {
                let [u, v] = [i, j].map(|n| n as f64 / parts as f64);
                points.push(a + u * (b - a) + v * (c - a));
            }
        }
    }
    points
}
