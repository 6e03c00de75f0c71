//! Vertices of flat triangles that enclose the same volume as the reference surface.
//!
//! Triangles with their corners on a convex surface lose 1 to 6 % of its volume, and the pressure of an
//! accelerated body has the same error. Two steps correct this. First, the signed distance from each triangle
//! to the surface, along the triangle's normal, is made zero in the mean (least squares per vertex over the
//! triangles around it). Then all vertices move along their normals by one length that makes the volume
//! exact.
//!
//! The displacement u of a vertex minimises Σ w (n·u − d)² over the sample points of its triangles. On a
//! smooth surface n is the normal at the vertex and u is along it; on a sharp edge n is that of each
//! triangle, so that each face gets its own distance, and a flat face next to a curved one stays flat.

use clangor_core::geometry::curvature::vertex_normals;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{BVec3, DMat3, DVec3};

use super::guide::Guide;

const SWEEPS: usize = 5;
/// Most steps to a volume, and its relative error that ends them.
const NEWTON: usize = 12;
const EXACT: f64 = 1e-13;
/// Ridge of the least squares, in units of the trace: fixes the directions that no triangle determines.
const RIDGE: f64 = 0.05;
/// Two orbits of three barycentric points and their weight in the mean: exact for polynomials of degree 4.
///
/// Source: Dunavant (1985), "High degree efficient symmetrical Gaussian quadrature rules for the triangle".
const ORBITS: [(f64, f64); 2] =
    [(0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)];

/// Signed volume \[m³\] of the cone from the origin over a surface: that of a solid, or of the part of a
/// symmetric solid between planes through the origin.
pub(super) fn cone_volume(mesh: &TriMesh) -> f64 {
    let cone = |t| {
        let [a, b, c] = mesh.corners(t);
        a.dot(b.cross(c)) / 6.0
    };
    (0..mesh.triangles.len()).map(cone).sum()
}

/// Degrees of freedom of a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Freedom {
    /// Free axes.
    pub(crate) axes: BVec3,
    /// Whether each face around it has a separate distance.
    pub(crate) sharp: bool,
}

/// Fits `mesh` to the guide.
pub(super) fn fit(mesh: &mut TriMesh, freedom: &[Freedom], guide: &Guide) {
    for _ in 0..SWEEPS {
        let mut systems = Systems::new(mesh, freedom);
        for t in 0..mesh.triangles.len() {
            let area_vector = mesh.area_vector(t);
            let (area, normal) = (area_vector.length(), area_vector.normalize_or_zero());
            let corners = mesh.corners(t);
            let reach = 2.0 * corners[0].distance(corners[1]).max(corners[0].distance(corners[2]));
            for (apex, (near, weight)) in [0, 1, 2].into_iter().flat_map(|k| ORBITS.map(|o| (k, o))) {
                let sample = [0, 1, 2].map(|k| if k == apex { 1.0 - 2.0 * near } else { near });
                let point = (0..3).map(|k| sample[k] * corners[k]).sum::<DVec3>();
                let Some(nearest) = guide.nearest(point, normal, reach) else { continue };
                let distance = (nearest.position - point).dot(normal);
                for (v, share) in mesh.triangles[t].into_iter().zip(sample) {
                    systems.add(v as usize, area * weight * share, normal, distance);
                }
            }
        }
        mesh.vertices.iter_mut().zip(systems.solve()).for_each(|(v, step)| *v += step);
    }
}

/// Moves all faces outwards by the same length, such that the cone volume becomes `volume` \[m³\].
pub(crate) fn offset_to_volume(mesh: &mut TriMesh, freedom: &[Freedom], volume: f64) {
    // The volume is a cubic of the length: Newton's method converges quadratically.
    for _ in 0..NEWTON {
        if (cone_volume(mesh) / volume - 1.0).abs() < EXACT {
            break;
        }
        let mut systems = Systems::new(mesh, freedom);
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let area_vector = mesh.area_vector(t);
            for v in corners.map(|v| v as usize) {
                systems.add(v, area_vector.length(), area_vector.normalize_or_zero(), 1.0);
            }
        }
        let direction = systems.solve();
        let growth: f64 = (0..mesh.triangles.len())
            .map(|t| {
                let mean = mesh.triangles[t].iter().map(|v| direction[*v as usize]).sum::<DVec3>() / 3.0;
                mesh.area_vector(t).dot(mean)
            })
            .sum();
        let step = (volume - cone_volume(mesh)) / growth;
        mesh.vertices.iter_mut().zip(direction).for_each(|(v, d)| *v += step * d);
    }
}

/// The least squares of every vertex.
struct Systems<'a> {
    freedom: &'a [Freedom],
    normals: Vec<DVec3>,
    matrix: Vec<DMat3>,
    right: Vec<DVec3>,
}

impl<'a> Systems<'a> {
    fn new(mesh: &TriMesh, freedom: &'a [Freedom]) -> Self {
        let count = mesh.vertices.len();
        let (matrix, right) = (vec![DMat3::ZERO; count], vec![DVec3::ZERO; count]);
        Systems { freedom, normals: vertex_normals(mesh), matrix, right }
    }

    /// Adds w (n·u − d)² for one vertex of a triangle with normal n.
    fn add(&mut self, vertex: usize, weight: f64, normal: DVec3, distance: f64) {
        let Freedom { axes, sharp } = self.freedom[vertex];
        let along = |n: DVec3| DVec3::select(axes, n, DVec3::ZERO);
        let normal = if sharp { along(normal) } else { along(self.normals[vertex]).normalize_or_zero() };
        let scaled = weight * normal;
        self.matrix[vertex] += DMat3::from_cols(scaled * normal.x, scaled * normal.y, scaled * normal.z);
        self.right[vertex] += scaled * distance;
    }

    /// The minimisers; zero where nothing is determined.
    fn solve(&self) -> Vec<DVec3> {
        let one = |(matrix, right): (&DMat3, &DVec3)| {
            let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
            let ridge = DMat3::from_diagonal(DVec3::splat(RIDGE * trace));
            let step = (*matrix + ridge).inverse() * *right;
            if step.is_finite() { step } else { DVec3::ZERO }
        };
        self.matrix.iter().zip(&self.right).map(one).collect()
    }
}
