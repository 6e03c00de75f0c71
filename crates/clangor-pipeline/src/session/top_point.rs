//! Where a body is struck if nobody says where: on the face that is highest above the centre of mass, off its
//! middle, where many modes of a symmetric body have a node, straight down.
//!
//! The highest place of a dome, a bell or an egg on its end is a pole above the centre of mass, where only
//! modes of azimuthal order 0 move, and not those that are typical: the fields of bending of a bell grow from
//! its crown to its rim. Such a body is struck near its edge as seen from above, at a right angle to its
//! surface.
//!
//! The point does not depend on the order of the triangles: of equal ones the point farthest along x, then z.

use clangor_core::body::{Body, Surface};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DVec2, DVec3};

/// From the middle of the face to its farthest corner.
const OFF_THE_MIDDLE: f64 = 2.0 / 3.0;
/// From a pole to the edge of the body as seen from above.
const OFF_THE_POLE: f64 = 0.9;
/// Largest distance of a pole from the vertical through the centre of mass, over that of the edge.
const POLE: f64 = 0.1;
/// Differences of length that count as none, over the bounding radius.
const SAME: f64 = 1e-6;

/// A place of the surface and the direction of an impact there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TopPoint {
    /// From the centre of mass \[m\].
    pub(super) point: DVec3,
    /// Unit vector into the body.
    pub(super) inwards: DVec3,
}

impl TopPoint {
    fn from_above(point: DVec3) -> Self {
        TopPoint { point, inwards: DVec3::NEG_Y }
    }
}

/// Where a body is struck by default.
pub(super) fn top_point(body: &Body) -> TopPoint {
    match &*body.surface {
        Surface::Mesh(surface) => top_of_mesh(&surface.mesh),
        surface => TopPoint::from_above(DVec3::Y * surface.bounding_radius()),
    }
}

fn top_of_mesh(mesh: &TriMesh) -> TopPoint {
    let same = SAME * mesh.bounding_radius(DVec3::ZERO);
    let top = mesh.vertices.iter().map(|vertex| vertex.y).fold(f64::NEG_INFINITY, f64::max);
    let is_top = |vertex: &DVec3| vertex.y > top - same;
    let tops = || mesh.vertices.iter().copied().filter(is_top);
    let width = mesh.vertices.iter().map(|vertex| flat(*vertex).length()).fold(0.0, f64::max);
    let is_pole = tops().all(|vertex| flat(vertex).length() < POLE * width);
    if let Some(place) = is_pole.then(|| off_the_pole(mesh, width, same)).flatten() {
        return place;
    }
    let faces: Vec<usize> =
        (0..mesh.triangles.len()).filter(|t| mesh.corners(*t).iter().all(is_top)).collect();
    let point = match faces.iter().map(|t| mesh.area_vector(*t).length()).sum::<f64>() {
        area if area > same * same => on_face(mesh, &faces, area, same),
        _ => foremost(tops(), same).unwrap_or(DVec3::ZERO),
    };
    TopPoint::from_above(point)
}

/// Near the edge of a body that is so wide: the middle of the highest triangle there.
fn off_the_pole(mesh: &TriMesh, width: f64, same: f64) -> Option<TopPoint> {
    let edge = mesh.vertices.iter().copied().filter(|vertex| flat(*vertex).length() > width - same);
    let target = OFF_THE_POLE * foremost(edge, same)?;
    let over: Vec<(usize, f64)> = (0..mesh.triangles.len())
        .filter(|t| mesh.area_vector(*t).y > same * same && is_within(mesh.corners(*t), target, same))
        .map(|t| (t, height(mesh, t, target)))
        .collect();
    let top = over.iter().map(|(_, height)| *height).fold(f64::NEG_INFINITY, f64::max);
    let highest = || over.iter().filter(|(_, height)| *height > top - same).map(|(t, _)| *t);
    let point = foremost(highest().map(|t| mesh.centroid(t)), same)?;
    let triangle = highest().find(|t| mesh.centroid(*t) == point)?;
    Some(TopPoint { point, inwards: -mesh.area_vector(triangle).normalize() })
}

/// Height of the plane of a triangle at a place seen from above \[m\].
fn height(mesh: &TriMesh, triangle: usize, place: DVec3) -> f64 {
    let (corner, normal) = (mesh.corners(triangle)[0], mesh.area_vector(triangle));
    corner.y - flat(place - corner).dot(flat(normal)) / normal.y
}

