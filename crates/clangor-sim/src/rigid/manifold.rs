//! The contact manifold of two convex parts: the points where they touch or will touch.
//!
//! A manifold has one unit normal n, from B to A, and points with their gaps measured along n. Against a
//! half-space the points are all vertices near the plane; for two balls they have a closed form. Otherwise
//! they are the closest points of the cores (GJK, or EPA for overlapping cores) and the face of one part
//! clipped by the prism of the other's face. A slow pair keeps at most nine points: the deepest and the
//! extremes in eight directions that are fixed in the reference body, so that the choice is stable from step
//! to step. A fast pair keeps all points, as any of them may strike next.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use parry3d_f64::math::Pose as ParryPose;
use parry3d_f64::query::details::contact_support_map_support_map_with_params as closest_points;
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;

use super::clip::clip;
use super::shape::{Part, PartShape};

/// Directions in which extreme points are kept.
const DIRECTIONS: usize = 8;
/// Rotates the directions away from the symmetry axes of common shapes \[rad\].
const FIRST_DIRECTION: f64 = 0.1234;
/// A face takes part in a manifold if the cosine between its normal and the contact normal is at least this.
const FACING: f64 = 0.7;
/// A cylinder's cap (side) takes part if the cosine between contact normal and axis exceeds (is below) this.
const CAP_FACING: f64 = 0.98;
const SIDE_FACING: f64 = 0.05;
/// A cylinder's rim is tested against a face if the cosine between face normal and contact normal exceeds
/// this.
const FLAT_FACING: f64 = 0.999_99;
/// Corners of the polygon that replaces a cap against a hull.
const CAP_CORNERS: usize = 16;
/// Angles from the lowest rim point at which further rim points are kept, on both sides \[rad\]: of a slow
/// cylinder, and of a fast one, whose lowest point may move along the rim within a step.
const SLOW_RIM: &[f64] = &[0.5 * PI, PI];
const FAST_RIM: &[f64] = &[0.04, 0.1, 0.18, 0.3, 0.45, 0.7, 1.1, 1.6, 2.3, PI];
/// The direction between cores that are nearer than this is dominated by rounding errors \[m\].
const IN_TOUCH: f64 = 1e-9;
/// Margin of the distance query \[m\].
const QUERY_MARGIN: f64 = 1e-4;

/// A part in the world.
pub(super) struct Placed<'a> {
    pub(super) part: &'a Part,
    pub(super) position: DVec3,
    pub(super) orientation: DQuat,
}

impl<'a> Placed<'a> {
    /// A part of a body with this pose.
    pub(super) fn new(part: &'a Part, position: DVec3, orientation: DQuat) -> Self {
        Placed {
            part,
            position: position + orientation * part.centre,
            orientation: orientation * part.rotation,
        }
    }

    /// Outermost point of the core along a world direction.
    fn support(&self, direction: DVec3) -> DVec3 {
        let local = self.part.local_support_point(self.orientation.inverse() * direction);
        self.position + self.orientation * local
    }
}

/// Points of A and B that face each other, and their gap along the normal \[m\], negative if they overlap.
#[derive(Clone, Copy)]
pub(super) struct ManifoldPoint {
    pub(super) on_a: DVec3,
    pub(super) on_b: DVec3,
    pub(super) gap: f64,
}

/// Distance of two parts.
pub(super) struct Separation {
    /// Distance along `normal` \[m\]; a lower bound if there are no points.
    pub(super) gap: f64,
    /// Unit vector from B to A; zero if the query failed, far away.
    pub(super) normal: DVec3,
    /// Whether the normal belongs to a face of A and therefore rotates with A.
    pub(super) normal_of_a: bool,
}

/// Buffers of [`manifold`].
#[derive(Default)]
pub(super) struct ManifoldScratch {
    face_a: Vec<DVec3>,
    face_b: Vec<DVec3>,
    clipped: Vec<DVec3>,
    spare: Vec<DVec3>,
    kept: Vec<ManifoldPoint>,
    simplex: Option<VoronoiSimplex>,
}

