//! Stiffness and mass of a ring with a quadratic triangle as section, for motions of azimuthal order m.
//!
//! ```text
//! u = U(r, y) cos mφ e_r + V(r, y) cos mφ e_y + W(r, y) sin mφ e_φ
//! ε_rr = U_r    ε_yy = V_y    ε_φφ = (U + m W)/r                                         each times cos mφ
//! 2 ε_ry = U_y + V_r          2 ε_rφ = W_r − W/r − m U/r    2 ε_yφ = W_y − m V/r         cos, sin, sin
//! ```
//!
//! The integral over φ is π, for m = 0 2π: there W is the twist, which is not coupled to U and V.
//!
//! On the axis a motion is smooth only if some of U, V and W vanish or agree. This is not imposed: a
//! violation has a strain of the order of 1/r in the first element, whose energy excludes it. Rigid motions
//! satisfy the conditions and have no energy at any point.

use glam::{DMat2, DMat3, DVec2, DVec3};

use crate::fem::ElasticConstants;
use crate::fem::element::ElementMatrices;
use crate::quadrature::TRIANGLE_FIFTH_DEGREE;

/// The six shape functions.
pub(super) fn shapes([a, b, c]: [f64; 3]) -> [f64; 6] {
    [a * (2.0 * a - 1.0), b * (2.0 * b - 1.0), c * (2.0 * c - 1.0), 4.0 * a * b, 4.0 * b * c, 4.0 * c * a]
}

/// Their derivatives by L₁ and L₂, with L₀ = 1 − L₁ − L₂.
fn gradients([a, b, c]: [f64; 3]) -> [DVec2; 6] {
    let (x, y) = (DVec2::X, DVec2::Y);
    let o = -x - y;
    [
        o * (4.0 * a - 1.0),
        x * (4.0 * b - 1.0),
        y * (4.0 * c - 1.0),
        4.0 * (a * x + b * o),
        4.0 * (b * y + c * x),
        4.0 * (c * o + a * y),
    ]
}

/// ∂(r, y)/∂(L₁, L₂).
pub(super) fn jacobian(nodes: &[DVec2; 6], at: [f64; 3]) -> DMat2 {
    let sum = |axis: usize| nodes.iter().zip(gradients(at)).map(|(x, g)| *x * g[axis]).sum::<DVec2>();
    DMat2::from_cols(sum(0), sum(1))
}

/// The matrices of an element; unknowns are U, V, W at each node.
pub(super) fn section_matrices(
    nodes: &[DVec2; 6],
    order: u32,
    constants: &ElasticConstants,
) -> ElementMatrices<6> {
    let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, density } = *constants;
    let m = f64::from(order);
    let turn = if order == 0 { std::f64::consts::TAU } else { std::f64::consts::PI };
    let mut stiffness = [[DMat3::ZERO; 6]; 6];
    let mut mass = [[0.0; 6]; 6];
    // Quadrature over the triangle: Jacobian, gradients, and volume of the ring.
    for (at, weight) in TRIANGLE_FIFTH_DEGREE {
        let by_reference = jacobian(nodes, at);
        let to_space = by_reference.inverse().transpose();
        let slopes = gradients(at).map(|g| to_space * g);
        let shape = shapes(at);
        let r: f64 = nodes.iter().zip(shape).map(|(x, n)| x.x * n).sum();
        let volume = turn * r * 0.5 * weight * by_reference.determinant();
        // Strain matrix: contributions of U, V, W of a node to the divergence, the three strains and the
        // three shears.
        let strains: [[DVec3; 7]; 6] = std::array::from_fn(|i| {
            let (DVec2 { x: a, y: b }, n) = (slopes[i], shape[i] / r);
            [
                DVec3::new(a + n, b, m * n),
                DVec3::new(a, 0.0, 0.0),
                DVec3::new(0.0, b, 0.0),
                DVec3::new(n, 0.0, m * n),
                DVec3::new(b, a, 0.0),
                DVec3::new(-m * n, 0.0, a - n),
                DVec3::new(0.0, -m * n, b),
            ]
        });
        // K = ∫ Bᵀ C B, M = ∫ ρ N N.
        let moduli = [lambda, 2.0 * mu, 2.0 * mu, 2.0 * mu, mu, mu, mu].map(|c| c * volume);
        for i in 0..6 {
            for j in 0..=i {
                for k in 0..7 {
                    let (own, other) = (strains[i][k] * moduli[k], strains[j][k]);
                    stiffness[i][j] += DMat3::from_cols(own * other.x, own * other.y, own * other.z);
                }
                mass[i][j] += density * volume * shape[i] * shape[j];
            }
        }
    }
    ElementMatrices { stiffness, mass }
}

/// Zero-energy motions of order m at a point of the section: axial translation and rotation (m = 0),
/// transverse translation and rotation (m = 1), none otherwise.
pub(super) fn rigid_motions(nodes: &[DVec2], order: u32) -> Vec<Vec<DVec3>> {
    let middle = nodes.iter().map(|x| x.y).sum::<f64>() / nodes.len().max(1) as f64;
    let all = |motion: &dyn Fn(DVec2) -> DVec3| nodes.iter().map(|x| motion(*x)).collect();
    match order {
        0 => vec![all(&|_| DVec3::Y), all(&|x| DVec3::Z * x.x)],
        1 => {
            vec![all(&|_| DVec3::new(1.0, 0.0, -1.0)), all(&|x| DVec3::new(x.y - middle, -x.x, middle - x.y))]
        }
        _ => Vec::new(),
    }
}
