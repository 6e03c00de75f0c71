//! Stiffness and mass of one quadratic tetrahedron.
//!
//! With the gradients g of the shape functions, the 3 × 3 block of the nodes i and j is
//!
//! ```text
//! K_ij = ∫ λ g_i g_jᵀ + μ (g_j g_iᵀ + (g_i·g_j) 1) dV,    M_ij = 1 ∫ ρ N_i N_j dV
//! ```
//!
//! Both are integrated by one rule of fifth degree. For straight edges that exceeds the required degrees (two
//! and four); for curved ones its error is below that of the shape functions. Rigid motions have no energy at
//! any point, whatever the edges, because the same shape functions carry displacement and position.

use glam::{DMat3, DVec3};

use super::ElasticConstants;
use crate::mesh::tetrahedra::EDGES;
use crate::mesh::tetrahedra::quality::{jacobian, shape_gradients};
use crate::quadrature::TETRAHEDRON_FIFTH_DEGREE;

/// Matrices of an element of N nodes: `stiffness[i][j]` and `mass[i][j]` for i ≥ j.
#[derive(Clone, Debug)]
pub struct ElementMatrices<const N: usize> {
    /// 3 × 3 blocks [N/m].
    pub stiffness: [[DMat3; N]; N],
    /// Factors of unit blocks \[kg\].
    pub mass: [[f64; N]; N],
}

/// The shape functions at barycentric coordinates.
pub(super) fn shapes(at: [f64; 4]) -> [f64; 10] {
    std::array::from_fn(|n| {
        if n < 4 {
            at[n] * (2.0 * at[n] - 1.0)
        } else {
            let [i, j] = EDGES[n - 4];
            4.0 * at[i] * at[j]
        }
    })
}

/// The matrices of an element with the given node positions \[m\].
pub fn element_matrices(nodes: &[DVec3; 10], constants: &ElasticConstants) -> ElementMatrices<10> {
    let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, density } = *constants;
    let mut stiffness = [[DMat3::ZERO; 10]; 10];
    let mut mass = [[0.0; 10]; 10];
    for (at, weight) in TETRAHEDRON_FIFTH_DEGREE {
        let by_reference = jacobian(nodes, at);
        let volume = weight * by_reference.determinant() / 6.0;
        let to_space = by_reference.inverse().transpose();
        let gradients = shape_gradients(at).map(|g| to_space * DVec3::from_array(g));
        let shape = shapes(at);
        for i in 0..10 {
            let along = gradients[i] * volume;
            let heavy = density * volume * shape[i];
            for j in 0..=i {
                let g = gradients[j];
                let cross = DMat3::from_cols(along * g.x, along * g.y, along * g.z);
                let diagonal = DMat3::from_diagonal(DVec3::splat(mu * along.dot(g)));
                stiffness[i][j] += cross * lambda + cross.transpose() * mu + diagonal;
                mass[i][j] += heavy * shape[j];
            }
        }
    }
    ElementMatrices { stiffness, mass }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curved_element_moves_rigidly_without_force() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.1, 1.2, 0.0), DVec3::new(0.2, 0.3, 0.9)];
        let mut nodes: [DVec3; 10] = std::array::from_fn(|n| match n {
            0..4 => corners[n],
            _ => 0.5 * (corners[EDGES[n - 4][0]] + corners[EDGES[n - 4][1]]),
        });
        nodes[5] += DVec3::new(0.05, 0.08, 0.02);
        let constants = ElasticConstants { lame_lambda: 2.0, shear_modulus: 1.0, density: 3.0 };
        let element = element_matrices(&nodes, &constants);
        let block = |i: usize, j: usize| {
            if i >= j { element.stiffness[i][j] } else { element.stiffness[j][i].transpose() }
        };
        let force = |u: &dyn Fn(DVec3) -> DVec3| {
            (0..10)
                .map(|i| (0..10).map(|j| block(i, j) * u(nodes[j])).sum::<DVec3>().length())
                .fold(0.0, f64::max)
        };
        let turn = DVec3::new(0.3, -1.0, 0.7);
        // Residual seen: 2e-15.
        assert!(force(&|_| DVec3::ONE) < 1e-13);
        assert!(force(&|x| turn.cross(x)) < 1e-13);
        assert!(force(&|x| x) > 1.0);
    }
}
