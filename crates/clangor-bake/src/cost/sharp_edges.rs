//! Length of the sharp edges of a body, along which the triangles of boundary elements are short.

use std::collections::HashMap;

use clangor_core::geometry::tri_mesh::TriMesh;

use crate::geometry_class::bake_geometry::BakeGeometry;

/// Cosine of the angle between the normals of two faces up to which their edge is sharp: 30°.
const SHARP: f64 = 0.866;
/// Length of the edges over the root of the area from which they are the noise of a scan. A box has 8 or
/// more, a gear of 20 teeth about 40, noise 100 and more.
const NOISE: f64 = 60.0;

/// Length of the edges that are sharper than a radius of `blunt` \[m\]; 0 where they are noise.
pub(super) fn sharp_length(geometry: &BakeGeometry, blunt: f64) -> f64 {
    match geometry {
        BakeGeometry::RoundedBox { edges, round } if *round < blunt => 4.0 * edges.element_sum(),
        BakeGeometry::Mesh(mesh) => of_mesh(mesh),
        _ => 0.0,
    }
}

fn of_mesh(mesh: &TriMesh) -> f64 {
    let mut sides: HashMap<[u32; 2], usize> = HashMap::with_capacity(2 * mesh.triangles.len());
    let mut length = 0.0;
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            let Some(other) = sides.insert([a.min(b), a.max(b)], face) else { continue };
            let normals = [face, other].map(|face| mesh.area_vector(face).normalize_or_zero());
            if normals[0].dot(normals[1]) < SHARP {
                length += mesh.vertices[a as usize].distance(mesh.vertices[b as usize]);
            }
        }
    }
    if length > NOISE * mesh.area().sqrt() { 0.0 } else { length }
}

#[cfg(test)]
mod tests {
    use clangor_core::shape::Shape;
    use glam::DVec3;

    use super::*;

    #[test]
    fn boxes_have_twelve_edges_and_balls_none() {
        let edges = DVec3::new(0.2, 0.03, 0.01);
        let whole = 4.0 * edges.element_sum();
        let length = |geometry: BakeGeometry| sharp_length(&geometry, 1e-3);
        assert_eq!(length(BakeGeometry::RoundedBox { edges, round: 0.0 }), whole);
        assert_eq!(length(BakeGeometry::RoundedBox { edges, round: 2e-3 }), 0.0);
        let mesh = |shape: &str| BakeGeometry::Mesh(Shape::parse(shape).unwrap().mesh());
        // Residual seen: 1e-15.
        assert!((length(mesh("box:0.2x0.03x0.01")) / whole - 1.0).abs() < 1e-12);
        assert_eq!(length(mesh("sphere:0.1")), 0.0);
    }
}
