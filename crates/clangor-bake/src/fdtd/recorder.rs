//! The pressure on a sphere about the centre of mass, and its multipoles.
//!
//! With [mirror planes](super::mirrors), the points on one side of them stand for their images.
//!
//! Gauss–Legendre in cos θ times the trapezoid rule in φ. Pressures come from the cell centres by Lagrange's
//! polynomials through six points along each axis, so that the interpolation error is below the error of the
//! grid.

use std::f64::consts::{PI, TAU};

use clangor_core::math::spherical_harmonics::{count, solid_harmonics};
use glam::DVec3;

use super::lattice::{GHOSTS, Lattice};
use super::mirrors::Mirrors;
use crate::quadrature::gauss_legendre;

/// Points of the interpolation along each axis.
pub(super) const TAPS: usize = 6;
/// Cells that the interpolation reaches beyond a point.
pub(super) const REACH: usize = TAPS / 2;
const _: () = assert!(REACH <= GHOSTS, "points next to a mirror plane reach no further than the images");

/// Distance from a mirror plane, over the radius, of points on it.
const ON_PLANE: f64 = 1e-9;

/// A point of the recording sphere.
#[derive(Clone, Debug)]
pub(super) struct Recorder {
    points: Vec<Point>,
    /// Weight times harmonics of each point.
    projection: Vec<f64>,
    count: usize,
}

#[derive(Clone, Debug)]
struct Point {
    /// Cell of the first tap.
    first: usize,
    weights: [[f32; TAPS]; 3],
}

/// Centre and radius of a recording sphere \[cells\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Sphere {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

impl Recorder {
    /// Reads a sphere for multipoles up to `order` about the axes of the body, of a field that has these
    /// signs under a reflection along each mirrored axis.
    pub(super) fn new(
        lattice: &Lattice,
        Sphere { centre, radius }: Sphere,
        order: usize,
        mirrors: &Mirrors,
        signs: [f64; 3],
    ) -> Self {
        let images: Vec<(DVec3, f64)> = mirrors
            .images()
            .into_iter()
            .map(|image| (image, (0..3).map(|a| if image[a] < 0.0 { signs[a] } else { 1.0 }).product()))
            .collect();
        // Enough points that degrees up to `order` + 11 do not alias.
        let rings = order + 6;
        let around = 2 * rings;
        let (mut points, mut projection, mut harmonics) = (Vec::new(), Vec::new(), Vec::new());
        for (u, weight) in gauss_legendre(rings) {
            for k in 0..around {
                let (z, phi) = (2.0 * u - 1.0, TAU * (k as f64 + 0.5) / around as f64);
                let flat = (1.0 - z * z).sqrt();
                let direction = DVec3::new(flat * phi.cos(), flat * phi.sin(), z);
                // Points beyond a plane are images, those on it are their own.
                let mirrored = (0..3).filter(|a| mirrors.planes[*a]).map(|a| direction[a]);
                if mirrored.clone().any(|x| x < -ON_PLANE) {
                    continue;
                }
                let own = 0.5_f64.powi(mirrored.filter(|x| *x < ON_PLANE).count() as i32);
                // In units of cells from the centre of cell 0.
                let at = (centre + radius * direction - 0.5).to_array();
                let first = at.map(|x| x.floor() as usize + 1 - REACH);
                points.push(Point {
                    first: lattice.index(first),
                    weights: std::array::from_fn(|a| lagrange(at[a] - first[a] as f64)),
                });
                // The harmonics of the point and of its images.
                let first = projection.len();
                projection.resize(first + count(order), 0.0);
                for (image, sign) in &images {
                    solid_harmonics(mirrors.frame * (*image * direction), order, &mut harmonics);
                    let weight = own * sign * 4.0 * PI * weight / around as f64;
                    projection[first..].iter_mut().zip(&harmonics).for_each(|(sum, y)| *sum += weight * y);
                }
            }
        }
        Recorder { points, projection, count: count(order) }
    }

    /// Appends the multipoles of a pressure field.
    pub(super) fn record(&self, lattice: &Lattice, p: &[f32], signals: &mut Vec<f64>) {
        let strides = lattice.strides();
        let pressures = self.points.iter().map(|point| {
            let mut value = 0.0;
            for (k, wz) in point.weights[2].iter().enumerate() {
                for (j, wy) in point.weights[1].iter().enumerate() {
                    let row = &p[point.first + k * strides[2] + j * strides[1]..][..TAPS];
                    let along: f32 = row.iter().zip(&point.weights[0]).map(|(p, w)| p * w).sum();
                    value += wz * wy * along;
                }
            }
            value
        });
        self.project(pressures, signals);
    }

    /// Number of points.
    #[cfg(feature = "gpu")]
    pub(super) fn points(&self) -> usize {
        self.points.len()
    }

    /// The points as 32-bit words: the cell of the first tap, then the weights along each axis.
    #[cfg(feature = "gpu")]
    pub(super) fn words(&self) -> Vec<u32> {
        let words = |p: &Point| {
            [p.first as u32]
                .into_iter()
                .chain(p.weights.into_iter().flatten().map(f32::to_bits))
                .collect::<Vec<_>>()
        };
        self.points.iter().flat_map(words).collect()
    }

    /// Appends the multipoles of pressures at the points.
    pub(super) fn project(&self, pressures: impl Iterator<Item = f32>, signals: &mut Vec<f64>) {
        let start = signals.len();
        signals.resize(start + self.count, 0.0);
        let sums = &mut signals[start..];
        for (value, projection) in pressures.zip(self.projection.chunks_exact(self.count)) {
            for (sum, y) in sums.iter_mut().zip(projection) {
                *sum += f64::from(value) * y;
            }
        }
    }
}

/// Weights of the points 0 … 5 at x.
fn lagrange(x: f64) -> [f32; TAPS] {
    std::array::from_fn(|i| {
        let other = (0..TAPS).filter(|j| *j != i);
        other.map(|j| (x - j as f64) / (i as f64 - j as f64)).product::<f64>() as f32
    })
}
