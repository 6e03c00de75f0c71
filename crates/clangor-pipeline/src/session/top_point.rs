//! Where a body is struck if nobody says where: on the face that is highest above the centre of mass, off its
//! middle, where many modes of a symmetric body have a node.
//!
//! The point does not depend on the order of the triangles: of equal ones the point farthest along x, then z.

use clangor_core::body::{Body, Surface};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DVec2, DVec3};

/// From the middle of the face to its farthest corner.
const OFF_THE_MIDDLE: f64 = 2.0 / 3.0;
/// Differences of length that count as none, over the bounding radius.
const SAME: f64 = 1e-6;

/// The point, from the centre of mass \[m\].
pub(super) fn top_point(body: &Body) -> DVec3 {
    match &*body.surface {
        Surface::Mesh(surface) => top_of_mesh(&surface.mesh),
        surface => DVec3::Y * surface.bounding_radius(),
    }
}

fn top_of_mesh(mesh: &TriMesh) -> DVec3 {
    let same = SAME * mesh.bounding_radius(DVec3::ZERO);
    let top = mesh.vertices.iter().map(|vertex| vertex.y).fold(f64::NEG_INFINITY, f64::max);
    let is_top = |vertex: &DVec3| vertex.y > top - same;
    let faces: Vec<usize> =
        (0..mesh.triangles.len()).filter(|t| mesh.corners(*t).iter().all(is_top)).collect();
    let area: f64 = faces.iter().map(|t| mesh.area_vector(*t).length()).sum();
    if area <= same * same {
        return foremost(mesh.vertices.iter().copied().filter(is_top), same).unwrap_or(DVec3::ZERO);
    }
    let middle =
        faces.iter().map(|t| mesh.area_vector(*t).length() * mesh.centroid(*t)).sum::<DVec3>() / area;
    // The farthest corner, and a point on the way to it.
    let corners = || faces.iter().flat_map(|t| mesh.corners(*t));
    let farthest = corners().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
    let corner = foremost(corners().filter(|corner| corner.distance(middle) > farthest - same), same);
    let point = middle.lerp(corner.unwrap_or(middle), OFF_THE_MIDDLE);
    if faces.iter().any(|t| is_within(mesh.corners(*t), point)) {
        return point;
    }
    // A ring or a horseshoe: the middle of the triangle nearest to the point.
    let nearest = faces.iter().map(|t| mesh.centroid(*t).distance(point)).fold(f64::INFINITY, f64::min);
    let near = faces.iter().map(|t| mesh.centroid(*t)).filter(|c| c.distance(point) < nearest + same);
    foremost(near, same).unwrap_or(point)
}

/// The point farthest along x, and of those that share it along z.
fn foremost(points: impl Iterator<Item = DVec3> + Clone, same: f64) -> Option<DVec3> {
    let x = points.clone().map(|point| point.x).fold(f64::NEG_INFINITY, f64::max);
    points.filter(|point| point.x > x - same).max_by(|a, b| a.z.total_cmp(&b.z))
}

/// Whether a point lies in a triangle, seen from above.
fn is_within(corners: [DVec3; 3], point: DVec3) -> bool {
    let side = |k: usize| {
        let (from, to) = (flat(corners[k]), flat(corners[(k + 1) % 3]));
        (to - from).perp_dot(flat(point) - from)
    };
    let sides = [0, 1, 2].map(side);
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

fn flat(vector: DVec3) -> DVec2 {
    DVec2::new(vector.x, vector.z)
}

#[cfg(test)]
mod tests {
    use clangor_core::glam::Vec3Swizzles;
    use clangor_core::shape::Shape;

    use super::*;

    #[test]
    fn the_point_is_on_the_highest_face_whatever_the_order_of_the_triangles() {
        let mesh = Shape::parse("box:0.3x0.008x0.03").unwrap().mesh();
        let point = top_of_mesh(&mesh);
        assert!(point.distance(DVec3::new(0.1, 0.004, 0.01)) < 1e-12, "{point}");
        let mut turned = mesh.clone();
        turned.triangles.reverse();
        turned.triangles.iter_mut().for_each(|triangle| triangle.rotate_left(1));
        assert!(top_of_mesh(&turned).distance(point) < 1e-12);
    }

    #[test]
    fn the_point_of_a_ring_lies_on_it() {
        // A square ring, flat on top.
        let corner = |size: f64, k: usize, y: f64| {
            let (x, z) = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)][k % 4];
            DVec3::new(size * x, y, size * z)
        };
        let mut mesh = TriMesh::default();
        for k in 0..4 {
            let first = mesh.vertices.len() as u32;
            let quad =
                [corner(1.0, k, 0.1), corner(1.0, k + 1, 0.1), corner(0.8, k + 1, 0.1), corner(0.8, k, 0.1)];
            mesh.vertices.extend(quad);
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        let point = top_of_mesh(&mesh);
        assert!(point.y == 0.1 && point.xz().abs().max_element() > 0.8, "{point}");
    }
}
