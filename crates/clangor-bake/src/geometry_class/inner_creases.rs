//! Sharp inner edges: where two walls meet, as at the bottom of a box.
//!
//! An edge is an inner one if each of its triangles lies in front of the other's plane. Fillets of many small
//! turns do not count.

use std::collections::HashMap;

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

/// Cosine of the least turn of a sharp edge: 30°.
const SHARP: f64 = 0.866;

/// Length of all sharp inner edges \[m\].
pub(crate) fn inner_creases(mesh: &TriMesh) -> f64 {
    let mut sides: HashMap<[u32; 2], usize> = HashMap::with_capacity(3 * mesh.triangles.len());
    for (t, corners) in mesh.triangles.iter().enumerate() {
        (0..3).for_each(|k| {
            sides.insert([corners[k], corners[(k + 1) % 3]], t);
        });
    }
    let normal = |t: usize| mesh.area_vector(t).normalize_or(DVec3::ZERO);
    let mut length = 0.0;
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            let Some(other) = sides.get(&[b, a]).filter(|_| a < b) else { continue };
            let inner = (mesh.centroid(*other) - mesh.centroid(t)).dot(normal(t)) > 0.0;
            if inner && normal(t).dot(normal(*other)) < SHARP {
                length += mesh.vertices[a as usize].distance(mesh.vertices[b as usize]);
            }
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use clangor_core::shape::Shape;

    #[test]
    fn convex_and_smooth_bodies_have_none() {
        for shape in ["box:0.1x0.2x0.05", "torus:0.03x0.01@0.001", "sphere:0.1@0.01"] {
            assert_eq!(inner_creases(&Shape::parse(shape).expect("a shape").mesh()), 0.0, "{shape}");
        }
    }

    #[test]
    fn a_notched_block_has_one() {
        // An L of unit depth: six corners, of which the fourth is an inner one.
        let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let level = |z: f64| outline.map(|[x, y]| DVec3::new(x, y, z));
        let mut mesh = TriMesh { vertices: [level(0.0), level(1.0)].concat(), triangles: Vec::new() };
        for [a, b, c] in [[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]] {
            mesh.triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
        }
        for k in 0..6 {
            let n = (k + 1) % 6;
            mesh.triangles.extend([[k, n, n + 6], [k, n + 6, k + 6]]);
        }
        assert!((inner_creases(&mesh) - 1.0).abs() < 1e-15);
    }
}
