//! Stress and energy from displacements.
//!
//! ```text
//! σ = λ tr ε 1 + 2 μ ε,    ε = ½ (∇u + ∇uᵀ),    w = ½ σ : ε = (σ : σ − λ/(3λ + 2μ) (tr σ)²) / (4 μ)
//! ```
//!
//! In a straight quadratic tetrahedron the stress is linear, and discontinuous at its faces. At a corner the
//! recovered stress is that of the linear field closest, in the sense of ∫ |σ* − σ|² dV, to the stress of all
//! adjacent elements. It is more accurate than that of any of them, and exact where the stress of the body is
//! linear, as in bending.
//!
//! Source: Zienkiewicz and Zhu (1992), "The superconvergent patch recovery". Differs: the fit is by volume,
//! which linear element stress allows in closed form, instead of by sampling points.
//!
//! Between corners the recovered stress is linear. Its largest principal value is convex, so that the maximum
//! lies at a corner.

use glam::{DMat3, DVec3};

use super::{Deformation, SymmetricTensor};
use crate::fem::ElasticConstants;
use crate::mesh::tetrahedra::{EDGES, TetMesh};

/// Precomputed weights that depend on the mesh alone.
pub(super) struct Recovery {
    lambda: f64,
    mu: f64,
    /// Share of the stress at corner k of an element in the recovered one at its corner c: `[element][c][k]`.
    shares: Vec<[[f64; 4]; 4]>,
    /// Volumes of the elements \[m³\].
    volumes: Vec<f64>,
    /// The sum over the elements at each corner \[m³\].
    around: Vec<f64>,
}

