//! Supports of a body in cells, whose nodes are not on the body: springs at points of its surface, and of a
//! compact body within it too.
//!
//! ```text
//! springs:  k_q = k A_q/A              A_q: area at a point of the surface in the region, A: of all of them
//! clamps:   k_q = β A_q,  β = 100 E/t  t: typical wall of the body
//! within:   A_q = 100 V_q/t            V_q: volume at a point within
//! ```
//!
//! A clamp gives way by a hundredth of the strain of a wall, and what is held within follows over a hundredth
//! of a wall. Points lie on triangles of the surface, divided until they are short against the cells and the
//! region. Points within are on a grid of the same distance, where this is less than half of a wall. A region
//! that has neither is one point, if the body holds it.

use clangor_core::body::support::{Support, SupportKind};
use clangor_core::geometry::surface_tree::SurfaceTree;
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

/// Area of a point within the body, in its volume over the wall.
const WITHIN: f64 = 100.0;
/// Largest distance of points within, in walls, and most of them.
const PER_WALL: f64 = 0.5;
const MOST_WITHIN: f64 = 2e4;

/// A point of the surface or within it, and its area \[m²\].
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
            let patches = self.patches((surface, wall), support, index)?;
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

    /// Points of the surface in a region, and of a compact body those within it.
    fn patches(
        &self,
        (surface, wall): (&TriMesh, f64),
        support: &Support,
        index: usize,
    ) -> Result<Vec<Patch>, SupportError> {
        let (middle, half) = support.region.bounds();
        let (least, most) = surface.bounds();
        let (low, high) = (least.max(middle - half), most.min(middle + half));
        let narrowest = (high - low).min_element().max(0.1 * (high - low).max_element());
        let edge = self.smallest_edge();
        let longest = (PER_CELL * edge).min(PER_REGION * narrowest).max(1e-6 * edge);
        let mut inside = points_within((surface, wall), support, [low, high], longest);
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
        self.cell_of(point).is_some()
    }
}

/// Points of a region within a compact body, at most `spacing` \[m\] apart, between two corners \[m\].
fn points_within(
    (surface, wall): (&TriMesh, f64),
    support: &Support,
    [low, high]: [DVec3; 2],
    spacing: f64,
) -> Vec<Patch> {
    let extent = (high - low).max(DVec3::ZERO);
    let spacing = spacing.max((extent.element_product() / MOST_WITHIN).cbrt());
    if spacing > PER_WALL * wall || extent.min_element() == 0.0 {
        return Vec::new();
    }
    let counts = (extent / spacing).ceil().max(DVec3::ONE);
    let step = extent / counts;
    let area = WITHIN * step.element_product() / wall;
    let [nx, ny, nz] = counts.to_array().map(|count| count as usize);
    let tree = SurfaceTree::new(surface);
    let is_held = |x: &DVec3| {
        support.region.distance(*x) == 0.0 && tree.signed_distance(surface, *x).is_some_and(|d| d < 0.0)
    };
    let place = |k: usize| {
        let at = [k % nx, k / nx % ny, k / (nx * ny)].map(|k| k as f64 + 0.5);
        low + DVec3::from_array(at) * step
    };
    (0..nx * ny * nz).map(place).filter(is_held).map(|x| (x, area)).collect()
}
