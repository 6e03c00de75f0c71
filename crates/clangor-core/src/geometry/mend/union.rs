//! The surface of two solids that cross, as one.
//!
//! ```text
//! ∂(A ∪ B) = { x ∈ ∂A : x ∉ B } ∪ { x ∈ ∂B : x ∉ A }
//! ```
//!
//! 1. Edges of each surface pierce triangles of the other ([`lines`]): two points for each pair of triangles
//!    that cross, joined by a line.
//! 2. Lines divide the triangles in which they lie ([`divide`]).
//! 3. Parts of a surface between lines lie in the other solid or outside of it (winding number of one point).
//!
//! Points belong to an edge and a triangle, and which edges pierce which triangles is found exactly, so that
//! all lines are closed, and the result too. The solids must be in general position: no vertex on a triangle
//! of the other, no two edges that meet.
//!
//! Source: Zhou, Grinspun, Zorin, Jacobson (2016), "Mesh Arrangements for Solid Geometry", SIGGRAPH.
//! `Differs`: two solids at a time, in general position, with points that are rounded.

mod divide;
mod lines;

use std::collections::{BTreeSet, HashSet};

use glam::DVec3;

use super::super::components::winding_number;
use super::super::surface_tree::SurfaceTree;
use super::super::tri_mesh::TriMesh;
use super::edges::{Sides, patches};
use divide::divide;
use lines::Lines;

/// Solids that are not in general position, or so close to it that rounding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Degenerate;

/// The union of two solids.
pub(super) struct Union {
    /// Its surface.
    pub(super) mesh: TriMesh,
    /// The vertex of the first solid, or of the second after those of the first, that each vertex is; `None`
    /// where the surfaces cross.
    pub(super) sources: Vec<Option<u32>>,
    /// Area of one surface that lies within the other solid, the larger one \[m²\].
    pub(super) covered: f64,
    /// Where the surfaces cross.
    pub(super) position: DVec3,
}

/// The union of two closed surfaces; `None` if they do not cross.
///
/// # Errors
/// [`Degenerate`].
pub(super) fn union(first: &TriMesh, second: &TriMesh) -> Result<Option<Union>, Degenerate> {
    let ((low_a, high_a), (low_b, high_b)) = (first.bounds(), second.bounds());
    let (low, high) = (low_a.max(low_b), high_a.min(high_b));
    if low.cmpgt(high).any() {
        return Ok(None);
    }
    let both = joined(first, second);
    let count = first.triangles.len();
    // Lines where triangles cross.
    let mut lines = Lines::new(&both);
    for pair in close_pairs(&both, count, (low, high)) {
        lines.cross(pair)?;
    }
    let Some(position) = lines.points().first().copied() else { return Ok(None) };
    let vertices = [&both.vertices[..], lines.points()].concat();
    // Parts of triangles between lines.
    let mut parts = [Vec::new(), Vec::new()];
    let mut cuts = HashSet::new();
    for t in 0..both.triangles.len() {
        let own = &mut parts[usize::from(t >= count)];
        match lines.within(t) {
            None => own.push(both.triangles[t]),
            Some(within) => divide(&vertices, &within, own, &mut cuts)?,
        }
    }
    // Those outside of the other solid.
    let [of_first, of_second] = parts;
    let (mut outside, covered_first) = outside(&vertices, of_first, &cuts, second);
    let (others, covered_second) = self::outside(&vertices, of_second, &cuts, first);
    outside.extend(others);
    let (mesh, kept) = compact(&vertices, &outside);
    let sources = kept.into_iter().map(|v| Some(v).filter(|v| (*v as usize) < both.vertices.len())).collect();
    Ok(Some(Union { mesh, sources, covered: covered_first.max(covered_second), position }))
}

/// Two meshes in one, the triangles and vertices of the first before those of the second.
fn joined(first: &TriMesh, second: &TriMesh) -> TriMesh {
    let start = first.vertices.len() as u32;
    let moved = second.triangles.iter().map(|t| t.map(|v| v + start));
    TriMesh {
        vertices: [&first.vertices[..], &second.vertices[..]].concat(),
        triangles: first.triangles.iter().copied().chain(moved).collect(),
    }
}

/// Pairs of triangles of the first `count` and the others whose boxes overlap, within bounds.
fn close_pairs(both: &TriMesh, count: usize, (low, high): (DVec3, DVec3)) -> Vec<[usize; 2]> {
    let is_close = |t: &usize| {
        let [a, b, c] = both.corners(*t);
        a.min(b).min(c).cmple(high).all() && a.max(b).max(c).cmpge(low).all()
    };
    let close: Vec<usize> = (0..both.triangles.len()).filter(is_close).collect();
    let mut pairs = Vec::new();
    if close.is_empty() {
        return pairs;
    }
    let triangles = close.iter().map(|t| both.triangles[*t]).collect();
    let near = TriMesh { vertices: both.vertices.clone(), triangles };
    SurfaceTree::new(&near).overlapping_pairs(&near, 0.0, &mut |a, b| {
        let pair = [close[a], close[b]];
        if (pair[0] < count) != (pair[1] < count) {
            pairs.push(pair);
        }
        false
    });
    pairs
}

/// The parts of a surface outside of the other solid, and the area of those within it \[m²\].
fn outside(
    vertices: &[DVec3],
    parts: Vec<[u32; 3]>,
    cuts: &HashSet<[u32; 2]>,
    other: &TriMesh,
) -> (Vec<[u32; 3]>, f64) {
    let mesh = TriMesh { vertices: vertices.to_vec(), triangles: parts };
    let count = mesh.triangles.len();
    let mut across = Sides::new(&mesh).across(count);
    for (corners, across) in mesh.triangles.iter().zip(&mut across) {
        for k in 0..3 {
            if cuts.contains(&sorted(corners[k], corners[(k + 1) % 3])) {
                across[k] = None;
            }
        }
    }
    let (regions, region) = patches(&across);
    // The largest triangle of each region decides.
    let area = |t: usize| mesh.area_vector(t).length();
    let mut largest = vec![0; regions];
    (0..count).rev().for_each(|t| largest[region[t]] = t);
    for t in 0..count {
        if area(t) > area(largest[region[t]]) {
            largest[region[t]] = t;
        }
    }
    let is_within: Vec<bool> =
        largest.iter().map(|t| winding_number(other, mesh.centroid(*t)) > 0.5).collect();
    let covered = (0..count).filter(|t| is_within[region[*t]]).map(area).sum();
    let kept = (0..count).filter(|t| !is_within[region[*t]]).map(|t| mesh.triangles[t]).collect();
    (kept, covered)
}

/// Some triangles with the vertices that they use, and the numbers that these had.
pub(super) fn compact(vertices: &[DVec3], triangles: &[[u32; 3]]) -> (TriMesh, Vec<u32>) {
    let used: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
    let kept: Vec<u32> = used.into_iter().collect();
    let mut place = vec![u32::MAX; vertices.len()];
    kept.iter().enumerate().for_each(|(k, v)| place[*v as usize] = k as u32);
    let mesh = TriMesh {
        vertices: kept.iter().map(|v| vertices[*v as usize]).collect(),
        triangles: triangles.iter().map(|t| t.map(|v| place[v as usize])).collect(),
    };
    (mesh, kept)
}

/// An edge by its ends in order.
fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
