//! Rotation of multipoles from the frame of a cell to that of the body.
//!
//! ```text
//! cₙₘ = Σ c'ₙₘ' ∫ Yₙₘ(d) Yₙₘ'(Fᵀd) dΩ
//! ```
//!
//! F has the axes of the cell as its columns. Orders do not mix. The integrals are exact by Gauss–Legendre
//! points in z and equal steps in φ.

use std::f64::consts::{PI, TAU};

use clangor_core::math::spherical_harmonics::solid_harmonics;
use glam::{DMat3, DVec3};
use num_complex::Complex64;

use crate::quadrature::gauss_legendre;

/// The rotation of each order: rows of the body's frame, columns of the cell's.
#[derive(Clone, Debug)]
pub(super) struct MultipoleRotation(Vec<Vec<f64>>);

impl MultipoleRotation {
    /// Rotations of all orders up to the highest.
    pub(super) fn new(frame: DMat3, order: usize) -> Self {
        let mut rotations: Vec<Vec<f64>> = (0..=order).map(|n| vec![0.0; (2 * n + 1).pow(2)]).collect();
        let (mut there, mut here) = (Vec::new(), Vec::new());
        let around = 2 * order + 2;
        for (u, weight) in gauss_legendre(order + 1) {
            for k in 0..around {
                let phi = TAU * k as f64 / around as f64;
                let z = 2.0 * u - 1.0;
                let across = (1.0 - z * z).sqrt();
                let direction = DVec3::new(across * phi.cos(), across * phi.sin(), z);
                solid_harmonics(direction, order, &mut here);
                solid_harmonics(frame.transpose() * direction, order, &mut there);
                let weight = 4.0 * PI * weight / around as f64;
                for (n, rotation) in rotations.iter_mut().enumerate() {
                    let of_order = n * n..(n + 1) * (n + 1);
                    let rows = rotation.chunks_exact_mut(2 * n + 1);
                    for (row, y) in rows.zip(&here[of_order.clone()]) {
                        let share = weight * y;
                        row.iter_mut().zip(&there[of_order.clone()]).for_each(|(sum, y)| *sum += share * y);
                    }
                }
            }
        }
        MultipoleRotation(rotations)
    }

    /// The highest order.
    pub(super) fn order(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    /// Rotates the multipoles of some motions.
    pub(super) fn apply(&self, coefficients: &mut [Vec<Complex64>]) {
        for of_motion in coefficients {
            for (n, rotation) in self.0.iter().enumerate() {
                let Some(own) = of_motion.get_mut(n * n..(n + 1) * (n + 1)) else { break };
                let of_cell = own.to_vec();
                for (c, row) in own.iter_mut().zip(rotation.chunks_exact(2 * n + 1)) {
                    *c = row.iter().zip(&of_cell).map(|(share, c)| c * share).sum();
                }
            }
        }
    }
}
