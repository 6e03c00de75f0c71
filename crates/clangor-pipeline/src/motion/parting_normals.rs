//! Normals along which two convex surfaces part.
//!
//! Where faces of two bodies are flush, as the sides of the boxes of a stack, a corner that lies a little
//! within the other body may be nearer to a side of it than to the face on which it stands. Impulses at such
//! points, from both sides, squeeze a body and move nothing. Convex bodies touch along a direction n only if
//! a small way along it parts them:
//!
//! ```text
//! D(n) = max_b n·x − min_a n·x        −gap of the pair where it touches along n; else up to a width
//! ```
//!
//! Bodies that are not convex may hold each other from opposite sides; their points are left as they are.

use std::collections::{BTreeMap, BTreeSet};

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::pose::Pose;
use glam::DVec3;

use super::touch::Touch;

/// Least cosine between normals that are one.
const ONE_NORMAL: f64 = 0.99;
/// Height of a face above the next one that is rounding, over the size of the mesh.
const FLAT: f64 = 1e-6;

/// The corners of a convex surface.
#[derive(Clone, Debug)]
pub(super) struct ConvexCorners(Vec<DVec3>);

impl ConvexCorners {
    /// Those of a closed mesh; `None` if it is not convex.
    pub(super) fn of(mesh: &TriMesh) -> Option<Self> {
        let sides = faces_of_edges(mesh);
        let corners: BTreeSet<u32> = mesh.triangles.iter().flatten().copied().collect();
        // One body without a hole.
        if corners.len() + mesh.triangles.len() != sides.len() + 2 {
            return None;
        }
        let flat = FLAT * mesh.diagonal();
        let is_hollow = |(ends, faces): (&[u32; 2], &Vec<usize>)| {
            let &[one, two] = &faces[..] else { return true };
            let way = mesh.centroid(two) - mesh.vertices[ends[0] as usize];
            mesh.area_vector(one).normalize_or_zero().dot(way) > flat
        };
        let is_convex = !sides.iter().any(is_hollow);
        is_convex.then(|| ConvexCorners(corners.iter().map(|k| mesh.vertices[*k as usize]).collect()))
    }

    /// How far the surface reaches along a direction [m, world].
    fn reach(&self, pose: Pose, direction: DVec3) -> f64 {
        let own = pose.orientation.inverse() * direction;
        let farthest = self.0.iter().map(|corner| corner.dot(own)).fold(f64::NEG_INFINITY, f64::max);
        pose.position.dot(direction) + farthest
    }
}

/// The faces at each edge of a mesh.
pub(super) fn faces_of_edges(mesh: &TriMesh) -> BTreeMap<[u32; 2], Vec<usize>> {
    let mut sides: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (triangle[a], triangle[b]);
            sides.entry([a.min(b), a.max(b)]).or_default().push(face);
        }
    }
    sides
}

/// The points of two convex surfaces along whose normals they part; gaps count up to `within` \[m\].
pub(super) fn parting(found: Vec<Touch>, [a, b]: [(&ConvexCorners, Pose); 2], within: f64) -> Vec<Touch> {
    let Some(first) = found.first() else { return found };
    if found.iter().all(|touch| touch.normal.dot(first.normal) > ONE_NORMAL) {
        return found;
    }
    let overlap = |touch: &Touch| b.0.reach(b.1, touch.normal) + a.0.reach(a.1, -touch.normal);
    let overlaps: Vec<f64> = found.iter().map(overlap).collect();
    let least = overlaps.iter().copied().fold(f64::INFINITY, f64::min);
    let parts = |(_, overlap): &(Touch, f64)| *overlap <= least.max(0.0) + within;
    found.into_iter().zip(overlaps).filter(parts).map(|(touch, _)| touch).collect()
}

#[cfg(test)]
mod tests {
    use clangor_core::geometry::tri_mesh::TriMesh;
    use clangor_core::shape::Shape;

    use super::*;

    fn mesh(shape: &str) -> TriMesh {
        Shape::parse(shape).unwrap().mesh()
    }

    #[test]
    fn boxes_and_dice_are_convex_and_mugs_and_rings_are_not() {
        for (shape, is_convex) in [
            ("box:0.1x0.2x0.3", true),
            ("die", true),
            ("cylinder:0.02x0.1", true),
            ("mug", false),
            ("ring", false),
        ] {
            assert_eq!(ConvexCorners::of(&mesh(shape)).is_some(), is_convex, "{shape}");
        }
    }

    #[test]
    fn sides_that_are_flush_do_not_push() {
        let corners = ConvexCorners::of(&mesh("box:0.1x0.1x0.1")).unwrap();
        let (lower, upper) = (Pose::at(DVec3::ZERO), Pose::at(DVec3::Y * 0.0995));
        let touch = |point: DVec3, normal: DVec3| Touch { point, normal, gap: -5e-4 };
        let corner = DVec3::new(0.05, 0.05, 0.05);
        let found = [DVec3::Y, DVec3::X, DVec3::Z, DVec3::NEG_Z].map(|normal| touch(corner, normal));
        let kept = parting(found.to_vec(), [(&corners, upper), (&corners, lower)], 1e-3);
        assert_eq!(kept, [found[0]]);
        // Beside each other, they push along x alone.
        let beside = Pose::at(DVec3::X * 0.1);
        let kept = parting(found.to_vec(), [(&corners, beside), (&corners, lower)], 1e-3);
        assert_eq!(kept, [found[1]]);
    }
}
