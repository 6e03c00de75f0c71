//! The reference surface of a remeshing: nearest points on the same face of a wall, and target edge lengths.

use clangor_core::geometry::surface_tree::{NearestPoint, SurfaceTree};
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

/// Smallest cosine between a normal and that of the triangle to project onto. The other face of a thin wall
/// has about −1, so that the two faces are never welded; the faces at a right angle across a rim have 0.
const COMPATIBLE_COSINE: f64 = 0.2;

/// The input surface.
pub(super) struct Guide<'a> {
    mesh: &'a TriMesh,
    tree: SurfaceTree,
    normals: Vec<DVec3>,
    /// Target edge length at each vertex \[m\].
    size: &'a [f64],
}

impl<'a> Guide<'a> {
    pub(super) fn new(mesh: &'a TriMesh, size: &'a [f64]) -> Self {
        let normals = (0..mesh.triangles.len()).map(|t| mesh.area_vector(t).normalize_or_zero()).collect();
        Guide { mesh, tree: SurfaceTree::new(mesh), normals, size }
    }

    /// The nearest point, closer than `within` \[m\], of the triangles that face like the unit vector
    /// `normal`.
    pub(super) fn nearest(&self, point: DVec3, normal: DVec3, within: f64) -> Option<NearestPoint> {
        let facing = |t: usize| self.normals[t].dot(normal) > COMPATIBLE_COSINE;
        self.tree.nearest_where(self.mesh, point, within, facing)
    }

    /// Target edge length at a point of the surface \[m\].
    pub(super) fn size_at(&self, place: &NearestPoint) -> f64 {
        let corners = self.mesh.triangles[place.triangle];
        (0..3).map(|k| place.weights[k] * self.size[corners[k] as usize]).sum()
    }
}
