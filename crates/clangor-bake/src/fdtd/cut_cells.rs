//! The open part of each grid cell, and of each of its faces, outside a closed triangle surface.
//!
//! The surface is clipped at the grid planes. With N = ∫ n dS over what lies in one cell, n out of the solid,
//! Gauss' theorem in the column of cells along an axis a gives the solid part of the faces exactly, one after
//! the other,
//!
//! ```text
//! solid(upper face) = solid(lower face) − N_a,     V_solid = solid(lower face) − ∫ n_x (x_upper − x) dS
//! ```
//!
//! so that the open faces, the surface and the volume of every cell are consistent to rounding, however thin
//! the solid. The surface is not sampled. Lengths are in cells.

use std::collections::BTreeMap;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;

use crate::radiation::rigid_motions;

/// Tolerance for faces and cells that are open or closed up to rounding.
const ROUNDING: f64 = 1e-9;
/// Empty cells around the body.
const MARGIN: usize = 2;

/// A box of cells that holds the body and some cells around it.
#[derive(Clone, Debug)]
pub(super) struct CutCells {
    /// Lowest cell of the box, counted in the grid.
    pub(super) low: [usize; 3],
    /// Cells of the box along each axis.
    pub(super) size: [usize; 3],
    /// Open part of the upper face of each cell, by axis.
    pub(super) open: [Vec<f64>; 3],
    /// Open volume of each cell.
    pub(super) volume: Vec<f64>,
    /// The surface in the cells that it intersects.
    pub(super) pieces: BTreeMap<usize, Pieces>,
}

/// The surface in one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    /// ∫ g_i dS for the six motions; the first three are ∫ n dS.
    pub(super) flux: [f64; RIGID_DOFS],
    /// ∫ dS.
    pub(super) area: f64,
    /// n dS of each piece.
    pub(super) areas: Vec<DVec3>,
    /// ∫ x dV over the open part, x from the middle of the cell: ∫ n_a (1/4 − x_a²)/2 dS by Gauss' theorem.
    pub(super) moment: DVec3,
}

impl CutCells {
    /// Cuts the cells of a grid in which the centre of mass is at `centre`; `surface` is about it, in cells.
    /// The body is at least [`MARGIN`] cells inside of the grid.
    pub(super) fn new(surface: &TriMesh, centre: DVec3) -> Self {
        let (low_corner, high_corner) = surface.bounds();
        let low = (low_corner + centre).to_array().map(|x| x.floor() as usize - MARGIN);
        let high = (high_corner + centre).to_array().map(|x| x.floor() as usize + MARGIN + 1);
        let size: [usize; 3] = std::array::from_fn(|a| high[a] - low[a]);
        let cells = size.iter().product();
        let mut cut = CutCells {
            low,
            size,
            open: std::array::from_fn(|_| vec![0.0; cells]),
            volume: vec![0.0; cells],
            pieces: BTreeMap::new(),
        };
        // Coordinates of the box: the corner of its lowest cell is 0.
        let centre = centre - DVec3::from_array(low.map(|l| l as f64));
        for t in 0..surface.triangles.len() {
            let corners = surface.corners(t).map(|c| c + centre);
            cut.add(corners.to_vec(), [0; 3], 0, centre);
        }
        cut.integrate();
        cut
    }

    /// Place of a cell of the box.
    pub(super) fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    /// Difference of the indices of neighbours along each axis.
    pub(super) fn strides(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    /// Cuts a piece into slabs along `axis` and the axes after it, and adds what lies in each cell.
    fn add(&mut self, piece: Vec<DVec3>, mut cell: [usize; 3], axis: usize, centre: DVec3) {
        if axis == 3 {
            self.add_to_cell(&piece, cell, centre);
            return;
        }
        let (low, high) = piece
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
        let mut rest = piece;
        let first = low.floor();
        let mut upper = first + 1.0;
        while upper < high {
            let (below, above) = split(&rest, axis, upper);
            cell[axis] = upper as usize - 1;
            self.add(below, cell, axis + 1, centre);
            rest = above;
            upper += 1.0;
        }
        cell[axis] = upper as usize - 1;
        self.add(rest, cell, axis + 1, centre);
    }

    fn add_to_cell(&mut self, piece: &[DVec3], cell: [usize; 3], centre: DVec3) {
        let index = self.index(cell);
        let middle_of_cell = DVec3::from_array(cell.map(|c| c as f64 + 0.5));
        let pieces = self.pieces.entry(index).or_default();
        let Some((a, others)) = piece.split_first() else { return };
        for pair in others.windows(2) {
            let (b, c) = (pair[0], pair[1]);
            let area = 0.5 * (b - a).cross(c - a);
            let middle = (a + b + c) / 3.0;
            (0..3).for_each(|axis| self.open[axis][index] += area[axis]);
            self.volume[index] += area.x * ((cell[0] + 1) as f64 - middle.x);
            for (sum, g) in pieces.flux.iter_mut().zip(rigid_motions(middle - centre, area)) {
                *sum += g;
            }
            pieces.area += area.length();
            pieces.areas.push(area);
            // The midpoints of the edges integrate quadratics exactly.
            for p in [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)] {
                let x = p - middle_of_cell;
                pieces.moment += area * (0.25 - x * x) / 6.0;
            }
        }
    }