/// Two unit vectors that complete n to a right-handed frame.
pub(super) fn tangents(normal: DVec3) -> (DVec3, DVec3) {
    let start = if normal.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
    let t1 = (start - normal * start.dot(normal)).normalize();
    (t1, normal.cross(t1))
}

/// Distance, speed and last normal of a pair, for its manifold.
#[derive(Clone, Copy)]
pub(super) struct ManifoldQuery {
    /// Points with a larger gap than this are left out \[m\].
    pub(super) prediction: f64,
    /// Whether the pair is fast: all points are then kept, as any of them may strike next.
    pub(super) fast: bool,
    /// Normal of the last manifold, or zero. Where it still separates the parts no further test is made.
    pub(super) axis: DVec3,
}

impl ManifoldQuery {
    /// Angles from the lowest rim point of a cylinder at which further rim points are kept \[rad\].
    fn rim_angles(&self) -> &'static [f64] {
        if self.fast { FAST_RIM } else { SLOW_RIM }
    }
}

/// Puts the points of A and B with a gap below `query.prediction` into `points`. A half-space must be B.
pub(super) fn manifold(
    a: &Placed<'_>,
    b: &Placed<'_>,
    query: ManifoldQuery,
    points: &mut Vec<ManifoldPoint>,
    scratch: &mut ManifoldScratch,
) -> Separation {
    points.clear();
    match (&a.part.shape, &b.part.shape) {
        (_, PartShape::HalfSpace) => half_space(a, b, query, points, scratch),
        (PartShape::Ball { radius: ra }, PartShape::Ball { radius: rb }) => {
            let between = a.position - b.position;
            let normal = between.try_normalize().unwrap_or(DVec3::Y);
            let gap = between.length() - ra - rb;
            if gap < query.prediction {
                let (on_a, on_b) = (a.position - normal * *ra, b.position + normal * *rb);
                points.push(ManifoldPoint { on_a, on_b, gap });
            }
            Separation { gap, normal, normal_of_a: false }
        }
        _ => convex(a, b, query, points, scratch),
    }
}

fn half_space(
    a: &Placed<'_>,
    b: &Placed<'_>,
    query: ManifoldQuery,
    points: &mut Vec<ManifoldPoint>,
    scratch: &mut ManifoldScratch,
) -> Separation {
    let normal = b.orientation * DVec3::Y;
    let mut least = f64::INFINITY;
    let mut meet = |on_a: DVec3| {
        let gap = normal.dot(on_a - b.position);
        least = least.min(gap);
        if gap < query.prediction {
            points.push(ManifoldPoint { on_a, on_b: on_a - normal * gap, gap });
        }
    };
    match &a.part.shape {
        PartShape::Ball { radius } => meet(a.position - normal * *radius),
        PartShape::Cylinder { radius, half_height } => {
            let down = a.orientation.inverse() * -normal;
            rim_points(*radius, *half_height, down, query.rim_angles(), |p| {
                meet(a.position + a.orientation * p)
            });
        }
        PartShape::Hull(hull) => {
            for vertex in &hull.vertices {
                meet(a.position + a.orientation * *vertex);
            }
        }
        PartShape::HalfSpace => {}
    }
    if !query.fast {
        reduce(points, normal, a.orientation, scratch);
    }
    Separation { gap: least, normal, normal_of_a: false }
}

/// The outermost rim point of a cylinder along a direction, the far end of its side line, and the points of
/// that rim at these angles to both sides.
fn rim_points(radius: f64, half_height: f64, direction: DVec3, angles: &[f64], mut each: impl FnMut(DVec3)) {
    let across = direction.x.hypot(direction.y);
    // On a cap that is flat to 1e-5 all rim points are equivalent; a fixed choice is stable.
    let (c, s) = if across < 1e-5 { (1.0, 0.0) } else { (direction.x / across, direction.y / across) };
    let z = half_height.copysign(direction.z);
    each(DVec3::new(c * radius, s * radius, z));
    each(DVec3::new(c * radius, s * radius, -z));
    for angle in angles.iter().flat_map(|&a| [a, -a]).filter(|&a| a != -PI) {
        let (sin, cos) = angle.sin_cos();
        each(DVec3::new((c * cos - s * sin) * radius, (s * cos + c * sin) * radius, z));
    }
}

