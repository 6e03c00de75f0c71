//! Quality of tetrahedra: dihedral angles of the corners, Jacobian of the curved element.
//!
//! ```text
//! J(L) = det ∂x/∂(L₁, L₂, L₃),    volume = ∫ J dL
//! ```
//!
//! A straight element has J = 6 × its volume everywhere. Where J is not positive the element is folded.

use glam::{DMat3, DVec3};

use super::TetMesh;
use crate::quadrature::TETRAHEDRON_FIFTH_DEGREE;

/// Quality measures of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Number of elements.
    pub elements: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Volume, curved edges included \[m³\].
    pub volume: f64,
    /// Smallest dihedral angle between faces through the corners \[rad\].
    pub smallest_angle: f64,
    /// Largest dihedral angle \[rad\].
    pub largest_angle: f64,
    /// Smallest Jacobian over that of the straight element.
    pub least_jacobian: f64,
}

/// ∂x/∂(L₁, L₂, L₃) at barycentric coordinates L.
pub(crate) fn jacobian(nodes: &[DVec3; 10], at: [f64; 4]) -> DMat3 {
    let gradients = shape_gradients(at);
    let mut columns = [DVec3::ZERO; 3];
    for (node, gradient) in nodes.iter().zip(&gradients) {
        for k in 0..3 {
            columns[k] += *node * gradient[k];
        }
    }
    DMat3::from_cols(columns[0], columns[1], columns[2])
}

/// Derivatives of the ten shape functions by L₁, L₂, L₃, with L₀ = 1 − L₁ − L₂ − L₃.
pub(crate) fn shape_gradients(at: [f64; 4]) -> [[f64; 3]; 10] {
    const SLOPES: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    std::array::from_fn(|n| {
        if n < 4 {
            SLOPES[n].map(|s| s * (4.0 * at[n] - 1.0))
        } else {
            let [i, j] = super::EDGES[n - 4];
            std::array::from_fn(|k| 4.0 * (at[i] * SLOPES[j][k] + at[j] * SLOPES[i][k]))
        }
    })
}

/// Six times the volume of the tetrahedron of the corners.
pub(super) fn straight_jacobian(nodes: &[DVec3; 10]) -> f64 {
    (nodes[1] - nodes[0]).cross(nodes[2] - nodes[0]).dot(nodes[3] - nodes[0])
}

/// The smallest Jacobian at the ten nodes and the four inner points of the quadrature.
pub(super) fn least_jacobian(nodes: &[DVec3; 10]) -> f64 {
    let corners = (0..4).map(|k| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }));
    let middles =
        super::EDGES.iter().map(|e| std::array::from_fn(|i| if i == e[0] || i == e[1] { 0.5 } else { 0.0 }));
    let inner = (0..4).map(|k| std::array::from_fn(|i| if i == k { 0.586 } else { 0.138 }));
    corners
        .chain(middles)
        .chain(inner)
        .map(|at| jacobian(nodes, at).determinant())
        .fold(f64::INFINITY, f64::min)
}

/// Measures a mesh.
pub(super) fn shape_of(mesh: &TetMesh) -> Quality {
    let mut quality = Quality {
        elements: mesh.elements.len(),
        nodes: mesh.nodes.len(),
        volume: 0.0,
        smallest_angle: f64::INFINITY,
        largest_angle: 0.0,
        least_jacobian: f64::INFINITY,
    };
    for e in 0..mesh.elements.len() {
        let nodes = mesh.positions(e);
        let relative = least_jacobian(&nodes) / straight_jacobian(&nodes);
        quality.least_jacobian = quality.least_jacobian.min(relative);
        let volume = |(at, weight): &([f64; 4], f64)| weight * jacobian(&nodes, *at).determinant() / 6.0;
        quality.volume += TETRAHEDRON_FIFTH_DEGREE.iter().map(volume).sum::<f64>();
        for angle in dihedral_angles([nodes[0], nodes[1], nodes[2], nodes[3]]) {
            quality.smallest_angle = quality.smallest_angle.min(angle);
            quality.largest_angle = quality.largest_angle.max(angle);
        }
    }
    quality
}

/// The six angles between faces.
pub(super) fn dihedral_angles(corners: [DVec3; 4]) -> [f64; 6] {
    let normal = super::FACES.map(|f| {
        let [a, b, c] = f.map(|k| corners[k]);
        (b - a).cross(c - a).normalize()
    });
    // The faces that share an edge are those opposite the two other corners.
    super::EDGES.map(|[i, j]| (-normal[i].dot(normal[j])).clamp(-1.0, 1.0).acos())
}
