//! Projection of meridian pressures onto multipoles, and rotation of rigid motions to multipoles about any
//! axes.
//!
//! About the body's own axis a pressure of order m has harmonics of order m only, so that the integral of
//! [`multipole_projection`](crate::fitting::multipole_projection) is over the meridian alone:
//!
//! ```text
//! c_n = θₙ(ikR)/R^{n+1} · (2π, π) ∫ [ p_m ∂/∂n (u_n(kr) rⁿ Y_nm) + a_m u_n(kr) rⁿ Y_nm ] r ds
//! ```
//!
//! with 2π for m = 0. Rigid motions have m = 0 and 1. In the axes of the body they spread over all orders.
//! With e any direction across the axis and φ counted from it, the addition theorem for Pₙ(a·x) and its
//! derivative when a tilts towards e give
//!
//! ```text
//! Y_n0(about a) = √(4π/(2n+1)) Σ_m Y_nm(a) Y_nm(x)
//! Y_n1(about a, from e) = √(8π/((2n+1) n (n+1))) Σ_m [e·∇(rⁿY_nm)](a) Y_nm(x)
//! ```

use std::f64::consts::PI;

use clangor_core::math::radial::{regular, reverse_bessel};
use clangor_core::math::spherical_harmonics::{count, solid_harmonics_with_gradient};
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::{DVec2, DVec3};
use num_complex::Complex64;

use super::panels::Panels;

/// Rigid motions: along the axis (m = 0), across it, and turning about an axis across it (m = 1).
pub(super) const MOTIONS: usize = 3;

/// a_n of the motions at a point of the meridian with this normal.
pub(super) fn motion(x: DVec2, normal: DVec2) -> [f64; MOTIONS] {
    [normal.y, normal.x, x.x * normal.y - x.y * normal.x]
}

/// Harmonics of one order m at a node.
struct NodeHarmonics {
    /// |x|², x·n dS, in units of R.
    square: f64,
    along: f64,
    /// dS \[m²\].
    area: f64,
    /// For each n from m: n·∇(rⁿY) dS and rⁿY.
    terms: Vec<[f64; 2]>,
}

/// The projection of order m from one set of panels.
pub(super) struct AxisProjection {
    nodes: Vec<NodeHarmonics>,
    radius: f64,
    around: usize,
    order: usize,
}

impl AxisProjection {
    /// For pressures proportional to cos mφ or sin mφ, m = `around`, and coefficients on the sphere of
    /// `radius` \[m\] up to an order.
    pub(super) fn new(panels: &Panels, radius: f64, around: usize, order: usize) -> Self {
        let turn = if around == 0 { 2.0 * PI } else { PI };
        let steps: Vec<[f64; 2]> = (around + 1..=order).map(|n| recurrence(n, around)).collect();
        let nodes = panels
            .nodes
            .iter()
            .map(|node| {
                let x = node.position / radius;
                let area = turn * node.weight * node.position.x;
                let normal = node.normal * area;
                let terms = harmonics(x, around, &steps)
                    .into_iter()
                    .map(|(value, gradient)| [gradient.dot(normal), value])
                    .collect();
                let area = area * node.normal.length();
                NodeHarmonics { square: x.length_squared(), along: x.dot(normal), area, terms }
            })
            .collect();
        AxisProjection { nodes, radius, around, order }
    }

    /// c_n, n from 0, of the pressures and normal accelerations at the nodes.
    pub(super) fn coefficients(
        &self,
        pressure: &[Complex64],
        acceleration: &[f64],
        wavenumber: Complex64,
    ) -> Vec<Complex64> {
        let mut sums = vec![Complex64::ZERO; self.order + 1];
        let square = wavenumber * wavenumber * (self.radius * self.radius);
        let mut radial = Vec::new();
        for ((node, p), a) in self.nodes.iter().zip(pressure).zip(acceleration) {
            regular(square * node.square, self.order + 1, &mut radial);
            let (p, a) = (p / self.radius, a * node.area);
            for ([normal, value], n) in node.terms.iter().zip(self.around..) {
                // u'_n(z) = −z u_{n+1}(z).
                let slope = radial[n] * *normal - square * radial[n + 1] * (node.along * value);
                sums[n] += p * slope + radial[n] * (value * a);
            }
        }
        let mut scale = Vec::new();
        reverse_bessel(Complex64::I * wavenumber * self.radius, self.order, &mut scale);
        sums.iter_mut().zip(&scale).for_each(|(c, s)| *c *= s / self.radius);
        sums
    }
}

