//! Regular waves about the origin, tested on the triangles of a surface: the right-hand sides of
//! [`reception`](super::reception).
//!
//! ```text
//! u = jₙ(kr) Yₙₘ = kⁿ uₙ(k²r²) rⁿYₙₘ,      ⟨φᵢ, u + γ ∂u/∂n⟩
//! ```
//!
//! The solid harmonics rⁿYₙₘ and their slopes along the normal do not depend on k. Their recurrences take
//! most of the time, so that [`SurfaceHarmonics`] keeps them for all wavenumbers where memory allows.

use clangor_core::math::radial::{regular, reverse_bessel};
use clangor_core::math::spherical_harmonics::{count, solid_harmonics_with_gradient};
use glam::DVec3;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use super::pair_rules::six_points;
use super::parity_classes::ParityClass;
use super::{TriangleSolver, narrow};

/// Points of the quadrature on a triangle.
pub(super) const POINTS: usize = 6;
/// Most memory of the harmonics [bytes].
const MEMORY: usize = 1 << 30;

/// Solid harmonics and their normal slopes at the quadrature points of all triangles.
#[derive(Clone, Debug)]
pub struct SurfaceHarmonics {
    /// Highest order.
    pub(super) order: usize,
    /// By triangle, point, and value or slope.
    pub(super) values: Vec<f64>,
}

/// What a wavenumber and its harmonics have in common.
struct Wave {
    square: f64,
    coupling: f64,
    scale: f64,
    order: usize,
}

impl TriangleSolver {
    /// The harmonics up to an order about the origin, of size 1 on the sphere of `radius` \[m\]; `None` where
    /// they take too much memory.
    pub fn surface_harmonics(&self, order: usize, radius: f64) -> Option<SurfaceHarmonics> {
        let share = 2 * POINTS * count(order);
        let triangles = self.panels.triangles.len();
        if share * triangles * size_of::<f64>() > MEMORY {
            return None;
        }
        let mut values = vec![0.0; share * triangles];
        let scale = self.radius / radius;
        values.par_chunks_exact_mut(share).enumerate().for_each(|(t, values)| {
            self.harmonics_on(t, scale, order, values);
        });
        Some(SurfaceHarmonics { order, values })
    }

    /// Harmonics and their normal slopes at the points of a triangle.
    pub(super) fn harmonics_on(&self, t: usize, scale: f64, order: usize, values: &mut [f64]) {
        let normal = self.panels.normals[t];
        let (mut harmonics, mut gradients) = (Vec::new(), Vec::new());
        for ((shares, _), values) in six_points().iter().zip(values.chunks_exact_mut(2 * count(order))) {
            let x = self.panels.point(t, *shares) * scale;
            solid_harmonics_with_gradient(x, order, &mut harmonics, &mut gradients);
            let (of_harmonics, of_slopes) = values.split_at_mut(count(order));
            of_harmonics.copy_from_slice(&harmonics);
            of_slopes.iter_mut().zip(&gradients).for_each(|(slope, g)| *slope = g.dot(normal));
        }
    }

    /// ⟨φᵢ, u + γ ∂u/∂n⟩ times θₙ(ikR), for the harmonics of each class, column after column. `known` are
    /// harmonics of at least this order.
    pub(super) fn incident(
        &self,
        (wavenumber, order, radius): (f64, usize, f64),
        classes: &[ParityClass],
        members: &[Vec<usize>],
        known: Option<&SurfaceHarmonics>,
    ) -> Vec<Vec<Complex32>> {
        let kappa = wavenumber * radius;
        let scale = self.radius / radius;
        let coupling = self.coupling(wavenumber * self.radius) * scale;
        let wave = Wave { square: kappa * kappa, coupling, scale, order };
        // Frequency-dependent factors of the orders.
        let mut theta = Vec::new();
        reverse_bessel(Complex64::new(0.0, kappa), order, &mut theta);
        let mut right: Vec<Vec<Complex32>> =
            classes.iter().zip(members).map(|(c, m)| vec![Complex32::ZERO; c.size * m.len()]).collect();
        let known = known.filter(|known| known.order >= order);
        let stored = known.map_or(order, |known| known.order);
        let share = 2 * POINTS * count(stored);
        let mut own = vec![0.0; if known.is_some() { 0 } else { share }];
        let mut sums = vec![[0.0; 2]; 3 * count(order)];
        for t in 0..self.panels.triangles.len() {
            let harmonics = match known {
                Some(known) => &known.values[t * share..][..share],
                None => {
                    self.harmonics_on(t, scale, order, &mut own);
                    &own
                }
            };
            self.tested(t, &wave, harmonics, count(stored), &mut sums);
            // Scatter to the unknowns of each class.
            for ((class, harmonics), right) in classes.iter().zip(members).zip(&mut right) {
                for (column, harmonic) in harmonics.iter().enumerate() {
                    let factor = theta[harmonic.isqrt()] * self.panels.areas[t];
                    for (corner, vertex) in self.panels.triangles[t].iter().enumerate() {
                        let unknown = class.unknowns[*vertex as usize] as usize;
                        if unknown < class.size {
                            let [re, im] = sums[corner * count(order) + harmonic];
                            right[column * class.size + unknown] += narrow(Complex64::new(re, im) * factor);
                        }
                    }
                }
            }
        }
        right
    }

    /// u + γ ∂u/∂n on a triangle against its three shape functions, by corner and harmonic.
    fn tested(&self, t: usize, wave: &Wave, harmonics: &[f64], stored: usize, sums: &mut [[f64; 2]]) {
        let Wave { square, coupling, scale, order } = *wave;
        let normal: DVec3 = self.panels.normals[t];
        let mut radial = Vec::new();
        sums.fill([0.0; 2]);
        for ((shares, weight), at) in six_points().iter().zip(harmonics.chunks_exact(2 * stored)) {
            let x = self.panels.point(t, *shares) * scale;
            regular(Complex64::from(square * x.length_squared()), order + 1, &mut radial);
            let along = x.dot(normal);
            let (values, slopes) = at.split_at(stored);
            for n in 0..=order {
                let (here, above) = (radial[n].re, square * radial[n + 1].re * along);
                let of_order = n * n..(n + 1) * (n + 1);
                for i in of_order {
                    let slope = here * slopes[i] - above * values[i];
                    let value = [here * values[i], -coupling * slope];
                    for (corner, share) in shares.iter().enumerate() {
                        let sum = &mut sums[corner * count(order) + i];
                        sum[0] += weight * share * value[0];
                        sum[1] += weight * share * value[1];
                    }
                }
            }
        }
    }
}
