//! Principal curvatures at the vertices of a triangle mesh.
//!
//! On a smooth part of the surface a quadratic form is fitted to the vertices within two edges. With
//! coordinates x, y in the tangent plane of the vertex and z into the solid, by least squares:
//!
//! ```text
//! z = (½ a x² + b x y + ½ c y²) (x² + y² + z²)/(x² + y²) + e x + f y
//! ```
//!
//! The factor makes a sphere exact, whose normal curvature is 2 z over the squared chord; e and f let the
//! normal differ from the estimate at the vertex. Source: Cazals and Pouget (2005) for the fit, whose error
//! falls with the square of the edge on any mesh.
//!
//! A vertex is sharp where a face next to it is tilted by more than 30°: fits do not reach across it, and it
//! has the mean over its triangles of the gradient of normals that are linear on each,
//!
//! ```text
//! T_f = sym Σ_k P n_k ∇φ_kᵀ,   ∇φ_k = (n_f × e_k)/(2 A_f),   P = I − n_f n_fᵀ
//! ```
//!
//! with e_k the edge opposite to vertex k: Rusinkiewicz (2004), with the gradient of linear functions for his
//! fit to three differences. Its larger curvature is of the order of 1/(triangle size), whatever the surface.
//! A contact at an edge or a corner therefore takes [`sharp_place`](super::sharp_place), and points between
//! sharp vertices ([`curvature_at`]) the triangle on their own side of them.

use glam::{DMat3, DQuat, DVec3};

use super::curvature::vertex_normals;
use super::principal_curvature::{Curvature, outer};
use super::surface_tree::{NearestPoint, SurfaceTree};
use super::tri_mesh::TriMesh;

/// Least cosine between the normals of a smooth vertex and of its faces: 30°.
const SMOOTH_COSINE: f64 = 0.866;
/// Unknowns of the fit.
const UNKNOWNS: usize = 5;
/// Smallest pivot of the fit over the largest: below, the neighbours do not determine the form.
const LEAST_PIVOT: f64 = 1e-6;
/// Most of the factor (x² + y² + z²)/(x² + y²), that of a tilt of 60°.
const MOST_LENGTHENING: f64 = 4.0;

/// Principal curvatures at each vertex; flat at a vertex without triangles.
pub fn principal_curvatures(mesh: &TriMesh) -> Vec<Curvature> {
    let normals = vertex_normals(mesh);
    let neighbours = neighbours(mesh);
    let sharp = sharp_vertices(mesh, &normals);
    let by_faces = face_tensors(mesh, &normals);
    (0..mesh.vertices.len())
        .map(|vertex| {
            if normals[vertex] == DVec3::ZERO {
                return Curvature::FLAT;
            }
            let fitted = (!sharp[vertex]).then(|| {
                let reached = two_edges_from(vertex, &neighbours, &sharp);
                fit(mesh, vertex, normals[vertex], &reached)
            });
            let faces = || Curvature::of_tensor(by_faces[vertex], normals[vertex]);
            fitted.flatten().unwrap_or_else(faces)
        })
        .collect()
}

/// Curvature at a point of a surface with these curvatures at its vertices: their tensors, interpolated. A
/// sharp vertex has none; its share is the gradient of the normals over the triangle, each of which is the
/// mean of the triangles on this side of the creases at its vertex.
pub fn curvature_at(
    mesh: &TriMesh,
    tree: &SurfaceTree,
    vertices: &[Curvature],
    at: &NearestPoint,
) -> Curvature {
    let corners = mesh.triangles[at.triangle].map(|corner| corner as usize);
    let mut normal = tree.smooth_normal(mesh, at);
    let mut sharp = [false; 3];
    let mut by_triangle = DMat3::ZERO;
    let face = mesh.area_vector(at.triangle);
    if let (Some(joined), Some(unit)) = (tree.joined(mesh), face.try_normalize()) {
        sharp = [0, 1, 2].map(|k| joined.is_sharp((at.triangle, k)));
        if sharp.contains(&true) {
            let normals = [0, 1, 2].map(|k| joined.smooth_normal((at.triangle, k)));
            normal = (0..3).map(|k| at.weights[k] * normals[k]).sum::<DVec3>().normalize_or(unit);
            by_triangle = normal_gradient(mesh.corners(at.triangle), unit, normals) * face.length().recip();
        }
    }
    let tensor = (0..3).fold(DMat3::ZERO, |sum, k| {
        let own = if sharp[k] { by_triangle } else { vertices[corners[k]].tensor(normal) };
        sum + at.weights[k] * own
    });
    Curvature::of_tensor(tensor, normal)
}

/// The vertices that share an edge with each, in order.
fn neighbours(mesh: &TriMesh) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); mesh.vertices.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| corner as usize);
        neighbours[a].extend([b, c]);
        neighbours[b].extend([c, a]);
        neighbours[c].extend([a, b]);
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    neighbours
}