fn convex(
    a: &Placed<'_>,
    b: &Placed<'_>,
    query: ManifoldQuery,
    points: &mut Vec<ManifoldPoint>,
    scratch: &mut ManifoldScratch,
) -> Separation {
    let ManifoldQuery { prediction, fast, axis } = query;
    let (ra, rb) = (a.part.rounding(b.part), b.part.rounding(a.part));
    if axis != DVec3::ZERO {
        let gap = core_gap(a, b, axis) - ra - rb;
        if gap > prediction {
            return Separation { gap, normal: axis, normal_of_a: false };
        }
    }
    // Closest points of the cores by GJK, warm-started with the last normal.
    let far = prediction + QUERY_MARGIN;
    let to_a = a.orientation.inverse();
    let b_from_a =
        ParryPose { rotation: to_a * b.orientation, translation: to_a * (b.position - a.position) };
    let start = (axis != DVec3::ZERO).then(|| to_a * -axis);
    let simplex = scratch.simplex.get_or_insert_with(VoronoiSimplex::new);
    let (on_a, on_b, normal) = match closest_points(&b_from_a, a.part, b.part, far + ra + rb, simplex, start)
    {
        GJKResult::ClosestPoints(on_a, on_b, outward) => {
            (a.position + a.orientation * on_a, a.position + a.orientation * on_b, a.orientation * -outward)
        }
        GJKResult::NoIntersection(direction) => {
            let normal = a.orientation * -direction;
            if core_gap(a, b, normal) > 0.0 {
                return Separation { gap: far, normal, normal_of_a: false };
            }
            // EPA fails on coincident faces.
            let deepest = a.support(-normal);
            (deepest, deepest - normal * core_gap(a, b, normal), normal)
        }
        _ => return Separation { gap: far, normal: DVec3::ZERO, normal_of_a: false },
    };
    if !normal.is_finite() || normal.length_squared() < 0.5 {
        return Separation { gap: far, normal: DVec3::ZERO, normal_of_a: false };
    }
    let (normal, on_a, on_b) = match (on_a - on_b).dot(normal) {
        core if core < IN_TOUCH => least_overlap(a, b, normal, on_a, on_b),
        _ => (normal, on_a, on_b),
    };
    let gap = (on_a - on_b).dot(normal) - ra - rb;
    if gap > prediction {
        return Separation { gap, normal, normal_of_a: false };
    }
    // Face against face, and rim against face.
    let normal_of_a = face_points(a, b, normal, prediction, points, scratch);
    rim_over_face(a, b, normal, query, points, scratch);
    for point in points.iter_mut() {
        point.on_a -= normal * ra;
        point.on_b += normal * rb;
    }
    if !fast {
        reduce(points, normal, if normal_of_a { a.orientation } else { b.orientation }, scratch);
    }
    // Keeps the closest points where clipping misses them (an edge on an edge).
    if !points.iter().any(|p| p.gap < gap + 1e-6) {
        points.push(ManifoldPoint { on_a: on_a - normal * ra, on_b: on_b + normal * rb, gap });
    }
    Separation { gap, normal, normal_of_a }
}

/// Distance of the cores along a unit normal from B to A \[m\], negative if they overlap along it.
fn core_gap(a: &Placed<'_>, b: &Placed<'_>, normal: DVec3) -> f64 {
    (a.support(-normal) - b.support(normal)).dot(normal)
}