    /// From ∫ n dS and ∫ n_x (x_upper − x) dS of each cell to open faces and volumes.
    fn integrate(&mut self) {
        let strides = self.strides();
        for (axis, stride) in strides.into_iter().enumerate() {
            for index in 0..self.volume.len() {
                let first = (index / stride).is_multiple_of(self.size[axis]);
                let lower = if first { 1.0 } else { self.open[axis][index - stride] };
                // The open part grows by N_a as the solid part shrinks.
                self.open[axis][index] += lower;
                if axis == 0 {
                    self.volume[index] += lower;
                }
            }
        }
        for value in self.open.iter_mut().flatten().chain(&mut self.volume) {
            if *value < ROUNDING {
                *value = 0.0;
            } else if *value > 1.0 - ROUNDING {
                *value = 1.0;
            }
        }
    }
}

/// The parts of a convex polygon below and above a plane.
fn split(polygon: &[DVec3], axis: usize, at: f64) -> (Vec<DVec3>, Vec<DVec3>) {
    let (mut below, mut above) = (Vec::with_capacity(6), Vec::with_capacity(6));
    for (k, p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        if p[axis] <= at {
            below.push(*p);
        }
        if p[axis] >= at {
            above.push(*p);
        }
        if (p[axis] < at) != (q[axis] < at) && p[axis] != at && q[axis] != at {
            let mut crossing = p.lerp(q, (at - p[axis]) / (q[axis] - p[axis]));
            crossing[axis] = at;
            below.push(crossing);
            above.push(crossing);
        }
    }
    (below, above)
}

#[cfg(test)]
mod tests {
    use clangor_core::shape::Shape;

    use super::*;

    fn cut(shape: &str, cells_per_metre: f64) -> (CutCells, TriMesh) {
        let (surface, _) = Shape::parse(shape).unwrap().surface().unwrap();
        let mut mesh = match surface {
            clangor_core::body::Surface::Mesh(surface) => surface.mesh,
            _ => Shape::parse(shape).unwrap().mesh(),
        };
        mesh.vertices.iter_mut().for_each(|v| *v *= cells_per_metre);
        (CutCells::new(&mesh, DVec3::new(40.13, 40.71, 40.37)), mesh)
    }

    #[test]
    fn volume_surface_and_faces_close() {
        for (shape, scale) in [("sphere:0.01", 700.0), ("mug", 300.0), ("key", 1000.0), ("coin", 900.0)] {
            let (cut, mesh) = cut(shape, scale);
            let solid: f64 = cut.volume.iter().map(|v| 1.0 - v).sum();
            let expected: f64 =
                (0..mesh.triangles.len()).map(|t| mesh.centroid(t).dot(mesh.area_vector(t)) / 3.0).sum();
            // Residual seen: 3e-13.
            assert!((solid / expected - 1.0).abs() < 1e-8, "{shape}: {solid} {expected}");
            let strides = cut.strides();
            for (index, pieces) in &cut.pieces {
                for (axis, stride) in strides.into_iter().enumerate() {
                    let gap = cut.open[axis][*index] - cut.open[axis][index - stride] - pieces.flux[axis];
                    assert!(gap.abs() < 3e-9, "{shape}: {gap}");
                }
            }
            for degree in 0..RIGID_DOFS {
                let sum: f64 = cut.pieces.values().map(|p| p.flux[degree]).sum();
                // A closed surface; residual seen: 1.2e-11.
                assert!(sum.abs() < 1e-9, "{shape} {degree}: {sum}");
            }
        }
    }

    #[test]
    fn columns_end_open() {
        let (cut, _) = cut("mug", 300.0);
        for index in 0..cut.volume.len() {
            let at = [index % cut.size[0], index / cut.size[0] % cut.size[1], index / cut.strides()[2]];
            for (axis, place) in at.into_iter().enumerate() {
                if place + 1 == cut.size[axis] {
                    assert_eq!(cut.open[axis][index], 1.0);
                }
            }
        }
    }
}