/// Off the middle of the highest face.
fn on_face(mesh: &TriMesh, faces: &[usize], area: f64, same: f64) -> DVec3 {
    let middle =
        faces.iter().map(|t| mesh.area_vector(*t).length() * mesh.centroid(*t)).sum::<DVec3>() / area;
    // The farthest corner, and a point on the way to it.
    let corners = || faces.iter().flat_map(|t| mesh.corners(*t));
    let farthest = corners().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
    let corner = foremost(corners().filter(|corner| corner.distance(middle) > farthest - same), same);
    let point = middle.lerp(corner.unwrap_or(middle), OFF_THE_MIDDLE);
    if faces.iter().any(|t| is_within(mesh.corners(*t), point, 0.0)) {
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

/// Whether a point lies in a triangle, or so near to it \[m\], seen from above.
fn is_within(corners: [DVec3; 3], point: DVec3, near: f64) -> bool {
    let side = |k: usize| {
        let (from, to) = (flat(corners[k]), flat(corners[(k + 1) % 3]));
        ((to - from).perp_dot(flat(point) - from), near * from.distance(to))
    };
    let sides = [0, 1, 2].map(side);
    sides.iter().all(|(side, near)| *side >= -near) || sides.iter().all(|(side, near)| side <= near)
}

fn flat(vector: DVec3) -> DVec2 {
    DVec2::new(vector.x, vector.z)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use clangor_core::glam::Vec3Swizzles;
    use clangor_core::shape::Shape;

    use super::*;

    #[test]
    fn the_point_is_on_the_highest_face_whatever_the_order_of_the_triangles() {
        let mesh = Shape::parse("box:0.3x0.008x0.03").unwrap().mesh();
        let TopPoint { point, inwards } = top_of_mesh(&mesh);
        assert!(point.distance(DVec3::new(0.1, 0.004, 0.01)) < 1e-12, "{point}");
        assert_eq!(inwards, DVec3::NEG_Y);
        let mut turned = mesh.clone();
        turned.triangles.reverse();
        turned.triangles.iter_mut().for_each(|triangle| triangle.rotate_left(1));
        assert!(top_of_mesh(&turned).point.distance(point) < 1e-12);
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
        let point = top_of_mesh(&mesh).point;
        assert!(point.y == 0.1 && point.xz().abs().max_element() > 0.8, "{point}");
    }

    /// A shell between two caps of spheres of radii 1 and 0.9, open below.
    fn dome(rings: usize, around: usize) -> TriMesh {
        let mut mesh = TriMesh::default();
        for (radius, ring) in [1.0, 0.9].into_iter().flat_map(|r| (0..=rings).map(move |ring| (r, ring))) {
            let (sin, cos) = (FRAC_PI_2 * ring as f64 / rings as f64).sin_cos();
            mesh.vertices.extend((0..around).map(|k| {
                let (z, x) = (TAU * k as f64 / around as f64).sin_cos();
                radius * DVec3::new(sin * x, cos, sin * z)
            }));
        }
        let at = |ring: usize, k: usize| (ring * around + k % around) as u32;
        for k in 0..around {
            for ring in 0..rings {
                let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
                let inner = [a, b, c, d].map(|v| v + at(rings + 1, 0));
                mesh.triangles.extend([[inner[0], inner[2], inner[1]], [inner[0], inner[3], inner[2]]]);
            }
            let [a, b] = [at(rings, k), at(rings, k + 1)];
            let [c, d] = [a, b].map(|v| v + at(rings + 1, 0));
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
        mesh.weld(1e-9)
    }

    #[test]
    fn a_dome_is_struck_near_its_rim_at_a_right_angle() {
        let mesh = dome(40, 96);
        let TopPoint { point, inwards } = top_of_mesh(&mesh);
        println!("{point} {inwards}");
        // Residuals seen: 2e-3, half a triangle, 5e-4, and 0.01.
        assert!((point.xz().length() - 0.9).abs() < 0.03 && point.x > 0.8, "{point}");
        assert!((point.length() - 1.0).abs() < 2e-3, "{point}");
        assert!(inwards.distance(-point.normalize()) < 0.02, "{inwards}");
        // A flat top stays flat: the crown cut off.
        let mut cut = mesh;
        cut.vertices.iter_mut().for_each(|vertex| vertex.y = vertex.y.min(0.95));
        let TopPoint { point, inwards } = top_of_mesh(&cut);
        assert!((point.y - 0.95).abs() < 1e-12 && inwards == DVec3::NEG_Y, "{point} {inwards}");
    }
}
