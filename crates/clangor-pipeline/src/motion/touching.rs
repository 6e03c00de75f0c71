//! Where two surfaces touch: points, normals and gaps, from surfaces that meet, nearly meet or overlap a
//! little.
//!
//! Points of each surface, its vertices and points along long edges, are held against the other: a corner on
//! a face is found exactly, a round edge on an edge to the distance of those points, sharp edges exactly
//! ([`edge_touches`](super)). Of a mesh with more than 6000
//! vertices only every second, third, … is held, and corners are found to their distance. Spheres and planes
//! are exact.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::{MeshSurface, Surface};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::pose::Pose;
use glam::DVec3;

use super::area_corners::spread;
use super::edge_touches::{Edges, SharpEdge, edge_touches, sharp_edges};
use super::parting_normals::{ConvexCorners, parting};
use super::touch::Touch;

/// Edges are divided into parts of at most this share of the bounding radius.
const EDGE_SHARE: f64 = 0.12;
/// Most points of a surface; more vertices are thinned.
const MOST_POINTS: usize = 6000;
/// Crossings of edges that are kept.
const KEPT_CROSSINGS: usize = 5;

/// Where the first point of a contact that lasts is sought, in the frame of the first body: along no axis of
/// symmetry.
const FIRST_CORNER: DVec3 = DVec3::new(0.873, 0.213, 0.439);

/// A surface with the points that are held against others.
pub(super) struct SampledSurface {
    pub(super) surface: Arc<Surface>,
    pub(super) radius: f64,
    /// Bounds of a mesh \[m\], and the distance from it that is none.
    bounds: (DVec3, DVec3),
    clear: f64,
    points: Vec<DVec3>,
    edges: Vec<SharpEdge>,
    convex: Option<ConvexCorners>,
}

impl SampledSurface {
    pub(super) fn new(surface: &Arc<Surface>) -> Self {
        let radius = surface.bounding_radius();
        let (mut points, mut edges, mut convex) = (Vec::new(), Vec::new(), None);
        let (mut bounds, mut clear) = ((DVec3::ZERO, DVec3::ZERO), 0.0);
        if let Surface::Mesh(mesh) = &**surface {
            (bounds, clear) = (mesh.mesh.bounds(), 1e-6 * mesh.mesh.diagonal());
            points = sample(&mesh.mesh, EDGE_SHARE * radius);
            edges = sharp_edges(&mesh.mesh);
            convex = ConvexCorners::of(&mesh.mesh);
        }
        SampledSurface { surface: Arc::clone(surface), radius, bounds, clear, points, edges, convex }
    }
}

fn sample(mesh: &TriMesh, longest: f64) -> Vec<DVec3> {
    let stride = mesh.vertices.len().div_ceil(MOST_POINTS).max(1);
    let mut points: Vec<DVec3> = mesh.vertices.iter().copied().step_by(stride).collect();
    let mut edges: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for triangle in &mesh.triangles {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (triangle[a].min(triangle[b]), triangle[a].max(triangle[b]));
            let length = mesh.vertices[a as usize].distance(mesh.vertices[b as usize]);
            edges.insert((a, b), length);
        }
    }
    for ((a, b), length) in edges {
        let parts = (length / longest).ceil().min(64.0) as u32;
        if points.len() + parts as usize > MOST_POINTS {
            break;
        }
        let (a, b) = (mesh.vertices[a as usize], mesh.vertices[b as usize]);
        points.extend((1..parts).map(|k| a.lerp(b, f64::from(k) / f64::from(parts))));
    }
    points
}

/// A surface and where it is.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub(super) sampled: &'a SampledSurface,
    pub(super) pose: Pose,
}

impl Placed<'_> {
    fn edges(&self) -> Edges<'_> {
        Edges { edges: &self.sampled.edges, pose: self.pose, radius: self.sampled.radius }
    }

    /// Distance of a point [m, world] from the surface \[m\], negative inside.
    pub(super) fn signed_distance(&self, point: DVec3) -> f64 {
        let local = self.pose.body_from_world(point);
        match &*self.sampled.surface {
            Surface::HalfSpace | Surface::Plate { .. } => local.y,
            Surface::Sphere { radius } => local.length() - radius,
            Surface::Mesh(mesh) => mesh.signed_distance(local),
        }
    }
}

