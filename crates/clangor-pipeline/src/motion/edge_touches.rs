//! Where a sharp edge of one surface crosses one of another: the point between them, and the normal, which is
//! that of neither surface.
//!
//! ```text
//! n = ± e_a × e_b / |e_a × e_b|        between the normals of the faces at both edges, out of b and into a
//! ```
//!
//! Both edges are then the features of their bodies that lie farthest along n (the Gauss maps of two convex
//! edges cross: Gregorius, *The separating axis test between convex polyhedra*, GDC 2013), so that the gap
//! along n is that of the surfaces. Hollow edges meet nothing. What touches at an end of an edge is a corner,
//! which is found by the points of the surfaces.

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::pose::Pose;
use glam::DVec3;

use super::parting_normals::faces_of_edges;
use super::touch::Touch;

/// Cosine of the angle between the normals of two faces up to which their edge is sharp: 20°.
const SHARP: f64 = 0.94;
/// Most sharp edges of a surface; with more, it has too many to hold each against each, and they are small.
const MOST_EDGES: usize = 1000;
/// Sine of the angle between two edges up to which they are parallel, and touch in a line.
const PARALLEL: f64 = 0.1;
/// Distance of two crossings that are one, over the largest gap.
const SAME_POINT: f64 = 1e-3;
/// Negative share of a face's normal in n that is rounding.
const ROUNDING: f64 = 1e-6;

/// A convex edge between two faces, in the frame of its body.
#[derive(Clone, Copy, Debug)]
pub(super) struct SharpEdge {
    middle: DVec3,
    /// From the middle to an end.
    half: DVec3,
    /// Normals of the two faces.
    normals: [DVec3; 2],
}

/// The sharp edges of a surface, where it is, and its bounding radius \[m\].
#[derive(Clone, Copy)]
pub(super) struct Edges<'a> {
    pub(super) edges: &'a [SharpEdge],
    pub(super) pose: Pose,
    pub(super) radius: f64,
}

/// The convex edges of a closed mesh; none if they are too many.
pub(super) fn sharp_edges(mesh: &TriMesh) -> Vec<SharpEdge> {
    let normal = |face: usize| mesh.area_vector(face).normalize_or_zero();
    let mut edges = Vec::new();
    for (ends, faces) in faces_of_edges(mesh) {
        let &[one, two] = &faces[..] else { continue };
        let normals = [normal(one), normal(two)];
        let [a, b] = ends.map(|vertex| mesh.vertices[vertex as usize]);
        let is_convex = normals[0].dot(mesh.centroid(two) - a) < 0.0;
        if normals[0].dot(normals[1]) < SHARP && is_convex {
            edges.push(SharpEdge { middle: 0.5 * (a + b), half: 0.5 * (b - a), normals });
        }
    }
    if edges.len() > MOST_EDGES { Vec::new() } else { edges }
}

/// Crossings of sharp edges of two surfaces with a gap or an overlap of at most `within` \[m\].
pub(super) fn edge_touches(a: Edges<'_>, b: Edges<'_>, within: f64) -> Vec<Touch> {
    if a.edges.is_empty() || b.edges.is_empty() {
        return Vec::new();
    }
    let near = |own: Edges<'_>, other: Edges<'_>| -> Vec<SharpEdge> {
        let centre = own.pose.body_from_world(other.pose.position);
        let reach = other.radius + within;
        let edges = own.edges.iter();
        let is_near = |edge: &&SharpEdge| edge.middle.distance(centre) < reach + edge.half.length();
        edges.filter(is_near).map(|edge| edge.placed(own.pose)).collect()
    };
    let (ours, theirs) = (near(a, b), near(b, a));
    let mut found: Vec<Touch> = Vec::new();
    for (one, two) in ours.iter().flat_map(|one| theirs.iter().map(move |two| (one, two))) {
        let Some(touch) = crossing(one, two, within) else { continue };
        // At a vertex that divides an edge, both parts of it cross the other.
        if !found.iter().any(|known| known.point.distance(touch.point) < SAME_POINT * within) {
            found.push(touch);
        }
    }
    found
}