impl Recovery {
    pub(super) fn new(mesh: &TetMesh, constants: &ElasticConstants) -> Self {
        let corners_of = |e: &[u32; 10]| [e[0], e[1], e[2], e[3]].map(|n| mesh.nodes[n as usize]);
        let volume = |e: &[u32; 10]| {
            let [a, b, c, d] = corners_of(e);
            (b - a).cross(c - a).dot(d - a) / 6.0
        };
        let volumes: Vec<f64> = mesh.elements.iter().map(volume).collect();
        let mut around = vec![0.0; mesh.corners];
        // First and second moments of each patch about its corner, where rounding is least.
        let mut first = vec![DVec3::ZERO; mesh.corners];
        let mut second = vec![DMat3::ZERO; mesh.corners];
        for (element, volume) in mesh.elements.iter().zip(&volumes) {
            let corners = corners_of(element);
            for n in element[..4].iter().map(|n| *n as usize) {
                let arms = corners.map(|x| x - mesh.nodes[n]);
                let sum: DVec3 = arms.iter().sum();
                let outer = |d: DVec3| DMat3::from_cols(d * d.x, d * d.y, d * d.z);
                around[n] += volume;
                first[n] += sum * (0.25 * volume);
                second[n] += (outer(sum) + arms.into_iter().map(outer).sum::<DMat3>()) * (0.05 * volume);
            }
        }
        // Position of the corner relative to the patch's centroid, in the metric of the fit.
        let slopes: Vec<DVec3> = (0..mesh.corners)
            .map(|n| {
                let middle = first[n] / around[n];
                let outer = DMat3::from_cols(middle * middle.x, middle * middle.y, middle * middle.z);
                (second[n] - outer * around[n]).inverse() * -middle
            })
            .collect();
        // Weight of the stress at corner k in the fit at corner c.
        let shares_of = |(element, volume): (&[u32; 10], &f64)| {
            let corners = corners_of(element);
            std::array::from_fn(|c| {
                let n = element[c] as usize;
                let arms = corners.map(|x| x - mesh.nodes[n] - first[n] / around[n]);
                let sum: DVec3 = arms.iter().sum();
                arms.map(|arm| 0.25 * volume / around[n] + 0.05 * volume * slopes[n].dot(sum + arm))
            })
        };
        let shares = mesh.elements.iter().zip(&volumes).map(shares_of).collect();
        let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, .. } = *constants;
        Recovery { lambda, mu, shares, volumes, around }
    }

    /// Stress at the four corners of an element \[Pa\].
    fn in_element(&self, mesh: &TetMesh, element: usize, displacement: &[DVec3]) -> [SymmetricTensor; 4] {
        let nodes = mesh.elements[element];
        let [a, b, c, d] = [nodes[0], nodes[1], nodes[2], nodes[3]].map(|n| mesh.nodes[n as usize]);
        // Gradients of the barycentric coordinates.
        let scale = 1.0 / (6.0 * self.volumes[element]);
        let g1 = (c - a).cross(d - a) * scale;
        let g2 = (d - a).cross(b - a) * scale;
        let g3 = (b - a).cross(c - a) * scale;
        let gradients = [-(g1 + g2 + g3), g1, g2, g3];
        let u = nodes.map(|n| displacement[n as usize]);
        let outer = |u: DVec3, g: DVec3| DMat3::from_cols(u * g.x, u * g.y, u * g.z);
        // At corner k, only its own shape function and those of adjacent midpoints differ from −g.
        let mut slopes = [DMat3::ZERO; 4];
        for k in 0..4 {
            let own = outer(u[k], gradients[k]);
            slopes
                .iter_mut()
                .enumerate()
                .for_each(|(other, s)| *s += own * if other == k { 3.0 } else { -1.0 });
        }
        // Midpoints contribute to both ends of their edge.
        for ([i, j], middle) in EDGES.into_iter().zip(&u[4..]) {
            slopes[i] += outer(4.0 * *middle, gradients[j]);
            slopes[j] += outer(4.0 * *middle, gradients[i]);
        }
        // Hooke's law.
        slopes.map(|slope| {
            let strain = SymmetricTensor::of(slope);
            let pressure = self.lambda * strain.trace();
            let mut stress = strain * (2.0 * self.mu);
            stress.diagonal += pressure;
            stress
        })
    }

    /// Recovered stress at the corners \[Pa\].
    pub(super) fn corner_stress(&self, mesh: &TetMesh, displacement: &[DVec3]) -> Vec<SymmetricTensor> {
        let mut recovered = vec![SymmetricTensor::ZERO; mesh.corners];
        for e in 0..mesh.elements.len() {
            self.gather(mesh, e, &self.in_element(mesh, e, displacement), &mut recovered);
        }
        recovered
    }

    fn gather(
        &self,
        mesh: &TetMesh,
        element: usize,
        stress: &[SymmetricTensor; 4],
        recovered: &mut [SymmetricTensor],
    ) {
        for (corner, shares) in mesh.elements[element].iter().zip(&self.shares[element]) {
            let to = &mut recovered[*corner as usize];
            for (share, stress) in shares.iter().zip(stress) {
                to.diagonal += stress.diagonal * *share;
                to.off_diagonal += stress.off_diagonal * *share;
            }
        }
    }

    /// Stress and energy of a displacement.
    pub(super) fn deformation(&self, mesh: &TetMesh, displacement: Vec<DVec3>) -> Deformation {
        let count = mesh.elements.len();
        let mut corner_stress = vec![SymmetricTensor::ZERO; mesh.corners];
        let mut corner_energy_density = vec![0.0; mesh.corners];
        let (mut element_stress, mut element_energy_density) =
            (Vec::with_capacity(count), Vec::with_capacity(count));
        let spherical = self.lambda / (3.0 * self.lambda + 2.0 * self.mu);
        let mut strain_energy = 0.0;
        // Stress of the element, added to its corners.
        for e in 0..count {
            let stress = self.in_element(mesh, e, &displacement);
            self.gather(mesh, e, &stress, &mut corner_stress);
            let sum = stress.iter().fold(SymmetricTensor::ZERO, |sum, s| sum + *s);
            element_stress.push(sum * 0.25);
            // Mean over an element of a product of two linear fields.
            let square = |s: SymmetricTensor| s.contract(s) - spherical * s.trace() * s.trace();
            let mean = (square(sum) + stress.into_iter().map(square).sum::<f64>()) / 20.0;
            let density = mean / (4.0 * self.mu);
            element_energy_density.push(density);
            strain_energy += density * self.volumes[e];
            // Energy density at the corners, weighted by volume.
            for corner in mesh.elements[e][..4].iter().map(|n| *n as usize) {
                corner_energy_density[corner] += density * self.volumes[e] / self.around[corner];
            }
        }
        Deformation {
            displacement,
            strain_energy,
            corner_stress,
            element_stress,
            corner_energy_density,
            element_energy_density,
        }
    }
}
