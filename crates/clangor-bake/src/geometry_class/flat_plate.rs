//! Flat plates of any outline: two parallel faces, and walls across them.

use std::collections::BTreeMap;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::principal_axes::principal_axes;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DMat3, DVec2, DVec3};

/// Largest ratio of thickness to longest extent.
const THIN: f64 = 0.1;
/// Largest distance of a vertex from its face, over the thickness.
const ON_FACE: f64 = 1e-3;
/// Largest distance of a point from the straight line between corners, over the thickness.
const STRAIGHT: f64 = 1e-2;
/// Sine of the angle to a face or a wall above which a triangle belongs to neither.
const SQUARE: f64 = 1e-2;

/// A thin plate without holes.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatPlate {
    /// Corners in the middle plane \[m\], counter-clockwise.
    pub outline: Vec<DVec2>,
    /// \[m\]
    pub thickness: f64,
    /// Columns: the two directions of the plane and the normal.
    pub frame: DMat3,
    /// Height of the middle plane along the normal \[m\].
    pub height: f64,
}

impl FlatPlate {
    /// The plate that a closed mesh is; `None` if it has a hole, other faces, or is not thin.
    pub fn of_mesh(mesh: &TriMesh) -> Option<Self> {
        // A plate has its largest moment about its normal.
        let (_, axes) = principal_axes(MassProperties::of(mesh).ok()?.inertia);
        let rough = axes.z_axis;
        let upper: DVec3 = (0..mesh.triangles.len())
            .map(|t| mesh.area_vector(t))
            .filter(|area| area.dot(rough) > 0.5 * area.length())
            .sum();
        let normal = upper.try_normalize()?;
        let (first, second) = normal.any_orthonormal_pair();
        let heights = || mesh.vertices.iter().map(|v| v.dot(normal));
        let (low, high) =
            (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        let (thickness, height) = (high - low, 0.5 * (high + low));
        if thickness > THIN * mesh.diagonal() || thickness <= 0.0 {
            return None;
        }
        // Each triangle lies in a face or in a wall.
        let mut top = Vec::new();
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let tilt = mesh.area_vector(t).normalize_or_zero().dot(normal);
            let level = |h: f64| {
                corners
                    .iter()
                    .all(|v| (mesh.vertices[*v as usize].dot(normal) - h).abs() <= ON_FACE * thickness)
            };
            match tilt {
                tilt if tilt > 1.0 - SQUARE && level(high) => top.push(*corners),
                tilt if tilt < SQUARE - 1.0 && level(low) => {}
                tilt if tilt.abs() < SQUARE => {}
                _ => return None,
            }
        }
        let rim = only_loop(&top)?;
        let flat = |v: &u32| {
            let x = mesh.vertices[*v as usize];
            DVec2::new(x.dot(first), x.dot(second))
        };
        let outline = without_straight_corners(rim.iter().map(flat).collect(), STRAIGHT * thickness);
        let frame = DMat3::from_cols(first, second, normal);
        (outline.len() >= 3).then_some(FlatPlate { outline, thickness, frame, height })
    }
}

impl FlatPlate {
    /// Area of a face \[m²\].
    pub fn area(&self) -> f64 {
        let next = |k: usize| self.outline[(k + 1) % self.outline.len()];
        0.5 * self.outline.iter().enumerate().map(|(k, p)| p.perp_dot(next(k))).sum::<f64>()
    }

    /// Area over half the perimeter \[m\]: the width of a long strip, the radius of a disc.
    pub fn mean_width(&self) -> f64 {
        let sides = self.outline.iter().zip(self.outline.iter().cycle().skip(1));
        2.0 * self.area() / sides.map(|(p, q)| p.distance(*q)).sum::<f64>()
    }

    /// Largest distance between two corners \[m\].
    pub fn longest(&self) -> f64 {
        let from = |p: &DVec2| self.outline.iter().map(|q| p.distance(*q)).fold(0.0, f64::max);
        self.outline.iter().map(from).fold(0.0, f64::max)
    }
}

/// The border of a patch of triangles, if it is one loop.
fn only_loop(triangles: &[[u32; 3]]) -> Option<Vec<u32>> {
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    let mut sides: BTreeMap<[u32; 2], (u32, u32, usize)> = BTreeMap::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            sides.entry([a.min(b), a.max(b)]).or_insert((a, b, 0)).2 += 1;
        }
    }
    for (a, b, _) in sides.into_values().filter(|(_, _, count)| *count == 1) {
        if next.insert(a, b).is_some() {
            return None;
        }
    }
    let start = *next.keys().next()?;
    let mut rim = vec![start];
    while let Some(after) = next.get(&rim[rim.len() - 1]).filter(|after| **after != start) {
        rim.push(*after);
        if rim.len() > next.len() {
            return None;
        }
    }
    (rim.len() == next.len()).then_some(rim)
}

/// A polygon without the points that lie on the line between their neighbours.
fn without_straight_corners(mut points: Vec<DVec2>, tolerance: f64) -> Vec<DVec2> {
    let mut k = 0;
    let mut kept = 0;
    while points.len() > 3 && kept < points.len() {
        let count = points.len();
        let [a, b, c] = [k + count - 1, k, k + 1].map(|k| points[k % count]);
        let along = (c - a).normalize_or_zero();
        if along.perp_dot(b - a).abs() <= 0.1 * tolerance && (b - a).dot(c - b) > 0.0 {
            points.remove(k % count);
            kept = 0;
            k %= points.len();
        } else {
            kept += 1;
            k = (k + 1) % count;
        }
    }
    points
}
