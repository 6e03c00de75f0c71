//! Integrals of products of two displacements over one cell, axis by axis (sum factorisation).
//!
//! ```text
//! G_ab(I, J) = ∫ ∂_a N_I ∂_b N_J dV,    M_IJ = ρ ∫ N_I N_J dV
//! K_IJ,ab = λ G_ab + μ (G_ba + δ_ab Σ_c G_cc)
//! ```
//!
//! Integrals are sums over the Gauss points of the cube, with the weights of the body in the cell. With N_I =
//! l_i(x) l_j(y) l_k(z) they contract one axis after another: 0.2 million products for each of seven
//! integrals, where point by point would take 11 million.

use glam::{DMat3, DVec3};

use super::basis::Basis;
use crate::fem::ElasticConstants;

/// The pairs of axes a ≤ b.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];

/// Integrals of one cell.
pub(super) struct CellMatrices {
    /// p + 1.
    local: usize,
    /// G_ab by [`PAIRS`] and pairs along x, y and z.
    slopes: [Vec<f64>; 6],
    /// ∫ N_I N_J.
    plain: Vec<f64>,
}

impl CellMatrices {
    /// For a cell of an edge \[m\] with weights at its Gauss points \[m³\].
    pub(super) fn new(basis: &Basis, edge: f64, weights: &[f64]) -> Self {
        let integral = |derived: Option<[usize; 2]>| {
            let table = |axis: usize| {
                products(basis, edge, derived.map_or([false; 2], |pair| pair.map(|a| a == axis)))
            };
            let points = basis.points().len();
            // Each contraction takes the leading point index and appends the pair of displacements.
            let by_x = contracted(weights, &table(0), points);
            let by_xy = contracted(&by_x, &table(1), points);
            contracted(&by_xy, &table(2), points)
        };
        CellMatrices {
            local: basis.degree() + 1,
            slopes: PAIRS.map(|pair| integral(Some(pair))),
            plain: integral(None),
        }
    }

    fn place(&self, i: usize, j: usize) -> usize {
        let m = self.local;
        let pair = |i: usize, j: usize| i * m + j;
        let [x, y, z] = [m * m, m, 1].map(|step| pair(i / step % m, j / step % m));
        (x * m * m + y) * m * m + z
    }

    /// Block of the stiffness [N/m].
    pub(super) fn stiffness(&self, i: usize, j: usize, constants: &ElasticConstants) -> DMat3 {
        let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, .. } = *constants;
        let (own, mirrored) = (self.place(i, j), self.place(j, i));
        let mut products = DMat3::ZERO;
        for (values, [a, b]) in self.slopes.iter().zip(PAIRS) {
            products.col_mut(b)[a] = values[own];
            products.col_mut(a)[b] = values[mirrored];
        }
        let dot = products.x_axis.x + products.y_axis.y + products.z_axis.z;
        lambda * products + mu * products.transpose() + DMat3::from_diagonal(DVec3::splat(mu * dot))
    }

    /// Factor of the mass, for unit density \[m³\].
    pub(super) fn mass(&self, i: usize, j: usize) -> f64 {
        self.plain[self.place(i, j)]
    }
}

/// Products of displacements i and j, differentiated where flagged, at the Gauss points: by pair, point.
fn products(basis: &Basis, edge: f64, derived: [bool; 2]) -> Vec<f64> {
    let (m, points) = (basis.degree() + 1, basis.points().len());
    let value = |q: usize, i: usize, derived: bool| {
        let (value, slope) = basis.at(q, i);
        if derived { slope / edge } else { value }
    };
    let each = (0..m * m).flat_map(|pair| (0..points).map(move |q| (pair / m, pair % m, q)));
    each.map(|(i, j, q)| value(q, i, derived[0]) * value(q, j, derived[1])).collect()
}

/// Sums over the first index of `from`; the pairs of `table` become the last.
fn contracted(from: &[f64], table: &[f64], points: usize) -> Vec<f64> {
    let (rest, pairs) = (from.len() / points, table.len() / points);
    let mut to = vec![0.0; rest * pairs];
    for (k, row) in to.chunks_exact_mut(pairs).enumerate() {
        for q in 0..points {
            let value = from[q * rest + k];
            for (pair, sum) in row.iter_mut().enumerate() {
                *sum += value * table[pair * points + q];
            }
        }
    }
    to
}
