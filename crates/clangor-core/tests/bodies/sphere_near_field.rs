//! The pressure on a sphere, made from the exact solution.

use std::f64::consts::PI;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::sound_model::acceleration::field::AccelerationField;
use clangor_core::sound_model::acceleration::near_field::NearField;
use num_complex::Complex32;

use super::sphere_field::{centre_motions, sphere_pressure};

/// Exact pressure of the unit sphere about the centre of mass on a mesh of its surface: the faces of an
/// octahedron, each edge in `parts`, with the volume of the sphere.
pub(crate) fn sphere_near_field(field: &AccelerationField, parts: u32) -> NearField {
    let mut surface = TriMesh::default();
    for octant in 0..8 {
        let sign = |bit: u32| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let signs = DVec3::new(sign(0), sign(1), sign(2));
        let mirrored = signs.element_product() < 0.0;
        let vertex =
            |i: u32, j: u32| signs * DVec3::new(f64::from(i), f64::from(j), f64::from(parts - i - j));
        let mut face = |corners: [(u32, u32); 3]| {
            let first = surface.vertices.len() as u32;
            surface.vertices.extend(corners.map(|(i, j)| vertex(i, j).normalize()));
            surface.triangles.push(if mirrored {
                [first, first + 2, first + 1]
            } else {
                [first, first + 1, first + 2]
            });
        };
        for i in 0..parts {
            for j in 0..parts - i {
                face([(i, j), (i + 1, j), (i, j + 1)]);
                if i + j + 1 < parts {
                    face([(i + 1, j), (i + 1, j + 1), (i, j + 1)]);
                }
            }
        }
    }
    surface = surface.weld(1e-9);
    let volume: f64 =
        (0..surface.triangles.len()).map(|t| surface.area_vector(t).dot(surface.centroid(t)) / 3.0).sum();
    assert!(volume > 4.0, "{volume}");
    let scale = (4.0 / 3.0 * PI / volume).cbrt();
    let mut pressures = Vec::new();
    for vertex in &mut surface.vertices {
        for motion in centre_motions(DVec3::ZERO) {
            for node in &field.nodes {
                let p = sphere_pressure(node.s, 1.0, DVec3::ZERO, motion, *vertex);
                pressures.push(Complex32::new(p.re as f32, p.im as f32));
            }
        }
        *vertex *= scale;
    }
    NearField::from_pressures(surface, field.nodes.len(), &pressures)
}
