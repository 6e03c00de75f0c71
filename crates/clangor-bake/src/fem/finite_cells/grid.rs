//! The grid of cubes around a body.
//!
//! A grid may be shifted against the body by any part of a cell. Of eight positions, that with the fewest
//! cells is taken: fewer nodes for the same resolution.
//!
//! Where a clamp ends inside a cell, the polynomial of the cell vanishes on a part of it, and is small on all
//! of it: the clamp would seem longer by a part of a cell. So a grid has planes at the ends of clamps, with
//! cells that are up to a third smaller where there are several ends. Ends closer than a cell are one.
//!
//! A mirror plane lies between cells too, and only those on its positive side are kept. A plane in the middle
//! of a wall spares no cells: of the planes of a body, those are taken that leave the least work.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

/// Distance that the surface keeps from the outer faces of the grid, in cells, against rounding.
const MARGIN: f64 = 1e-12;
/// Distance of the points that find the cells of a position, in cells.
const PROBES: f64 = 0.25;

/// Least edge of cells for the sake of planes, in the edge asked for.
const LEAST_EDGE: f64 = 2.0 / 3.0;
/// Distance of a plane from the grid, in cells, that is not worth smaller cells.
const CLOSE: f64 = 1e-3;

/// Places along each axis at which the grid has a plane \[m\].
pub(crate) type Planes = [Vec<f64>; 3];

/// A grid of cubes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellGrid {
    /// Lowest corner \[m\].
    pub(crate) origin: DVec3,
    /// Edge of the cells \[m\].
    pub(crate) edge: f64,
    /// Cells along the axes.
    pub(crate) counts: [usize; 3],
    /// Cells below the mirror plane across each axis, which are not kept; none without a plane.
    pub(crate) images: [usize; 3],
}

impl CellGrid {
    /// Power of the number of cells, and of nodes, that the work grows with.
    pub(crate) const WORK: f64 = 1.5;

    /// What the modes of so many cells, or nodes, cost, in any unit.
    pub(crate) fn work_of(count: usize) -> f64 {
        (count as f64).powf(Self::WORK)
    }

    /// A grid around a surface with cells of an edge \[m\], and planes where the cells allow them.
    pub(crate) fn around(surface: &TriMesh, edge: f64, planes: &Planes) -> Self {
        Self::with_fewest_cells(surface.bounds(), &probes(surface, PROBES * edge), edge, planes)
    }

    /// A grid around a surface with cells of an edge \[m\], on one side of some of the mirror planes through
    /// the origin across these axes.
    pub(crate) fn on_one_side(surface: &TriMesh, edge: f64, mirrors: [bool; 3]) -> Self {
        let points = probes(surface, PROBES * edge);
        let some = (1..8_usize).map(|k| [0, 1, 2].map(|a| k >> a & 1 == 1));
        let grid = |planes: [bool; 3]| {
            let at = planes.map(|plane| if plane { vec![0.0] } else { Vec::new() });
            let mut grid = Self::with_fewest_cells(surface.bounds(), &points, edge, &at);
            for a in (0..3).filter(|a| planes[*a]) {
                grid.images[a] = (-grid.origin[a] / edge).round() as usize;
            }
            let parities = planes.iter().filter(|plane| **plane).fold(1.0, |product, _| 2.0 * product);
            (grid, parities * Self::work_of(grid.cells(&points)))
        };
        let some = some.filter(|planes| (0..3).all(|a| mirrors[a] || !planes[a])).map(grid);
        let least = some.fold(grid([false; 3]), |best, next| if next.1 < best.1 { next } else { best });
        least.0
    }

    /// Of eight positions that with the fewest cells.
    fn with_fewest_cells((low, high): (DVec3, DVec3), points: &[DVec3], edge: f64, planes: &Planes) -> Self {
        let aligned = |shifted: usize| {
            // Lowest corner and cells along each axis.
            let along: [(f64, usize); 3] = std::array::from_fn(|a| {
                let cells = |extent: f64| (extent / edge * (1.0 + MARGIN)).ceil().max(1.0);
                match planes[a].first() {
                    Some(plane) => {
                        let below = if *plane > low[a] { cells(plane - low[a]) } else { 0.0 };
                        let above = if *plane < high[a] { cells(high[a] - plane) } else { 0.0 };
                        (plane - edge * below, (below + above) as usize)
                    }
                    None => {
                        let count = cells(high[a] - low[a]) + (shifted >> a & 1) as f64;
                        (0.5 * (low[a] + high[a]) - 0.5 * (count * edge), count as usize)
                    }
                }
            });
            let origin = DVec3::from_array(along.map(|(origin, _)| origin));
            CellGrid { origin, edge, counts: along.map(|(_, count)| count), images: [0; 3] }
        };
        let positions: Vec<CellGrid> = (0..8).map(aligned).collect();
        let counts: Vec<usize> = positions.iter().map(|grid| grid.cells(points)).collect();
        let best = (1..8).fold(0, |best, k| if counts[k] < counts[best] { k } else { best });
        positions[best]
    }

