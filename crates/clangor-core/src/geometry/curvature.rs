//! Mean curvature of a triangle surface at its vertices.
//!
//! The cotangent operator over mixed Voronoi areas:
//!
//! `2 H n = 1/(2 A) Σ_j (cot α_ij + cot β_ij) (x_i − x_j)`
//!
//! Source: Meyer, Desbrun, Schröder, Barr, "Discrete Differential-Geometry Operators for Triangulated
//! 2-Manifolds" (2002), eqs. (8) and figs. 3, 4. Here H = (κ₁+κ₂)/2, positive where convex, so a sphere of
//! radius R has 1/R. At a sharp edge H is of the order of 1/(triangle size): the scene's `edge_radius` bounds
//! it.

use glam::DVec3;

use super::tri_mesh::TriMesh;

/// Mean curvature H at each vertex [1/m]; 0 at a vertex without triangles.
pub fn mean_curvature(mesh: &TriMesh) -> Vec<f64> {
    let count = mesh.vertices.len();
    let mut area = vec![0.0; count];
    let mut operator = vec![DVec3::ZERO; count];
    let normal = vertex_normals(mesh);
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(t);
        let doubled = 2.0 * mesh.area_vector(t).length();
        if doubled <= 0.0 {
            continue;
        }
        let cosine = |k: usize| (corners[(k + 1) % 3] - corners[k]).dot(corners[(k + 2) % 3] - corners[k]);
        let cotangent = [0, 1, 2].map(|k| cosine(k) / doubled);
        let obtuse = (0..3).find(|k| cotangent[*k] < 0.0);
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let edge = corners[i] - corners[j];
            operator[triangle[i] as usize] += edge * cotangent[k];
            operator[triangle[j] as usize] -= edge * cotangent[k];
            match obtuse {
                None => {
                    let share = edge.length_squared() * cotangent[k] / 8.0;
                    area[triangle[i] as usize] += share;
                    area[triangle[j] as usize] += share;
                }
                Some(o) => area[triangle[k] as usize] += doubled / if o == k { 4.0 } else { 8.0 },
            }
        }
    }
    (0..count)
        .map(|i| {
            let vector = operator[i] / (4.0 * area[i]);
            let h = vector.length().copysign(vector.dot(normal[i]));
            if h.is_finite() { h } else { 0.0 }
        })
        .collect()
}

/// Unit outward normals at the vertices, weighted by the angle of each triangle; zero without triangles.
///
/// With this weight the sign of `(p − x)·n` at the nearest vertex x tells inside from outside: Bærentzen and
/// Aanæs (2005), "Signed distance computation using the angle weighted pseudonormal".
pub fn vertex_normals(mesh: &TriMesh) -> Vec<DVec3> {
    let mut normal = vec![DVec3::ZERO; mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(t);
        let face = mesh.area_vector(t).normalize_or_zero();
        for k in 0..3 {
            let (u, v) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
            normal[triangle[k] as usize] += face * u.cross(v).length().atan2(u.dot(v));
        }
    }
    normal.into_iter().map(DVec3::normalize_or_zero).collect()
}
