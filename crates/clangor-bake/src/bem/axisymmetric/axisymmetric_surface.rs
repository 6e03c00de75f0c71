//! The surface as a triangle mesh, and the pressures of the six motions at its vertices.

use std::f64::consts::TAU;

use clangor_core::geometry::meridian::Meridian;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::geometry::turning::{Ring, lace};
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::{DQuat, DVec3};
use num_complex::Complex64;

use super::multipoles::{MOTIONS, decompose};
use super::panels::Panels;

/// Largest angle \[rad\] between neighbouring triangles on a curved surface.
const BEND: f64 = 0.35;

/// A meridian rotated about an axis.
#[derive(Debug)]
pub(super) struct AxisymmetricSurface {
    pub(super) mesh: TriMesh,
    /// Piece of the meridian and parameter of each ring.
    places: Vec<(usize, f64)>,
    /// Ring of each vertex.
    ring: Vec<usize>,
}

impl AxisymmetricSurface {
    /// A mesh with edges of at most about `edge` \[m\].
    pub(super) fn new(meridian: &Meridian, axis: DVec3, edge: f64) -> Self {
        // Points along the meridian, closer where it curves.
        let mut places = Vec::new();
        for (i, piece) in meridian.pieces().iter().enumerate() {
            let length = piece.length(0.0, 1.0);
            let sharpest =
                (0..=8).map(|k| piece.curvature_radius(f64::from(k) / 8.0)).fold(f64::INFINITY, f64::min);
            let count = (length / edge.min(BEND * sharpest)).ceil().clamp(1.0, 4000.0) as usize;
            places.extend((0..count).map(|k| (i, k as f64 / count as f64)));
        }
        let closed = meridian.is_loop();
        if !closed {
            places.push((meridian.pieces().len() - 1, 1.0));
        }
        let axis_radius = 1e-9 * meridian.bounding_radius();
        // Points around the axis on each ring.
        let rings: Vec<Ring> = places
            .iter()
            .map(|(i, t)| {
                let p = meridian.pieces()[*i].point(*t);
                if p.x <= axis_radius {
                    return Ring { radius: 0.0, y: p.y, turns: vec![0.0] };
                }
                let count = 4 * (0.25 * (TAU * p.x / edge).max(TAU / BEND)).ceil() as usize;
                Ring { radius: p.x, y: p.y, turns: (0..count).map(|k| k as f64 / count as f64).collect() }
            })
            .collect();
        // Triangulate between neighbouring rings, and rotate onto the axis.
        let mut mesh = lace(&rings, closed);
        let turn = DQuat::from_rotation_arc(DVec3::Y, axis);
        mesh.vertices.iter_mut().for_each(|v| *v = turn * *v);
        let ring = rings.iter().enumerate().flat_map(|(k, ring)| ring.turns.iter().map(move |_| k)).collect();
        AxisymmetricSurface { mesh, places, ring }
    }

    /// Pressures at the vertices from those at the nodes of the panels.
    pub(super) fn pressures(
        &self,
        panels: &Panels,
        axis: DVec3,
        pressure: &[Vec<Complex64>; MOTIONS],
    ) -> Vec<[Complex64; RIGID_DOFS]> {
        let count = panels.rule.len();
        let mut cardinal = vec![0.0; count];
        // Interpolate the pressures from the panel nodes to the rings.
        let on_rings: Vec<[Complex64; MOTIONS]> = self
            .places
            .iter()
            .map(|(piece, t)| {
                let (panel, x) = panels.locate(*piece, *t);
                panels.cardinal(x, &mut cardinal);
                std::array::from_fn(|i| {
                    let nodes = &pressure[i][panel * count..(panel + 1) * count];
                    nodes.iter().zip(&cardinal).map(|(p, c)| p * c).sum()
                })
            })
            .collect();
        // Resolve each motion along and across the axis, then apply its angular factor.
        let parts: [(f64, DVec3); RIGID_DOFS] = std::array::from_fn(|degree| decompose(axis, degree));
        self.mesh
            .vertices
            .iter()
            .zip(&self.ring)
            .map(|(v, ring)| {
                let [along, across, turning] = on_rings[*ring];
                let outward = (*v - axis * v.dot(axis)).normalize_or_zero();
                std::array::from_fn(|degree| {
                    let (part, direction) = parts[degree];
                    let wave = if degree < 3 { across } else { turning };
                    along * part + wave * direction.dot(outward)
                })
            })
            .collect()
    }
}