/// The direction of least overlap among `found` and the face normals, with its points. For parallel hulls EPA
/// may stop at a wrong direction.
fn least_overlap(
    a: &Placed<'_>,
    b: &Placed<'_>,
    found: DVec3,
    on_a: DVec3,
    on_b: DVec3,
) -> (DVec3, DVec3, DVec3) {
    let gap = |normal: DVec3| core_gap(a, b, normal);
    let faces = |placed: &Placed<'_>, sign: f64| -> Vec<DVec3> {
        let PartShape::Hull(hull) = &placed.part.shape else { return Vec::new() };
        hull.faces.iter().map(|f| placed.orientation * f.normal * sign).collect()
    };
    let mut best = (gap(found), found);
    for normal in faces(a, -1.0).into_iter().chain(faces(b, 1.0)) {
        let gap = gap(normal);
        if gap > best.0 + 1e-12 {
            best = (gap, normal);
        }
    }
    if best.1 == found {
        return (found, on_a, on_b);
    }
    let deepest = a.support(-best.1);
    (best.1, deepest, deepest - best.1 * best.0)
}

/// Clips the facing faces of both parts; true if the reference face belongs to A.
fn face_points(
    a: &Placed<'_>,
    b: &Placed<'_>,
    normal: DVec3,
    prediction: f64,
    points: &mut Vec<ManifoldPoint>,
    scratch: &mut ManifoldScratch,
) -> bool {
    let plane_a = support_face(a, -normal, &mut scratch.face_a);
    let plane_b = support_face(b, normal, &mut scratch.face_b);
    let (count_a, count_b) = (scratch.face_a.len(), scratch.face_b.len());
    if count_a < 2 || count_b < 2 {
        return false;
    }
    let facing_a = plane_a.map_or(-1.0, |f| -f.dot(normal));
    let facing_b = plane_b.map_or(-1.0, |f| f.dot(normal));
    // B wins near ties, so that rounding does not swap the reference.
    let of_a = count_a > 2 && (count_b == 2 || facing_a > facing_b + 1e-3);
    let (reference, incident, plane, outward) = match (of_a, plane_a, plane_b) {
        (true, Some(plane), _) => (&scratch.face_a, &scratch.face_b, plane, -normal),
        (false, _, Some(plane)) if count_b > 2 => (&scratch.face_b, &scratch.face_a, plane, normal),
        _ => return false,
    };
    let rounding = a.part.rounding(b.part) + b.part.rounding(a.part);
    clip(incident, reference, outward, &mut scratch.clipped, &mut scratch.spare);
    let slope = plane.dot(outward);
    for &point in &scratch.clipped {
        let height = (point - reference[0]).dot(plane) / slope;
        let foot = point - outward * height;
        let gap = height - rounding;
        if gap < prediction {
            let (on_a, on_b) = if of_a { (foot, point) } else { (point, foot) };
            points.push(ManifoldPoint { on_a, on_b, gap });
        }
    }
    of_a
}

/// Adds the rim points of a cylinder above a face of a hull. As on a half-space, the lowest point of a
/// wobbling coin moves along the rim faster than the closest points alone can follow.
fn rim_over_face(
    a: &Placed<'_>,
    b: &Placed<'_>,
    normal: DVec3,
    query: ManifoldQuery,
    points: &mut Vec<ManifoldPoint>,
    scratch: &mut ManifoldScratch,
) {
    let (cylinder, hull, of_a) = match (&a.part.shape, &b.part.shape) {
        (PartShape::Cylinder { .. }, PartShape::Hull(_)) => (a, b, true),
        (PartShape::Hull(_), PartShape::Cylinder { .. }) => (b, a, false),
        _ => return,
    };
    let PartShape::Cylinder { radius, half_height } = &cylinder.part.shape else { return };
    let up = if of_a { normal } else { -normal };
    let face = &mut scratch.face_b;
    let Some(plane) = support_face(hull, up, face) else { return };
    if plane.dot(up) < FLAT_FACING {
        return;
    }
    let is_above = |p: DVec3| {
        (0..face.len()).all(|i| {
            let (from, to) = (face[i], face[(i + 1) % face.len()]);
            (p - from).dot((to - from).cross(plane)) <= 0.0
        })
    };
    let rounding = a.part.rounding(b.part) + b.part.rounding(a.part);
    let down = cylinder.orientation.inverse() * -plane;
    rim_points(*radius, *half_height, down, query.rim_angles(), |p| {
        let rim = cylinder.position + cylinder.orientation * p;
        let height = (rim - face[0]).dot(plane) / plane.dot(up);
        let gap = height - rounding;
        if gap < query.prediction && is_above(rim) {
            let foot = rim - up * height;
            let (on_a, on_b) = if of_a { (rim, foot) } else { (foot, rim) };
            points.push(ManifoldPoint { on_a, on_b, gap });
        }
    });
}