/// Whether the bounding balls come within a distance \[m\].
pub(super) fn may_touch(a: Placed<'_>, b: Placed<'_>, within: f64) -> bool {
    let height = |plane: Placed<'_>, other: Placed<'_>| plane.pose.body_from_world(other.pose.position).y;
    match (a.sampled.surface.is_plane(), b.sampled.surface.is_plane()) {
        (true, true) => false,
        (true, false) => height(a, b) < b.sampled.radius + within,
        (false, true) => height(b, a) < a.sampled.radius + within,
        (false, false) => {
            a.pose.position.distance(b.pose.position) < a.sampled.radius + b.sampled.radius + within
        }
    }
}

/// Points of two surfaces with a gap of at most `within` \[m\]: the [corners](super::area_corners) of the
/// areas that touch, and the nearest crossings of edges.
pub(super) fn touches(a: Placed<'_>, b: Placed<'_>, within: f64) -> Vec<Touch> {
    let mut found = spread(that_part(near_points(a, b, within), a, b, within));
    let mut crossings = edge_touches(a.edges(), b.edges(), within);
    crossings.sort_by(|a, b| a.gap.abs().total_cmp(&b.gap.abs()));
    found.extend(crossings.into_iter().take(KEPT_CROSSINGS));
    found
}

/// How far the points of two surfaces are from the other, from one pose to the next: a point whose distance
/// is not yet used up by the motion need not be asked again.
#[derive(Clone, Debug, Default)]
pub(super) struct Clearance {
    poses: Option<[Pose; 2]>,
    /// Way of each body in the frame of the other, of its fastest point \[m\].
    travelled: [f64; 2],
    /// That way plus the distance from the other surface, of each point of the two, when it was asked \[m\].
    free_to: [Vec<f64>; 2],
}

impl Clearance {
    fn move_to(&mut self, a: Placed<'_>, b: Placed<'_>) {
        let poses = [a.pose, b.pose];
        if let Some(before) = self.poses.replace(poses) {
            for (i, sampled) in [(0, a.sampled), (1, b.sampled)] {
                let relative = |[own, other]: [Pose; 2]| {
                    let back = other.orientation.inverse();
                    (back * (own.position - other.position), back * own.orientation)
                };
                let order = |poses: [Pose; 2]| [poses[i], poses[1 - i]];
                let [(x, q), (y, r)] = [relative(order(before)), relative(order(poses))];
                // Of a rotation, the angle is at most π/2 times twice the distance of the quaternions.
                let angle = std::f64::consts::PI * (q - r).length().min((q + r).length());
                self.travelled[i] += x.distance(y) + if angle > 0.0 { angle * sampled.radius } else { 0.0 };
            }
        }
    }
}

/// The same for a contact that lasts: up to four corners of the area that touches, each the mean of the
/// points within `merged` \[m\] of it by what their gaps lack of `within`. They move with the bodies, without
/// the leaps of the deepest point, and begin from a direction that is fixed in the first body. Points deeper
/// than `within` are not seen. `known` is that of the same surfaces in the pose before.
pub(super) fn lasting_touches(
    a: Placed<'_>,
    b: Placed<'_>,
    (within, merged): (f64, f64),
    known: &mut Clearance,
) -> Vec<Touch> {
    known.move_to(a, b);
    if !may_touch(a, b, within) {
        return Vec::new();
    }
    let mut found = Vec::new();
    match (&*a.sampled.surface, &*b.sampled.surface) {
        (Surface::Sphere { .. }, _) | (_, Surface::Sphere { .. }) => found = near_points(a, b, within),
        _ => {
            let Clearance { travelled, free_to: [of_a, of_b], .. } = known;
            found.extend(points_within(a, b, within, (of_a, travelled[0])));
            let others = points_within(b, a, within, (of_b, travelled[1]));
            found.extend(others.into_iter().map(Touch::turned));
        }
    }
    corners(that_part(found, a, b, within), a.pose, within, merged)
}

/// The points along whose normals two surfaces part, where both are convex.
fn that_part(found: Vec<Touch>, a: Placed<'_>, b: Placed<'_>, within: f64) -> Vec<Touch> {
    match (&a.sampled.convex, &b.sampled.convex) {
        (Some(one), Some(two)) => parting(found, [(one, a.pose), (two, b.pose)], within),
        _ => found,
    }
}

/// Points of `a` within a distance of the surface `b`; `free_to` as in [`Clearance`], after this way.
fn points_within(
    a: Placed<'_>,
    b: Placed<'_>,
    within: f64,
    (free_to, travelled): (&mut Vec<f64>, f64),
) -> Vec<Touch> {
    free_to.resize(a.sampled.points.len(), f64::NEG_INFINITY);
    let mut found = Vec::new();
    for (point, free_to) in a.sampled.points.iter().zip(free_to) {
        if *free_to - travelled > within {
            continue;
        }
        let place = a.pose.world_from_body(*point);
        let distance = rough_distance(place, b, within);
        *free_to = travelled + distance;
        if distance <= within
            && let Some((gap, normal)) = distance_and_normal(place, b, within, &|| inward(a, *point))
        {
            found.push(Touch { point: place - normal * (0.5 * gap), normal, gap });
        }
    }
    found
}