    /// The same grid with cells of half the edge.
    pub(super) fn halved(&self) -> Self {
        CellGrid {
            edge: 0.5 * self.edge,
            counts: self.counts.map(|n| 2 * n),
            images: self.images.map(|n| 2 * n),
            ..*self
        }
    }

    /// Number of kept cells with one of these points.
    fn cells(&self, points: &[DVec3]) -> usize {
        let places = points.iter().map(|p| self.place_of(self.scaled(*p)));
        let mut cells: Vec<[usize; 3]> = places.filter(|place| self.keeps(*place)).collect();
        cells.sort_unstable();
        cells.dedup();
        cells.len()
    }

    /// Whether a cell lies on the positive side of all mirror planes.
    pub(super) fn keeps(&self, place: [usize; 3]) -> bool {
        (0..3).all(|a| place[a] >= self.images[a])
    }

    /// The axes across which there are mirror planes.
    pub(crate) fn mirrored(&self) -> [bool; 3] {
        self.images.map(|below| below > 0)
    }

    /// A point in units of cells from the lowest corner, inside the grid.
    pub(super) fn scaled(&self, at: DVec3) -> DVec3 {
        let counts = DVec3::from_array(self.counts.map(|n| n as f64));
        ((at - self.origin) / self.edge).clamp(DVec3::splat(MARGIN), counts - MARGIN)
    }

    /// A point in units of cells from the lowest corner.
    pub(super) fn units(&self, at: DVec3) -> DVec3 {
        (at - self.origin) / self.edge
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

/// The edge \[m\], `edge` or up to a third less, of a grid that comes close to the most of these planes; the
/// largest of equally good ones.
pub(crate) fn edge_for(planes: &Planes, edge: f64) -> f64 {
    let gaps = planes.iter().flat_map(|ends| ends.iter().skip(1).map(|end| (end - ends[0]).abs()));
    let gaps: Vec<f64> = gaps.filter(|gap| *gap > LEAST_EDGE * edge).collect();
    let missed = |edge: f64| {
        let off = |gap: &f64| (gap / edge - (gap / edge).round()).abs();
        gaps.iter().map(off).map(|off| if off < CLOSE { 0.0 } else { 1.0 + off }).sum::<f64>()
    };
    // Edges of which a gap has a whole number.
    let whole = gaps.iter().flat_map(|gap| {
        let counts = (gap / edge).ceil() as usize..=(gap / (LEAST_EDGE * edge)) as usize;
        counts.map(move |count| gap / count as f64)
    });
    whole.chain([edge]).min_by(|a, b| missed(*a).total_cmp(&missed(*b)).then(b.total_cmp(a))).unwrap_or(edge)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_have_planes_where_they_are_asked_for() {
        let surface = clangor_core::shape::Shape::parse("box:0.1x0.06x0.004").expect("a shape").mesh();
        let (low, high) = surface.bounds();
        for planes in [
            [vec![], vec![0.013], vec![]],
            [vec![-0.04, 0.031], vec![0.013], vec![]],
            [vec![-0.2, 0.2], vec![], vec![0.0]],
        ] {
            let grid = CellGrid::around(&surface, edge_for(&planes, 0.017), &planes);
            assert!(grid.edge <= 0.017 && grid.edge > LEAST_EDGE * 0.0169, "{grid:?}");
            for (a, ends) in planes.iter().enumerate() {
                let scaled = |x: f64| (x - grid.origin[a]) / grid.edge;
                for place in ends.iter().map(|end| scaled(*end)) {
                    assert!((place - place.round()).abs() < 2.0 * CLOSE, "{grid:?} {a} {place}");
                }
                let [low, high] = [low[a], high[a]].map(scaled);
                assert!(low > -1e-9 && high < grid.counts[a] as f64 + 1e-9, "{grid:?} {a}");
            }
        }
    }

    #[test]
    fn ends_closer_than_a_cell_hinder_no_others() {
        let planes = [vec![-0.04, 0.031], vec![0.0, 0.003], vec![]];
        let edge = edge_for(&planes, 0.017);
        assert!((0.071 / edge - 5.0).abs() < 1e-9, "{edge}");
    }
}