/// The face (or the side line of a cylinder) that faces a world direction, counter-clockwise seen from
/// outside, and its normal.
fn support_face(placed: &Placed<'_>, direction: DVec3, out: &mut Vec<DVec3>) -> Option<DVec3> {
    out.clear();
    let local = placed.orientation.inverse() * direction;
    let world = |v: DVec3| placed.position + placed.orientation * v;
    match &placed.part.shape {
        PartShape::Hull(hull) => {
            let face =
                hull.faces.iter().max_by(|f, g| f.normal.dot(local).total_cmp(&g.normal.dot(local)))?;
            if face.normal.dot(local) < FACING {
                return None;
            }
            out.extend(face.corners.iter().map(|&i| world(hull.vertices[i as usize])));
            Some(placed.orientation * face.normal)
        }
        PartShape::Cylinder { radius, half_height } => {
            let across = local.x.hypot(local.y);
            if local.z.abs() > CAP_FACING {
                let first = if across > 1e-6 { local.y.atan2(local.x) } else { 0.0 };
                let z = half_height.copysign(local.z);
                out.extend((0..CAP_CORNERS).map(|k| {
                    let angle = first + k as f64 * TAU / CAP_CORNERS as f64 * local.z.signum();
                    world(DVec3::new(radius * angle.cos(), radius * angle.sin(), z))
                }));
                return Some(placed.orientation * DVec3::new(0.0, 0.0, local.z.signum()));
            }
            if local.z.abs() < SIDE_FACING {
                let (x, y) = (local.x / across * radius, local.y / across * radius);
                out.extend([world(DVec3::new(x, y, *half_height)), world(DVec3::new(x, y, -half_height))]);
            }
            None
        }
        PartShape::Ball { .. } | PartShape::HalfSpace => None,
    }
}

/// Keeps the deepest point and the extreme points in directions fixed to `frame`.
fn reduce(points: &mut Vec<ManifoldPoint>, normal: DVec3, frame: DQuat, scratch: &mut ManifoldScratch) {
    if points.len() <= DIRECTIONS {
        return;
    }
    let (t1, t2) = tangents(frame.inverse() * normal);
    let (t1, t2) = (frame * t1, frame * t2);
    let mut chosen = [usize::MAX; DIRECTIONS + 1];
    chosen[DIRECTIONS] =
        (0..points.len()).min_by(|&i, &j| points[i].gap.total_cmp(&points[j].gap)).unwrap_or(0);
    for (k, slot) in chosen[..DIRECTIONS].iter_mut().enumerate() {
        let angle = k as f64 * TAU / DIRECTIONS as f64 + FIRST_DIRECTION;
        let direction = t1 * angle.cos() + t2 * angle.sin();
        let reach = |i: usize| points[i].on_b.dot(direction);
        *slot = (0..points.len()).max_by(|&i, &j| reach(i).total_cmp(&reach(j))).unwrap_or(0);
    }
    chosen.sort_unstable();
    let kept = &mut scratch.kept;
    kept.clear();
    let mut last = usize::MAX;
    for i in chosen {
        if i != last {
            kept.push(points[i]);
        }
        last = i;
    }
    points.clone_from(kept);
}
