//! The pressure on the surface for any surface motion.
//!
//! The right-hand side S a_n + γ (½ + K') a_n, which for the six rigid motions is assembled with the matrix,
//! is integrated here for a normal acceleration that is linear on every triangle and may jump between them.
//! Only the matrix is shared with [`reception`](super::reception): this is an independent check of it, and of
//! the radiated power.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;

use super::dense_system::ClassSystem;
use super::pair_integrals::PairIntegrator;
use super::pair_rules::{THREE_POINTS, TouchingRules};
use super::panels::along_curve;
use super::{TriangleSolver, narrow, widen};
use crate::radiation::RadiationError;

impl TriangleSolver {
    /// Pressures (ρ = 1) at the vertices of the surface, given the normal acceleration at the corners of each
    /// of its triangles; wavenumber [1/m]. Ignores mirror planes.
    ///
    /// # Errors
    /// [`RadiationError`].
    pub fn surface_pressure(
        &self,
        wavenumber: f64,
        accelerations: &[[f64; 3]],
    ) -> Result<Vec<Complex64>, RadiationError> {
        if self.images.len() > 1 {
            return Self::try_new(&self.mesh, wavenumber, self.equation)?
                .surface_pressure(wavenumber, accelerations);
        }
        // Triangles are stored along a curve, each with its corners in the same order.
        let centroids: Vec<_> = (0..self.mesh.triangles.len()).map(|t| self.mesh.centroid(t)).collect();
        let order = along_curve(&centroids, self.radius);
        let sorted: Vec<[f64; 3]> = order.iter().map(|t| accelerations[*t as usize]).collect();
        let right = self.motion_loads(wavenumber * self.radius, &sorted);
        let classes = self.all_classes();
        let matrix = self.matrices(wavenumber, &classes).swap_remove(0);
        let right = right.into_iter().map(narrow).collect();
        let solution = ClassSystem { size: classes[0].size, matrix, right }.solve();
        // Lengths were in R.
        let pressure = |vertex: u32| solution.get(vertex as usize).map(|p| widen(*p) * self.radius);
        let pressures: Vec<Complex64> =
            self.origin.iter().map(|(vertex, _)| pressure(*vertex).unwrap_or_default()).collect();
        match pressures.iter().all(|p| p.is_finite()) {
            true => Ok(pressures),
            false => Err(RadiationError::NotFinite { wavenumber }),
        }
    }

    /// ⟨φᵢ, S a + γ (½ + K') a⟩ at each vertex of the panels, k in 1/R.
    fn motion_loads(&self, k: f64, accelerations: &[[f64; 3]]) -> Vec<Complex64> {
        let panels = &self.panels;
        let gamma = Complex64::new(0.0, -self.coupling(k));
        // Near pairs: accurate integrals, in both directions.
        let rules = TouchingRules::new(2, 3, 3);
        let (nodes, signs) = ([k], self.images[0]);
        let integrator = PairIntegrator { test: panels, source: panels, signs, rules: &rules, nodes: &nodes };
        let pairs = &self.near.images[0].pairs;
        let blocks: Vec<_> =
            pairs.par_iter().map(|(t, s)| integrator.integrate(*t as usize, *s as usize)[0]).collect();
        let mut loads = vec![Complex64::ZERO; panels.vertices.len()];
        let mut near = vec![Vec::new(); panels.triangles.len()];
        for ((t, s), block) in pairs.iter().zip(blocks) {
            let (t, s) = (*t as usize, *s as usize);
            near[t].push(s);
            for i in 0..3 {
                for j in 0..3 {
                    let at = 3 * i + j;
                    let (row, column) = (panels.triangles[t][i] as usize, panels.triangles[s][j] as usize);
                    loads[row] += (block.value[at] + gamma * block.by_test[at]) * accelerations[s][j];
                    if t != s {
                        loads[column] +=
                            (block.value[at] + gamma * block.by_source[at]) * accelerations[t][i];
                    }
                }
            }
            if t != s {
                near[s].push(t);
            }
        }
        near.iter_mut().for_each(|near| near.sort_unstable());
        // Far pairs: three-point quadrature.
        let far: Vec<[Complex64; 3]> = (0..panels.triangles.len())
            .into_par_iter()
            .map(|t| self.far_loads(t, &near[t], k, gamma, accelerations))
            .collect();
        // Free term ½ γ ⟨φᵢ, a⟩.
        for (t, far) in far.iter().enumerate() {
            let own = accelerations[t];
            for i in 0..3 {
                let mass = panels.areas[t] / 12.0 * (own.iter().sum::<f64>() + own[i]);
                loads[panels.triangles[t][i] as usize] += far[i] + 0.5 * gamma * mass;
            }
        }
        loads
    }

    /// Loads of the distant triangles (those not in the sorted list `near`) on the corners of one triangle.
    fn far_loads(
        &self,
        t: usize,
        near: &[usize],
        k: f64,
        gamma: Complex64,
        accelerations: &[[f64; 3]],
    ) -> [Complex64; 3] {
        let panels = &self.panels;
        let normal = panels.normals[t];
        let points = THREE_POINTS.map(|(shares, _)| panels.point(t, shares));
        let mut fields = [Complex64::ZERO; 3];
        for s in (0..panels.triangles.len()).filter(|s| near.binary_search(s).is_err()) {
            // Point sources on the distant triangle.
            for (shares, weight) in THREE_POINTS {
                let y = panels.point(s, shares);
                let a: f64 = accelerations[s].iter().zip(shares).map(|(a, share)| a * share).sum();
                let strength = weight * panels.areas[s] * a / (4.0 * PI);
                for (field, x) in fields.iter_mut().zip(points) {
                    let d = x - y;
                    let r = d.length();
                    let (sine, cosine) = (k * r).sin_cos();
                    let value = Complex64::new(cosine, -sine) * (strength / r);
                    let slope = -Complex64::new(1.0, k * r) * (d.dot(normal) / (r * r));
                    *field += value * (1.0 + gamma * slope);
                }
            }
        }
        // Projection onto the three shape functions.
        std::array::from_fn(|i| {
            let parts = THREE_POINTS.iter().zip(fields);
            parts.map(|((shares, weight), field)| field * (shares[i] * weight * panels.areas[t])).sum()
        })
    }
}
