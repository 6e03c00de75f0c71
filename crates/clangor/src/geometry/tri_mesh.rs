//! A triangle surface.

use glam::DVec3;

/// A triangle mesh; triangles wind counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions [m].
    pub vertices: Vec<DVec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// Corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|i| self.vertices[i as usize])
    }

    /// Largest distance of a vertex from `centre` [m].
    pub fn bounding_radius(&self, centre: DVec3) -> f64 {
        self.vertices.iter().map(|v| (*v - centre).length()).fold(0.0, f64::max)
    }
}