impl SharpEdge {
    fn placed(&self, pose: Pose) -> Self {
        SharpEdge {
            middle: pose.world_from_body(self.middle),
            half: pose.orientation * self.half,
            normals: self.normals.map(|normal| pose.orientation * normal),
        }
    }

    /// Whether a direction across the edge lies between the normals of its faces.
    fn faces(&self, direction: DVec3) -> bool {
        let [one, two] = self.normals;
        let (cosine, along) = (one.dot(two), [one, two].map(|normal| normal.dot(direction)));
        let shares = [along[0] - cosine * along[1], along[1] - cosine * along[0]];
        shares.iter().all(|share| *share > -ROUNDING)
    }
}

/// The touch of an edge of the first body with one of the second.
fn crossing(one: &SharpEdge, two: &SharpEdge, within: f64) -> Option<Touch> {
    let (u, v, apart) = (one.half, two.half, one.middle - two.middle);
    let (uu, vv, uv) = (u.length_squared(), v.length_squared(), u.dot(v));
    if apart.length() > uu.sqrt() + vv.sqrt() + within {
        return None;
    }
    let across = u.cross(v);
    let square = across.length_squared();
    if square <= (PARALLEL * PARALLEL) * uu * vv {
        return None;
    }
    // The points of both lines that are nearest to each other, in halves of the edges from the middles.
    let (s, t) =
        ((uv * apart.dot(v) - vv * apart.dot(u)) / square, (uu * apart.dot(v) - uv * apart.dot(u)) / square);
    if s.abs() > 1.0 || t.abs() > 1.0 {
        return None;
    }
    let axis = across / square.sqrt();
    let normal = [axis, -axis].into_iter().find(|normal| two.faces(*normal) && one.faces(-*normal))?;
    let (mine, other) = (one.middle + u * s, two.middle + v * t);
    let gap = (mine - other).dot(normal);
    (gap.abs() <= within).then(|| Touch { point: 0.5 * (mine + other), normal, gap })
}

#[cfg(test)]
mod tests {
    use clangor_core::body::Surface;
    use clangor_core::shape::{Form, Shape};
    use glam::DQuat;

    use super::*;

    /// Two cubes of 0.1 m, each on an edge, one above the other with a gap: their edges cross at a right
    /// angle.
    #[test]
    fn edges_of_two_cubes_cross_with_the_normal_between_them() {
        let form = Form::Box { edges: DVec3::splat(0.1) };
        let (surface, _) = Shape::try_new(form, None).unwrap().surface().unwrap();
        let Surface::Mesh(mesh) = &surface else { panic!("a box is a mesh") };
        let edges = sharp_edges(&mesh.mesh);
        assert!(edges.len().is_multiple_of(12), "{}", edges.len());
        let on_edge = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let across = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2) * on_edge;
        // Also at the middle of both edges, where vertices divide them.
        for (gap, along) in [(1e-4, 0.02), (-1e-4, 0.02), (1e-4, 0.0)] {
            let height = 0.1 * std::f64::consts::SQRT_2 + gap;
            let upper = Pose { position: DVec3::new(0.01, height, along), orientation: across };
            let lower = Pose { position: DVec3::ZERO, orientation: on_edge };
            let radius = surface.bounding_radius();
            let [upper, lower] = [upper, lower].map(|pose| Edges { edges: &edges, pose, radius });
            let found = edge_touches(upper, lower, 2e-4);
            // Seen: one touch, within 4e-17 m.
            assert_eq!(found.len(), 1, "{found:?}");
            let place = DVec3::new(0.0, 0.05 * std::f64::consts::SQRT_2 + 0.5 * gap, along);
            assert!(found[0].point.distance(place) < 1e-12, "{found:?}");
            assert!(found[0].normal.distance(DVec3::Y) < 1e-12, "{found:?}");
            assert!((found[0].gap - gap).abs() < 1e-12, "{found:?}");
            assert!(edge_touches(upper, lower, 0.5e-4).is_empty());
            let turned = edge_touches(lower, upper, 2e-4);
            assert!(turned[0].normal.distance(DVec3::NEG_Y) < 1e-12, "{turned:?}");
        }
    }
}
