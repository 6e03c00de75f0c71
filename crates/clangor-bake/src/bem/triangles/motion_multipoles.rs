//! Outgoing multipoles of the six rigid motions, from their pressures on the surface.
//!
//! ```text
//! cₙₘ = θₙ(ik) ∮ [ p ∂u/∂n + a_n u ] dS,      u = uₙ(k²r²) rⁿYₙₘ
//! ∂u/∂n = uₙ ∂(rⁿYₙₘ)/∂n − k² uₙ₊₁ (x·n) rⁿYₙₘ
//! ```
//!
//! (`fitting::multipole_projection`). The harmonics and their slopes do not depend on k: those of one order
//! at the points of some triangles are two matrices, and the integrals of all motions two products of them
//! with
//!
//! ```text
//! w p uₙ    and    w (a_n uₙ − p k² (x·n) uₙ₊₁)
//! ```
//!
//! at these points, w their quadrature weights. Lengths in the bounding radius.

use clangor_core::math::radial::{regular, reverse_bessel};
use clangor_core::math::spherical_harmonics::count;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex64;

use super::TriangleSolver;
use super::incident_waves::{POINTS, SurfaceHarmonics};
use super::pair_rules::six_points;

/// Triangles whose points share a product: their harmonics to order 30 take 3 MB.
const BLOCK: usize = 32;
/// Real and imaginary parts of the motions.
const PARTS: usize = 2 * RIGID_DOFS;

/// A point of the quadrature.
struct Point {
    /// k² (x·n).
    along: f64,
    /// w p, real and imaginary parts.
    pressures: [f64; PARTS],
    /// w a_n.
    motions: [f64; PARTS],
}

impl TriangleSolver {
    /// Outgoing multipoles of the six motions up to `order` on the sphere of the bounding radius, in units of
    /// it, from their pressures at the vertices of the cell, along and about the axes of the cell. `known`
    /// are harmonics of at least this order.
    ///
    /// By symmetry the integral is that over the cell times the number of images, or zero.
    pub(super) fn multipoles_of_cell(
        &self,
        wavenumber: f64,
        order: usize,
        pressures: &[[Complex64; RIGID_DOFS]],
        known: Option<&SurfaceHarmonics>,
    ) -> [Vec<Complex64>; RIGID_DOFS] {
        let kappa = wavenumber * self.radius;
        let known = known.filter(|known| known.order >= order);
        let stored = count(known.map_or(order, |known| known.order));
        let share = 2 * POINTS * stored;
        // Real and imaginary parts of the integrals over the cell, for each harmonic and motion.
        let mut integrals = vec![0.0; PARTS * count(order)];
        let mut own = vec![0.0; if known.is_some() { 0 } else { BLOCK * share }];
        let (mut functions, mut radial, mut points) = (Vec::new(), Vec::new(), Vec::new());
        let triangles = self.panels.triangles.len();
        for first in (0..triangles).step_by(BLOCK) {
            let block = first..(first + BLOCK).min(triangles);
            // Harmonics at the points of the block.
            let harmonics = match known {
                Some(known) => &known.values[block.start * share..block.end * share],
                None => {
                    let places = block.clone().zip(own.chunks_exact_mut(share));
                    places.for_each(|(t, values)| self.harmonics_on(t, 1.0, order, values));
                    &own[..block.len() * share]
                }
            };
            // Pressures, motions and radial functions there.
            radial.clear();
            points.clear();
            for t in block {
                self.add_points(t, kappa * kappa, pressures, &mut points);
                for (shares, _) in six_points() {
                    let x = self.panels.point(t, shares);
                    regular((kappa * kappa * x.length_squared()).into(), order + 1, &mut functions);
                    radial.extend(functions.iter().map(|f| f.re));
                }
            }
            // Products order by order.
            for n in 0..=order {
                add_order(n, (harmonics, stored), (&points, &radial, order + 2), &mut integrals);
            }
        }
        // Frequency-dependent factors of the orders, and the parities that occur.
        let mut theta = Vec::new();
        reverse_bessel(Complex64::new(0.0, kappa), order, &mut theta);
        let images = self.images.len() as f64;
        let mut coefficients = std::array::from_fn(|_| vec![Complex64::ZERO; count(order)]);
        for class in &self.classes {
            for i in self.members(class, order) {
                for d in &class.motions {
                    let at = PARTS * i + 2 * d;
                    let integral = Complex64::new(integrals[at], integrals[at + 1]);
                    coefficients[*d][i] = theta[i.isqrt()] * integral * images;
                }
            }
        }
        coefficients
    }

    /// Appends the quadrature points of a triangle.
    fn add_points(
        &self,
        triangle: usize,
        square: f64,
        pressures: &[[Complex64; RIGID_DOFS]],
        points: &mut Vec<Point>,
    ) {
        let (area, normal) = (self.panels.areas[triangle], self.panels.normals[triangle]);
        let motions = self.panels.motions(triangle);
        let at_corners = self.panels.triangles[triangle].map(|v| &pressures[v as usize]);
        points.extend(six_points().into_iter().map(|(shares, weight)| {
            let weight = area * weight;
            let between = |value: &dyn Fn(usize) -> f64| -> f64 {
                shares.iter().enumerate().map(|(corner, share)| weight * share * value(corner)).sum()
            };
            let pressure = |q: usize, corner: usize| {
                let p = at_corners[corner][q / 2];
                if q.is_multiple_of(2) { p.re } else { p.im }
            };
            let motion =
                |q: usize, corner: usize| if q.is_multiple_of(2) { motions[corner][q / 2] } else { 0.0 };
            Point {
                along: square * self.panels.point(triangle, shares).dot(normal),
                pressures: std::array::from_fn(|q| between(&|corner| pressure(q, corner))),
                motions: std::array::from_fn(|q| between(&|corner| motion(q, corner))),
            }
        }));
    }
}

/// Adds the integrals of one order over some points: their harmonics and slopes, `stored` of each, and
/// `functions` radial functions of each point.
fn add_order(
    n: usize,
    (harmonics, stored): (&[f64], usize),
    (points, radial, functions): (&[Point], &[f64], usize),
    integrals: &mut [f64],
) {
    let (mut of_slopes, mut of_values) = (Vec::new(), Vec::new());
    for (point, radial) in points.iter().zip(radial.chunks_exact(functions)) {
        let (here, above) = (radial[n], point.along * radial[n + 1]);
        of_slopes.extend(point.pressures.map(|p| here * p));
        let parts = point.motions.iter().zip(&point.pressures);
        of_values.extend(parts.map(|(a, p)| here * a - above * p));
    }
    // Row by row: harmonics of this order at each point.
    let (low, width) = (n * n, 2 * n + 1);
    let of_order = |first: usize| {
        MatRef::from_row_major_slice_with_stride(&harmonics[first..], points.len(), width, 2 * stored)
    };
    let mut sums =
        MatMut::from_column_major_slice_mut(&mut integrals[PARTS * low..PARTS * (low + width)], PARTS, width);
    for (weights, first) in [(&of_slopes, stored + low), (&of_values, low)] {
        let weights = MatRef::from_column_major_slice(weights, PARTS, points.len());
        matmul(sums.as_mut(), Accum::Add, weights, of_order(first), 1.0, Par::Seq);
    }
}
