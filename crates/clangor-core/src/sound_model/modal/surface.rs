//! The surface of a vibrating body: triangles of six nodes, and location of points on them.
//!
//! A face of a quadratic tetrahedron has three corners and three mid-edge nodes. With the weights L₀ + L₁ +
//! L₂ = 1 of a point, nodal values are interpolated as
//!
//! ```text
//! u(L) = Σ uᵢ Lᵢ (2 Lᵢ − 1) + Σ u_ij 4 Lᵢ Lⱼ
//! ```
//!
//! as inside the element. Linear interpolation between the nodes would lose some per cent of the mode's
//! motion where two elements span half a bending wave.

use glam::DVec3;

use crate::geometry::surface_tree::{NearestPoint, SurfaceTree};
use crate::geometry::tri_mesh::TriMesh;

/// The four small triangles that six nodes span; nodes 3, 4, 5 lie between 0–1, 1–2, 2–0.
const QUARTERS: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

/// Weights of the three corners at the six nodes.
const NODE_WEIGHTS: [[f64; 3]; 6] =
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];

/// Least cosine between normals of the same side.
const FACING: f64 = 0.2;

/// Triangles of six nodes around a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModalSurface {
    /// Positions \[m\], in the frame of the body: its axes, origin at the centre of mass.
    pub nodes: Vec<DVec3>,
    /// Nodes of each triangle: corners counter-clockwise seen from outside, then the middles of edges 0–1,
    /// 1–2, 2–0.
    pub triangles: Vec<[u32; 6]>,
}

/// A place on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The six nodes around it.
    pub nodes: [u32; 6],
    /// Their weights; they sum to 1.
    pub weights: [f64; 6],
    /// Distance of the query point from the surface \[m\].
    pub distance: f64,
}

/// Search for places on a surface.
#[derive(Clone, Debug)]
pub struct SurfaceLocator {
    quarters: TriMesh,
    tree: SurfaceTree,
    triangles: Vec<[u32; 6]>,
}

impl ModalSurface {
    /// Every triangle in four, between its six nodes: four times as many, of the same sense.
    pub fn quarters(&self) -> TriMesh {
        TriMesh {
            vertices: self.nodes.clone(),
            triangles: self.triangles.iter().flat_map(|t| QUARTERS.map(|q| q.map(|n| t[n]))).collect(),
        }
    }

    /// Largest distance of a node from the centre of mass \[m\].
    pub fn radius(&self) -> f64 {
        self.nodes.iter().map(|x| x.length()).fold(0.0, f64::max)
    }
}

impl SurfaceLocator {
    /// Prepares a surface whose indices are in range.
    pub fn new(surface: &ModalSurface) -> Self {
        let quarters = surface.quarters();
        let tree = SurfaceTree::new(&quarters);
        SurfaceLocator { quarters, tree, triangles: surface.triangles.clone() }
    }

    /// The place of the surface nearest to a point [m, frame of the body]; `None` on an empty surface.
    pub fn nearest(&self, point: DVec3) -> Option<SurfacePoint> {
        Some(self.place(self.tree.nearest(&self.quarters, point)?))
    }

    /// The nearest place whose outer side is that of `normal`, of any length, if there is one: it
    /// distinguishes the two sides of a thin wall.
    pub fn nearest_facing(&self, point: DVec3, normal: DVec3) -> Option<SurfacePoint> {
        let faces = |t: usize| {
            let own = self.quarters.area_vector(t);
            own.dot(normal) > FACING * own.length() * normal.length()
        };
        match self.tree.nearest_where(&self.quarters, point, f64::INFINITY, faces) {
            Some(nearest) => Some(self.place(nearest)),
            None => self.nearest(point),
        }
    }

    fn place(&self, nearest: NearestPoint) -> SurfacePoint {
        let triangle = self.triangles[nearest.triangle / 4];
        let corners = QUARTERS[nearest.triangle % 4].map(|n| NODE_WEIGHTS[n]);
        let weights = std::array::from_fn(|k| (0..3).map(|c| nearest.weights[c] * corners[c][k]).sum());
        SurfacePoint { nodes: triangle, weights: node_weights(weights), distance: nearest.distance }
    }
}

impl SurfacePoint {
    /// Interpolation at this place of values at the nodes.
    pub fn interpolate(&self, values: &[DVec3]) -> DVec3 {
        self.nodes.iter().zip(self.weights).map(|(n, w)| values[*n as usize] * w).sum()
    }
}

/// Weights of the six nodes at a point of these corner weights.
pub fn node_weights([a, b, c]: [f64; 3]) -> [f64; 6] {
    [a * (2.0 * a - 1.0), b * (2.0 * b - 1.0), c * (2.0 * c - 1.0), 4.0 * a * b, 4.0 * b * c, 4.0 * c * a]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_motion_is_interpolated_exactly() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut nodes = corners.to_vec();
        nodes.extend([0.5 * DVec3::X, 0.5 * (DVec3::X + DVec3::Y), 0.5 * DVec3::Y]);
        let surface = ModalSurface { nodes: nodes.clone(), triangles: vec![[0, 1, 2, 3, 4, 5]] };
        let motion = |x: DVec3| DVec3::new(x.x * x.x - 2.0 * x.x * x.y, x.y * x.y, 1.0 - x.x);
        let values: Vec<DVec3> = nodes.iter().map(|x| motion(*x)).collect();
        let locator = SurfaceLocator::new(&surface);
        for point in [DVec3::new(0.2, 0.7, 0.3), DVec3::new(0.3, 0.3, -0.1), DVec3::new(0.05, 0.02, 0.0)] {
            let place = locator.nearest(point).expect("a place");
            let on_it = DVec3::new(point.x, point.y, 0.0);
            // Residual seen: 2e-17.
            assert!((place.interpolate(&values) - motion(on_it)).length() < 1e-14, "{place:?}");
            assert!((place.distance - point.z.abs()).abs() < 1e-15);
        }
    }

    #[test]
    fn the_sides_of_a_wall_are_distinguished() {
        let (thickness, width) = (0.01, 1.0);
        let mut nodes = Vec::new();
        for z in [0.0, thickness] {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|x| width * x + z * DVec3::Z);
            nodes.extend(corners);
            nodes.extend([0, 1, 2].map(|k| 0.5 * (corners[k] + corners[(k + 1) % 3])));
        }
        let surface = ModalSurface { nodes, triangles: vec![[0, 2, 1, 5, 4, 3], [6, 7, 8, 9, 10, 11]] };
        let locator = SurfaceLocator::new(&surface);
        // Nearer to the lower side, but of the upper.
        let point = DVec3::new(0.2, 0.2, 0.4 * thickness);
        assert!(locator.nearest(point).is_some_and(|p| p.nodes[0] == 0));
        let above = locator.nearest_facing(point, DVec3::Z).expect("a place");
        assert_eq!(above.nodes[0], 6);
        assert!((above.distance - 0.6 * thickness).abs() < 1e-15);
        assert!(locator.nearest_facing(point, DVec3::X).is_some_and(|p| p.nodes[0] == 0));
    }
}
