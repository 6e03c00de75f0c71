//! From the pressures of orders m = 0 and 1 on the meridian to multipoles about any axes.
//!
//! About the body's own axis a only harmonics of order 0 and 1 occur, so that the integral of
//! [`multipole_projection`](crate::multipole_projection) is over the meridian alone:
//!
//! ```text
//! c_n = θₙ(ikR)/R^{n+1} · (2π, π) ∫ [ p_m ∂/∂n (u_n(kr) rⁿ Y_nm) + a_m u_n(kr) rⁿ Y_nm ] r ds
//! ```
//!
//! In the axes of the body they spread over all orders. With e any direction across the axis and φ counted from it, the
//! addition theorem for Pₙ(a·x) and its derivative when a tilts towards e give
//!
//! ```text
//! Y_n0(about a) = √(4π/(2n+1)) Σ_m Y_nm(a) Y_nm(x)
//! Y_n1(about a, from e) = √(8π/((2n+1) n (n+1))) Σ_m [e·∇(rⁿY_nm)](a) Y_nm(x)
//! ```

use std::f64::consts::PI;

use clangor::model::acceleration_field::DEGREES;
use clangor::model::radial::{regular, reverse_bessel};
use clangor::model::spherical_harmonics::{count, index, solid_harmonics_with_gradient};
use glam::DVec3;
use num_complex::Complex64;

use super::panels::Panels;
use super::rows::{MOTIONS, motion};

/// Harmonics at a node, for m = 0 and 1.
struct NodeHarmonics {
    /// |x|², x·n dS, in units of R.
    square: f64,
    along: f64,
    /// For each n and m: n·∇(rⁿY) dS and rⁿY.
    terms: Vec<[[f64; 2]; 2]>,
    /// a_m dS of the motions, without the normal's share.
    motions: [f64; MOTIONS],
}

/// The projection from one set of panels.
pub(super) struct AxisProjection {
    nodes: Vec<NodeHarmonics>,
    radius: f64,
    order: usize,
}

impl AxisProjection {
    /// For coefficients on the sphere of `radius` \[m\] up to an order.
    pub(super) fn new(panels: &Panels, radius: f64, order: usize) -> Self {
        let (mut values, mut gradients) = (Vec::new(), Vec::new());
        let nodes = panels
            .nodes
            .iter()
            .map(|node| {
                let p = node.position / radius;
                // The polar axis is z here; φ = 0.
                let x = DVec3::new(p.x, 0.0, p.y);
                let area = node.weight * node.position.x;
                let normal = DVec3::new(node.normal.x, 0.0, node.normal.y) * area;
                solid_harmonics_with_gradient(x, order, &mut values, &mut gradients);
                let terms = (0..=order)
                    .map(|n| {
                        [0, 1].map(|m| {
                            if m > n {
                                return [0.0; 2];
                            }
                            let i = index(n, m as isize);
                            let turn = if m == 0 { 2.0 * PI } else { PI };
                            [turn * gradients[i].dot(normal), turn * values[i]]
                        })
                    })
                    .collect();
                let motions =
                    motion(node.position.x, node.position.y, node.normal.x, node.normal.y).map(|a| a * area);
                NodeHarmonics { square: x.length_squared(), along: x.dot(normal), terms, motions }
            })
            .collect();
        AxisProjection { nodes, radius, order }
    }

    /// c_n of the three motions from their pressures at the nodes.
    pub(super) fn coefficients(
        &self,
        pressure: &[Vec<Complex64>; MOTIONS],
        wavenumber: Complex64,
    ) -> [Vec<Complex64>; MOTIONS] {
        let mut sums: [Vec<Complex64>; MOTIONS] =
            std::array::from_fn(|_| vec![Complex64::ZERO; self.order + 1]);
        let square = wavenumber * wavenumber * (self.radius * self.radius);
        let mut radial = Vec::new();
        for (k, node) in self.nodes.iter().enumerate() {
            regular(square * node.square, self.order + 1, &mut radial);
            for (i, sum) in sums.iter_mut().enumerate() {
                let m = usize::from(i > 0);
                let p = pressure[i][k] / self.radius;
                for n in m..=self.order {
                    let [normal, value] = node.terms[n][m];
                    // u'_n(z) = −z u_{n+1}(z).
                    let slope = radial[n] * normal - square * radial[n + 1] * (node.along * value);
                    sum[n] += p * slope + radial[n] * (value * node.motions[i]);
                }
            }
        }
        let mut scale = Vec::new();
        reverse_bessel(Complex64::I * wavenumber * self.radius, self.order, &mut scale);
        for sum in &mut sums {
            sum.iter_mut().zip(&scale).for_each(|(c, s)| *c *= s / self.radius);
        }
        sums
    }
}

/// Turns coefficients about the axis into those of the six motions in the body's own axes.
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

    /// The six coefficients, and the share of each motion along and across the axis.
    pub(super) fn coefficients(&self, about_axis: &[Vec<Complex64>; MOTIONS]) -> [Vec<Complex64>; DEGREES] {
        let order = about_axis[0].len() - 1;
        std::array::from_fn(|degree| {
            let (along, across) = decompose(self.axis, degree);
            let turned = &about_axis[if degree < 3 { 1 } else { 2 }];
            let mut out = Vec::with_capacity(count(order));
            for n in 0..=order {
                for i in n * n..(n + 1) * (n + 1) {
                    out.push(
                        about_axis[0][n] * (along * self.zonal[i]) + turned[n] * across.dot(self.tilted[i]),
                    );
                }
            }
            out
        })
    }
}

/// A unit motion as a part along the axis and a direction e across it from which cos φ is counted.
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
