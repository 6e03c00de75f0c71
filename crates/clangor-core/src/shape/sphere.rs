//! Spheres and ellipsoids: an icosahedron whose faces are divided and pushed out to the surface.

use glam::DVec3;

use crate::geometry::icosahedron::icosahedron;
use crate::geometry::tri_mesh::TriMesh;

/// An ellipsoid whose longest edges are about `edge` \[m\].
pub(super) fn ellipsoid_mesh(semi_axes: DVec3, edge: f64) -> TriMesh {
    // The icosahedron of circumradius 1 has edges of 1.0515; projection stretches the middle of a face by
    // 1.18.
    let divisions = (1.0515 * 1.1 * semi_axes.max_element() / edge).ceil().max(1.0) as u32;
    let mut mesh = divided_icosahedron(divisions);
    mesh.vertices.iter_mut().for_each(|v| *v *= semi_axes);
    mesh
}

/// 162 points whose hull errs by at most 0.9 % of the largest semi-axis, to both sides.
pub(super) fn ellipsoid_hull(semi_axes: DVec3) -> Vec<DVec3> {
    let ball = divided_icosahedron(4);
    let depth = |t| ball.area_vector(t).normalize().dot(ball.corners(t)[0]);
    let deepest = (0..ball.triangles.len()).map(depth).fold(1.0, f64::min);
    ball.vertices.iter().map(|v| *v * semi_axes * (2.0 / (1.0 + deepest))).collect()
}

/// A unit sphere from an icosahedron with every edge divided into `divisions`.
///
/// Face points go out to the sphere from the plane grid; neighbours along an edge share its points.
pub(super) fn divided_icosahedron(divisions: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    for [a, mut b, mut c] in icosahedron() {
        if a.dot(b.cross(c)) < 0.0 {
            std::mem::swap(&mut b, &mut c);
        }
        append_face(&mut mesh, [a, b, c], divisions);
    }
    mesh.weld(0.1 / f64::from(divisions))
}

/// Adds a divided triangle, pushed out to the unit sphere.
fn append_face(mesh: &mut TriMesh, [a, b, c]: [DVec3; 3], divisions: u32) {
    let start = mesh.vertices.len() as u32;
    // Row i holds i + 1 points, from corner a to the side bc.
    let at = |i: u32, j: u32| start + i * (i + 1) / 2 + j;
    for i in 0..=divisions {
        for j in 0..=i {
            let weights = [divisions - i, i - j, j].map(f64::from);
            mesh.vertices.push((a * weights[0] + b * weights[1] + c * weights[2]).normalize());
            if i < divisions {
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                if j < i {
                    mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
}
