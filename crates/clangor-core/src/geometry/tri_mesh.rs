//! A triangle surface.

use std::collections::HashMap;

use glam::DVec3;

/// A triangle mesh; triangles wind counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions \[m\].
    pub vertices: Vec<DVec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// Corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|i| self.vertices[i as usize])
    }

    /// Area vector of a triangle: its area \[m²\] along its outward normal.
    pub fn area_vector(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a)
    }

    /// Centroid of a triangle \[m\].
    pub fn centroid(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        a + ((b - a) + (c - a)) / 3.0
    }

    /// Area of the surface \[m²\].
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.area_vector(t).length()).sum()
    }

    /// Largest distance of a vertex from `centre` \[m\].
    pub fn bounding_radius(&self, centre: DVec3) -> f64 {
        self.vertices.iter().map(|v| (*v - centre).length()).fold(0.0, f64::max)
    }

    /// Corners of the smallest axis-parallel box that holds the vertices \[m\]; both zero without vertices.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let Some(first) = self.vertices.first() else { return (DVec3::ZERO, DVec3::ZERO) };
        self.vertices.iter().fold((*first, *first), |(low, high), v| (low.min(*v), high.max(*v)))
    }

    /// Length of the diagonal of [`bounds`](Self::bounds) \[m\].
    pub fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        (high - low).length()
    }

    /// The same surface in a frame whose origin is at `origin`.
    pub fn relative_to(&self, origin: DVec3) -> Self {
        let vertices = self.vertices.iter().map(|v| *v - origin).collect();
        TriMesh { vertices, triangles: self.triangles.clone() }
    }

    /// Merges vertices closer than `tolerance` \[m\] to an earlier one, and drops the triangles that this
    /// collapses and the vertices that no triangle uses.
    ///
    /// Files often hold one vertex per corner (STL always does), which leaves every edge open. A vertex
    /// merges with the first one in range, so the result depends only on the order of the vertices. Meshes
    /// with indices out of range or coordinates that are not finite come back unchanged, for
    /// [`check_solid`](crate::geometry::solid::check_solid) to reject.
    pub fn weld(&self, tolerance: f64) -> Self {
        let count = self.vertices.len();
        let sound = self.triangles.iter().flatten().all(|i| (*i as usize) < count)
            && self.vertices.iter().all(|v| v.is_finite());
        if !sound {
            return self.clone();
        }
        let (low, _) = self.bounds();
        // Cells no smaller than the rounding of coordinates far from the origin, so that the cell numbers are
        // exact.
        let cell = tolerance.max(self.diagonal() * 1e-12).max(f64::MIN_POSITIVE);
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let mut vertices: Vec<DVec3> = Vec::new();
        let mut merged = vec![u32::MAX; count];
        for index in self.triangles.iter().flatten() {
            let index = *index as usize;
            if merged[index] != u32::MAX {
                continue;
            }
            let v = self.vertices[index];
            let home = ((v - low) / cell).floor();
            let home = [home.x as i64, home.y as i64, home.z as i64];
            let twin = neighbours(home)
                .filter_map(|key| cells.get(&key))
                .flatten()
                .copied()
                .filter(|k| vertices[*k as usize].distance(v) <= tolerance)
                .min();
            merged[index] = twin.unwrap_or_else(|| {
                vertices.push(v);
                let k = (vertices.len() - 1) as u32;
                cells.entry(home).or_default().push(k);
                k
            });
        }
        let triangles = self
            .triangles
            .iter()
            .map(|t| t.map(|i| merged[i as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        TriMesh { vertices, triangles }
    }
}

/// A grid cell and the 26 around it.
fn neighbours([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..27).map(move |k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn welding_merges_corners_and_drops_collapsed_triangles() {
        let corner = |x, y| DVec3::new(x, y, 0.0);
        let soup = TriMesh {
            vertices: vec![
                corner(0.0, 0.0),
                corner(1.0, 0.0),
                corner(0.0, 1.0),
                corner(1.0, 1e-9),
                corner(1.0, 1.0),
                corner(0.0, 1.0),
                corner(1.0, 1.0 + 1e-9),
            ],
            triangles: vec![[0, 1, 2], [3, 4, 5], [4, 6, 5]],
        };
        let welded = soup.weld(1e-8);
        assert_eq!(welded.vertices.len(), 4);
        assert_eq!(welded.triangles, vec![[0, 1, 2], [1, 3, 2]]);
        assert_eq!(soup.weld(0.0).vertices.len(), 6);
    }
}
