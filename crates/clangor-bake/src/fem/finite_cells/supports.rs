//! Supports of a body in cells, whose nodes are not on the body: springs at points of its surface.
//!
//! ```text
//! springs:  k_q = k A_q/A              A_q: area at a point of the surface in the region, A: of all of them
//! clamps:   k_q = β A_q,  β = 100 E/t  t: typical wall of the body
//! ```
//!
//! A clamp gives way by a hundredth of the strain of a wall. Points lie on triangles of the surface, divided
//! until they are short against the cells and the region; a region inside the body has its middle as point.

use clangor_core::body::support::{Support, SupportKind};
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::FiniteCells;
use crate::fem::ElasticConstants;
use crate::fem::supports::{Holding, PointSpring, SupportError, check};
use crate::quadrature::parts_of_triangle;

/// β t/E.
const CLAMP: f64 = 100.0;
/// Longest side of the triangles of points, in cells and in the shortest extent of the region.
const PER_CELL: f64 = 0.25;
const PER_REGION: f64 = 0.25;
/// Most divisions of a side of a triangle.
const MOST_DIVISIONS: usize = 256;

/// A point of the surface, and its area \[m²\].
type Patch = (DVec3, f64);

impl FiniteCells {
    /// The supports of a body with this surface and typical wall \[m\].
    ///
    /// # Errors
    /// [`SupportError`].
    pub(crate) fn holding(
        &self,
        surface: &TriMesh,
        supports: &[Support],
        constants: &ElasticConstants,
        wall: f64,
    ) -> Result<Holding, SupportError> {
        let mut springs = Vec::new();
        for (index, support) in supports.iter().enumerate() {
            check(support, index)?;
            let patches = self.patches(surface, support, index)?;
            let total: f64 = patches.iter().map(|(_, area)| area).sum();
            let beta = CLAMP * constants.youngs_modulus() / wall;
            springs.extend(patches.into_iter().map(|(place, area)| {
                let (nodes, weights) = self.interpolation(place);
                let (stiffness, damping) = match support.kind {
                    SupportKind::Clamped => (DVec3::splat(beta * area), DVec3::ZERO),
                    SupportKind::Sprung { stiffness, damping } => {
                        (stiffness * (area / total), damping * (area / total))
                    }
                };
                let weights = nodes.iter().copied().zip(weights).collect();
                PointSpring { place, weights, stiffness, damping }
            }));
        }
        Holding::of_springs(springs, self.nodes.len())
    }

    /// Points of the surface in a region.
    fn patches(
        &self,
        surface: &TriMesh,
        support: &Support,
        index: usize,
    ) -> Result<Vec<Patch>, SupportError> {
        let (middle, half) = support.region.bounds();
        let (least, most) = surface.bounds();
        let (low, high) = (least.max(middle - half), most.min(middle + half));
        let narrowest = (high - low).min_element().max(0.1 * (high - low).max_element());
        let longest = (PER_CELL * self.grid.edge).min(PER_REGION * narrowest).max(1e-6 * self.grid.edge);
        let mut inside = Vec::new();
        let mut off = f64::INFINITY;
        for t in 0..surface.triangles.len() {
            let [a, b, c] = surface.corners(t);
            let (least, most) = (a.min(b).min(c), a.max(b).max(c));
            if (least.cmpgt(high) | most.cmplt(low)).any() {
                off = [a, b, c].iter().map(|x| support.region.distance(*x)).fold(off, f64::min);
                continue;
            }
            let side = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let divisions = ((side / longest).ceil() as usize).clamp(1, MOST_DIVISIONS);
            let area = 0.5 * (b - a).cross(c - a).length() / (divisions * divisions) as f64;
            for [u, v] in parts_of_triangle(divisions) {
                let place = a + u * (b - a) + v * (c - a);
                let distance = support.region.distance(place);
                if distance == 0.0 {
                    inside.push((place, area));
                }
                off = off.min(distance);
            }
        }
        if !inside.is_empty() {
            return Ok(inside);
        }
        // A region smaller than the points are apart, or within the body.
        match off <= longest || self.holds(middle) {
            true => Ok(vec![(middle, longest * longest)]),
            false => Err(SupportError::Off { support: index, distance: off }),
        }
    }

    /// Whether a cell of the body holds a point.
    fn holds(&self, point: DVec3) -> bool {
        let scaled = (point - self.grid.origin) / self.grid.edge;
        let held = |place| self.body.cells.binary_search_by_key(&place, |cell| cell.place).is_ok();
        self.grid.place(scaled).is_some_and(held)
    }
}