/// Distance of a point from a surface \[m\], exact where it is at most `within`, and otherwise at most the
/// true one.
fn rough_distance(point: DVec3, other: Placed<'_>, within: f64) -> f64 {
    let local = other.pose.body_from_world(point);
    match &*other.sampled.surface {
        Surface::HalfSpace | Surface::Plate { .. } => local.y.abs(),
        Surface::Sphere { radius } => (local.length() - radius).abs(),
        Surface::Mesh(mesh) => {
            let outside = local.length() - other.sampled.radius;
            if outside > within {
                return outside;
            }
            mesh.nearest(local).map_or(0.0, |nearest| nearest.distance)
        }
    }
}

/// The corners of an area of points, from a direction in the frame of a body.
fn corners(found: Vec<Touch>, pose: Pose, within: f64, merged: f64) -> Vec<Touch> {
    let along = pose.orientation * FIRST_CORNER;
    let farthest = |measure: &dyn Fn(&Touch) -> f64| {
        found.iter().max_by(|a, b| measure(a).total_cmp(&measure(b))).map(|touch| (*touch, measure(touch)))
    };
    let Some((first, _)) = farthest(&|touch| touch.point.dot(along)) else { return found };
    let mut corners = vec![first];
    // The point opposite, and those on both sides of the line between them.
    let opposite = farthest(&|touch| touch.point.distance(first.point));
    if let Some((second, _)) = opposite.filter(|(_, distance)| *distance > merged) {
        corners.push(second);
        let aside = first.normal.cross(second.point - first.point).normalize_or_zero();
        for side in [aside, -aside] {
            let third = farthest(&|touch| (touch.point - first.point).dot(side));
            corners.extend(third.filter(|(_, distance)| *distance > merged).map(|(touch, _)| touch));
        }
    }
    let mean = |corner: &Touch| {
        let near = found.iter().filter(|touch| touch.point.distance(corner.point) <= merged);
        let (mut sum, mut whole) = (Touch { point: DVec3::ZERO, normal: DVec3::ZERO, gap: 0.0 }, 0.0);
        for touch in near {
            let weight = within - touch.gap;
            sum.point += touch.point * weight;
            sum.normal += touch.normal * weight;
            sum.gap += touch.gap * weight;
            whole += weight;
        }
        let normal = sum.normal.try_normalize().filter(|_| whole > 0.0);
        normal.map_or(*corner, |normal| Touch { point: sum.point / whole, normal, gap: sum.gap / whole })
    };
    corners.iter().map(mean).collect()
}

/// Points of two surfaces with a gap of at most `within` \[m\].
fn near_points(a: Placed<'_>, b: Placed<'_>, within: f64) -> Vec<Touch> {
    if !may_touch(a, b, within) {
        return Vec::new();
    }
    let mut found = Vec::new();
    match (&*a.sampled.surface, &*b.sampled.surface) {
        (Surface::Sphere { radius }, _) => found.extend(ball_touch(a.pose.position, *radius, b)),
        (_, Surface::Sphere { radius }) => {
            found.extend(ball_touch(b.pose.position, *radius, a).map(Touch::turned));
        }
        _ => {
            found.extend(point_touches(a, b, within));
            found.extend(point_touches(b, a, within).into_iter().map(Touch::turned));
        }
    }
    found.retain(|touch| touch.gap <= within);
    found
}

/// The ball touches the surface in one point.
fn ball_touch(centre: DVec3, radius: f64, other: Placed<'_>) -> Option<Touch> {
    let (distance, normal) = distance_and_normal(centre, other, f64::INFINITY, &|| None)?;
    let gap = distance - radius;
    Some(Touch { point: centre - normal * (radius + 0.5 * gap), normal, gap })
}

/// Points of `a` near the surface `b`.
fn point_touches(a: Placed<'_>, b: Placed<'_>, within: f64) -> Vec<Touch> {
    let touch = |own: &DVec3| {
        let point = a.pose.world_from_body(*own);
        let (gap, normal) = distance_and_normal(point, b, within, &|| inward(a, *own))?;
        Some(Touch { point: point - normal * (0.5 * gap), normal, gap })
    };
    a.sampled.points.iter().filter_map(touch).collect()
}

