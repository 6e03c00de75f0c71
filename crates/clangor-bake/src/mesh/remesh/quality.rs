//! Quality of the triangles of a mesh.

use clangor_core::geometry::tri_mesh::TriMesh;

/// The smallest angles of triangles \[rad\]: of the worst, and the 5th percentile.
pub(super) fn smallest_angles(mesh: &TriMesh) -> (f64, f64) {
    let smallest = |t: usize| {
        let corners = mesh.corners(t);
        let angle = |k: usize| {
            let (u, v) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
            u.cross(v).length().atan2(u.dot(v))
        };
        (0..3).map(angle).fold(f64::INFINITY, f64::min)
    };
    let mut angles: Vec<f64> = (0..mesh.triangles.len()).map(smallest).collect();
    angles.sort_unstable_by(f64::total_cmp);
    let at = |share: usize| angles.get(angles.len() / share).copied().unwrap_or(0.0);
    (angles.first().copied().unwrap_or(0.0), at(20))
}