/// rⁿ Y_nm and its gradient at φ = 0, for n = m and for each recurrence step, in the half-plane (r, y) with y
/// as the polar axis.
fn harmonics(x: DVec2, m: usize, steps: &[[f64; 2]]) -> Vec<(f64, DVec2)> {
    let mut size = (0.25 / PI).sqrt();
    for k in 1..=m {
        size *= ((2 * k + 1) as f64 / (2 * k) as f64).sqrt();
    }
    let (value, slope) = match m {
        0 => (size, 0.0),
        _ => {
            let below = std::f64::consts::SQRT_2 * size * x.x.powi(m as i32 - 1);
            (below * x.x, m as f64 * below)
        }
    };
    let mut out = vec![(value, DVec2::new(slope, 0.0))];
    let square = x.length_squared();
    let mut before = (0.0, DVec2::ZERO);
    for (k, [a, b]) in steps.iter().enumerate() {
        let here = out[k];
        let value = a * (x.y * here.0) - b * square * before.0;
        let gradient =
            *a * (DVec2::Y * here.0 + x.y * here.1) - *b * (2.0 * x * before.0 + square * before.1);
        out.push((value, gradient));
        before = here;
    }
    out
}

/// a and b of `P̄_n = a z P̄_{n−1} − b r² P̄_{n−2}` for fully normalised Legendre functions of degree m < n.
fn recurrence(n: usize, m: usize) -> [f64; 2] {
    let (n, m) = (n as f64, m as f64);
    let below = n * n - m * m;
    let before = (n - 1.0).powi(2) - m * m;
    let b = ((2.0 * n + 1.0) * before / ((2.0 * n - 3.0) * below)).max(0.0).sqrt();
    [((4.0 * n * n - 1.0) / below).sqrt(), b]
}

/// Rotates coefficients about the axis into those of the six motions in the body's frame.
pub(super) struct AxisTurn {
    axis: DVec3,
    /// √(4π/(2n+1)) Y_nm(a).
    zonal: Vec<f64>,
    /// √(8π/((2n+1) n (n+1))) ∇(rⁿY_nm)(a).
    tilted: Vec<DVec3>,
}

impl AxisTurn {
    /// For the axis of revolution along a unit vector.
    pub(super) fn new(axis: DVec3, order: usize) -> Self {
        let (mut zonal, mut tilted) = (Vec::new(), Vec::new());
        solid_harmonics_with_gradient(axis, order, &mut zonal, &mut tilted);
        for n in 0..=order {
            let degree = n as f64;
            let odd = 2.0 * degree + 1.0;
            let (a, b) =
                ((4.0 * PI / odd).sqrt(), (8.0 * PI / (odd * (degree * (degree + 1.0)).max(1.0))).sqrt());
            for i in n * n..(n + 1) * (n + 1) {
                zonal[i] *= a;
                tilted[i] *= b;
            }
        }
        AxisTurn { axis, zonal, tilted }
    }

    /// The coefficients of the six motions, each a combination of the motions along and across the axis.
    pub(super) fn coefficients(
        &self,
        about_axis: &[Vec<Complex64>; MOTIONS],
    ) -> [Vec<Complex64>; RIGID_DOFS] {
        let order = about_axis[0].len() - 1;
        std::array::from_fn(|degree| {
            let (along, across) = decompose(self.axis, degree);
            let rotated = &about_axis[if degree < 3 { 1 } else { 2 }];
            let mut out = Vec::with_capacity(count(order));
            for n in 0..=order {
                for i in n * n..(n + 1) * (n + 1) {
                    out.push(
                        about_axis[0][n] * (along * self.zonal[i]) + rotated[n] * across.dot(self.tilted[i]),
                    );
                }
            }
            out
        })
    }
}

/// Splits a unit motion into a component along the axis and a direction e across it. φ is measured from e.
///
/// (e_i × x)·n = (a × e_i)·(unit r) (r n_y − y n_r): a rotation has no part along the axis.
pub(super) fn decompose(axis: DVec3, degree: usize) -> (f64, DVec3) {
    let unit = DVec3::AXES[degree % 3];
    if degree < 3 {
        let along = unit.dot(axis);
        (along, unit - axis * along)
    } else {
        (0.0, axis.cross(unit))
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::math::spherical_harmonics::index;

    use super::*;

    #[test]
    fn harmonics_are_those_of_the_whole_space_at_no_angle() {
        let (mut values, mut gradients) = (Vec::new(), Vec::new());
        let x = DVec2::new(0.4, -0.7);
        solid_harmonics_with_gradient(DVec3::new(x.x, 0.0, x.y), 20, &mut values, &mut gradients);
        for m in 0..=20 {
            let steps: Vec<[f64; 2]> = (m + 1..=20).map(|n| recurrence(n, m)).collect();
            let found = harmonics(x, m, &steps);
            assert_eq!(found.len(), 21 - m);
            for ((value, gradient), n) in found.iter().zip(m..) {
                let i = index(n, m as isize);
                // Residual seen: 2e-16.
                assert!((value - values[i]).abs() < 1e-13);
                assert!((*gradient - DVec2::new(gradients[i].x, gradients[i].z)).length() < 1e-12);
            }
        }
    }
}