/// The direction \[world\] into a body from a point of its surface \[body frame\].
fn inward(body: Placed<'_>, point: DVec3) -> Option<DVec3> {
    Some(body.pose.orientation * -body.sampled.surface.normal_at(point)?)
}

/// Signed distance of a point from a surface \[m\], and the direction away from it; `None` where it is
/// certainly farther than `within`. `inward` is the direction into the body of the point.
fn distance_and_normal(
    point: DVec3,
    other: Placed<'_>,
    within: f64,
    inward: &dyn Fn() -> Option<DVec3>,
) -> Option<(f64, DVec3)> {
    let local = other.pose.body_from_world(point);
    match &*other.sampled.surface {
        Surface::HalfSpace | Surface::Plate { .. } => Some((local.y, other.pose.orientation * DVec3::Y)),
        Surface::Sphere { radius } => {
            Some((local.length() - radius, other.pose.orientation * local.try_normalize()?))
        }
        Surface::Mesh(mesh) => {
            let (low, high) = other.sampled.bounds;
            if local.distance_squared(local.clamp(low, high)) > within * within {
                return None;
            }
            let inward = || Some(other.pose.orientation.inverse() * inward()?);
            let (distance, normal) = mesh_distance((mesh, other.sampled.clear), local, &inward)?;
            Some((distance, other.pose.orientation * normal))
        }
    }
}

/// Ways into the body of a point that are tried, over the distance that counts as none: the second leads out
/// of bodies that overlap a little.
const ASIDE: [f64; 2] = [100.0, 1e4];

/// Signed distance of a point from a mesh \[m\], and the direction away from it; distances up to `clear`
/// \[m\] are none.
fn mesh_distance(
    (mesh, clear): (&MeshSurface, f64),
    local: DVec3,
    inward: &dyn Fn() -> Option<DVec3>,
) -> Option<(f64, DVec3)> {
    let nearest = mesh.nearest(local)?;
    let outward = mesh.normal_of(&nearest)?;
    let away = local - nearest.position;
    let distance = nearest.distance.copysign(away.dot(outward));
    if nearest.distance > clear {
        return Some((distance, away / distance));
    }
    // On the surface the difference has no direction. Where an edge or a corner lies on one of the other
    // body, as those of boxes in a stack, neither has a normal: a point a little way into its body has.
    let beside = |way: f64| {
        let point = local + way * clear * inward()?;
        let nearest = mesh.nearest(point)?;
        let normal = (point - nearest.position).try_normalize()?;
        (mesh.normal_of(&nearest)?.dot(normal) > 0.0).then_some(normal)
    };
    Some((distance, ASIDE.into_iter().find_map(beside).unwrap_or(outward)))
}

#[cfg(test)]
mod tests {
    use clangor_core::shape::Shape;

    use super::*;

    #[test]
    fn boxes_that_share_corners_touch_along_their_faces() {
        let mesh = Shape::parse("box:0.04x0.04x0.04").unwrap().mesh();
        let (surface, _) = MeshSurface::try_new(mesh, Vec::new()).unwrap();
        let sampled = SampledSurface::new(&Arc::new(Surface::Mesh(surface)));
        let at = |place: DVec3| Placed { sampled: &sampled, pose: Pose::at(place) };
        let shifts = [0.0, 0.01, 0.02];
        let places = shifts.into_iter().flat_map(|shift| [0.02, 0.3, 0.7].map(|start| (shift, start)));
        let cases = places.flat_map(|(shift, start)| [0.0, 1e-5].map(|overlap| (shift, start, overlap)));
        for (shift, start, overlap) in cases {
            for (along, aside) in [(DVec3::X, DVec3::Y), (DVec3::Y, DVec3::Z), (DVec3::Z, DVec3::X)] {
                let place = (start + 0.04 - overlap) * along + shift * aside;
                let (lower, upper) = (at(start * along), at(place));
                for within in [1e-5, 5e-4] {
                    let lasting = lasting_touches(upper, lower, (within, 1e-3), &mut Clearance::default());
                    for touch in touches(upper, lower, within).iter().chain(&lasting) {
                        let case = format!("{along} {shift} {start} {overlap} {within}: {touch:?}");
                        // Residuals seen: 7e-13, and 7e-17 beyond the overlap.
                        assert!((touch.normal - along).length() < 1e-9, "{case}");
                        assert!(touch.gap < 1e-15 && touch.gap > -overlap - 1e-15, "{case}");
                    }
                    assert!(lasting.len() >= 3, "{lasting:?}");
                }
            }
        }
    }
}
