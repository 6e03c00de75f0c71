//! The field of a solved surface at any point of the fluid, by the boundary integral.
//!
//! p(x) = ∫ (p ∂G/∂n + ρ a_n G) dS over flat triangles with linear pressure, ρ = 1. Triangles near the point
//! are divided into four until their pieces are smaller than their distance, so that the field is accurate
//! down to a small fraction of an edge above the surface.

use std::f64::consts::PI;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;

use super::pair_rules::{Piece, Shares, centre, inside, quarters, six_points};
use crate::radiation::rigid_motions;

/// Distance, in radii of the piece, above which a piece is not divided further.
const CLEARANCE: f64 = 3.0;

/// Most halvings of a triangle.
const DEEPEST: u32 = 10;

/// Pressures of the six motions at points outside a surface, from those at its vertices; wavenumber [1/m].
pub fn field(
    mesh: &TriMesh,
    surface_pressure: &[[Complex64; RIGID_DOFS]],
    wavenumber: Complex64,
    points: &[DVec3],
) -> Vec<[Complex64; RIGID_DOFS]> {
    let rule = six_points();
    let mut fields = vec![[Complex64::ZERO; RIGID_DOFS]; points.len()];
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let at = |s: Shares| corners[0] * s[0] + corners[1] * s[1] + corners[2] * s[2];
        let area = mesh.area_vector(t);
        let normal = area.normalize_or_zero();
        let pressure = mesh.triangles[t].map(|v| surface_pressure[v as usize]);
        let centroid = at([1.0 / 3.0; 3]);
        let radius = corners.iter().map(|c| c.distance(centroid)).fold(0.0, f64::max);
        for (x, field) in points.iter().zip(&mut fields) {
            // Subdivide until the piece is small relative to its distance.
            let whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let mut pending: Vec<(Piece, u32)> = vec![(whole, 0)];
            while let Some((piece, depth)) = pending.pop() {
                let size = 0.5_f64.powi(depth as i32);
                if x.distance(at(centre(&piece))) < CLEARANCE * radius * size && depth < DEEPEST {
                    pending.extend(quarters(&piece).map(|quarter| (quarter, depth + 1)));
                    continue;
                }
                // Six-point quadrature of the single and double layer.
                for (shares, weight) in &rule {
                    let shares = inside(&piece, *shares);
                    let y = at(shares);
                    let d = *x - y;
                    let r = d.length().max(f64::MIN_POSITIVE);
                    let weight = weight * size * size * area.length();
                    let value = (-Complex64::I * wavenumber * r).exp() * (weight / (4.0 * PI * r));
                    let slope = (Complex64::I * wavenumber + 1.0 / r) * value * (d.dot(normal) / r);
                    let motions = rigid_motions(y, normal);
                    for (degree, field) in field.iter_mut().enumerate() {
                        let p: Complex64 = (0..3).map(|c| pressure[c][degree] * shares[c]).sum();
                        *field += slope * p + value * motions[degree];
                    }
                }
            }
        }
    }
    fields
}