/// Whether a face next to each vertex is tilted against its normal by more than [`SMOOTH_COSINE`].
fn sharp_vertices(mesh: &TriMesh, normals: &[DVec3]) -> Vec<bool> {
    let mut sharp = vec![false; mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let Some(face) = mesh.area_vector(t).try_normalize() else { continue };
        for vertex in triangle.map(|corner| corner as usize) {
            sharp[vertex] |= face.dot(normals[vertex]) < SMOOTH_COSINE;
        }
    }
    sharp
}

/// Vertices within two edges of a smooth vertex, by ways that do not cross a sharp one.
fn two_edges_from(vertex: usize, neighbours: &[Vec<usize>], sharp: &[bool]) -> Vec<usize> {
    let mut reached = neighbours[vertex].clone();
    for between in neighbours[vertex].iter().filter(|between| !sharp[**between]) {
        reached.extend(&neighbours[*between]);
    }
    reached.sort_unstable();
    reached.dedup();
    reached.retain(|other| *other != vertex);
    reached
}

/// The quadratic form of a surface around a vertex with a unit normal through other vertices; `None` where
/// they do not determine it.
fn fit(mesh: &TriMesh, vertex: usize, normal: DVec3, others: &[usize]) -> Option<Curvature> {
    let centre = mesh.vertices[vertex];
    let size = others.iter().map(|other| mesh.vertices[*other].distance(centre)).fold(0.0, f64::max);
    let (u, v) = normal.any_orthonormal_pair();
    // Normal equations, in units of the farthest neighbour.
    let mut equations = [[0.0; UNKNOWNS + 1]; UNKNOWNS];
    for other in others {
        let apart = (mesh.vertices[*other] - centre) / size;
        let (x, y, z) = (apart.dot(u), apart.dot(v), -apart.dot(normal));
        let longer = (apart.length_squared() / (x * x + y * y)).min(MOST_LENGTHENING);
        let row = [0.5 * x * x * longer, x * y * longer, 0.5 * y * y * longer, x, y, z];
        let weight = apart.length_squared().recip();
        for (i, equation) in equations.iter_mut().enumerate() {
            for (sum, value) in equation.iter_mut().zip(row) {
                *sum += weight * row[i] * value;
            }
        }
    }
    let [a, b, c, e, f] = solve(equations)?;
    // Curvature tensor of the form in the plane of its own normal.
    let root = (1.0 + e * e + f * f).sqrt();
    let tilted = (normal + u * e + v * f) / root;
    let second = a * outer(u, u) + b * (outer(u, v) + outer(v, u)) + c * outer(v, v);
    Some(Curvature::of_tensor(second * (size * root).recip(), tilted))
}

/// Gaussian elimination with pivots on the diagonal of a positive matrix; `None` if it is singular.
fn solve(mut equations: [[f64; UNKNOWNS + 1]; UNKNOWNS]) -> Option<[f64; UNKNOWNS]> {
    let scale: [f64; UNKNOWNS] = std::array::from_fn(|i| equations[i][i]);
    for i in 0..UNKNOWNS {
        let pivot = equations[i][i];
        if !(pivot.is_finite() && pivot > LEAST_PIVOT * scale[i]) {
            return None;
        }
        let row = equations[i].map(|value| value / pivot);
        equations[i] = row;
        for other in (0..UNKNOWNS).filter(|other| *other != i) {
            let factor = equations[other][i];
            equations[other].iter_mut().zip(row).for_each(|(value, taken)| *value -= factor * taken);
        }
    }
    Some(equations.map(|row| row[UNKNOWNS]))
}

/// Gradient of normals that are linear over a triangle with the unit normal `face`, times its area \[m\]: no
/// division by a small one.
pub(super) fn normal_gradient(corners: [DVec3; 3], face: DVec3, normals: [DVec3; 3]) -> DMat3 {
    let mut gradient = DMat3::ZERO;
    for k in 0..3 {
        let normal = normals[k].reject_from_normalized(face);
        let opposite = corners[(k + 2) % 3] - corners[(k + 1) % 3];
        gradient += outer(normal, 0.5 * face.cross(opposite));
    }
    0.5 * (gradient + gradient.transpose())
}

/// Mean over the triangles at each vertex of the gradient of the normals, weighted by area and turned into
/// the tangent plane of the vertex.
fn face_tensors(mesh: &TriMesh, normals: &[DVec3]) -> Vec<DMat3> {
    let mut areas = vec![0.0; mesh.vertices.len()];
    let mut tensors = vec![DMat3::ZERO; mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(t);
        let area = mesh.area_vector(t).length();
        let Some(face) = mesh.area_vector(t).try_normalize() else { continue };
        let gradient = normal_gradient(corners, face, triangle.map(|corner| normals[corner as usize]));
        for vertex in triangle.map(|corner| corner as usize) {
            if normals[vertex] != DVec3::ZERO {
                let turn = DMat3::from_quat(DQuat::from_rotation_arc(face, normals[vertex]));
                tensors[vertex] += turn * gradient * turn.transpose();
                areas[vertex] += area;
            }
        }
    }
    let mean = |(tensor, area): (DMat3, &f64)| if *area > 0.0 { tensor * area.recip() } else { tensor };
    tensors.into_iter().zip(&areas).map(mean).collect()
}
