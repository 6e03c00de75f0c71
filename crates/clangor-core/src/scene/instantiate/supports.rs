//! The supports of a body, with the checks that need its mass and its surface.
//!
//! A region holds the points of the body in it: those of its surface, and a few inside the body.

use glam::DVec3;

use super::geometry::LoadedGeometry;
use super::problems::Problems;
use crate::body::support::{Support, SupportKind, SupportRegion, free_motions};
use crate::body::{Body, MeshSurface, Surface};
use crate::scene::body_description::BodyDescription;
use crate::scene::diagnostic::{Place, Problem};
use crate::scene::support_problem::SupportProblem;

/// The supports of a body; errors are those of the text.
pub(super) fn supports(
    description: &BodyDescription,
    (body, geometry): (&Body, &LoadedGeometry),
    problems: &mut Problems,
) -> Vec<Support> {
    let Some(first) = description.supports.first() else { return Vec::new() };
    let name = || body.name.clone();
    let Surface::Mesh(surface) = &*body.surface else {
        problems.error(first.place.clone(), Problem::Support(SupportProblem::Sphere { body: name() }));
        return Vec::new();
    };
    let radius = body.surface.bounding_radius();
    let mut all: Vec<(Support, &Place)> = Vec::new();
    let mut held: Vec<(DVec3, DVec3)> = Vec::new();
    let mut whole = true;
    for own in &description.supports {
        for support in own.resolve(body.mass, radius, geometry.mass.centre_of_mass) {
            let points = points_in(surface, &support.region);
            if points.is_empty() {
                let distance = distance(surface, &support.region);
                let problem = SupportProblem::Off { body: name(), distance };
                problems.error(own.place.clone(), Problem::Support(problem));
                whole = false;
            }
            // A convex region that holds all vertices holds the body.
            let holds_all = || surface.mesh.vertices.iter().all(|x| support.region.distance(*x) == 0.0);
            if support.kind == SupportKind::Clamped && holds_all() {
                problems.error(own.place.clone(), Problem::Support(SupportProblem::Whole { body: name() }));
            }
            let clamped = |(other, _): &&(Support, &Place)| {
                support.kind == SupportKind::Clamped
                    && other.kind == SupportKind::Clamped
                    && other.region.overlaps(&support.region)
            };
            if let Some((_, other)) = all.iter().find(clamped) {
                let problem = SupportProblem::Overlap { first_line: other.line };
                problems.error(own.place.clone(), Problem::Support(problem));
            }
            let stiffness = match support.kind {
                SupportKind::Clamped => DVec3::INFINITY,
                SupportKind::Sprung { stiffness, .. } => stiffness,
            };
            held.extend(points.into_iter().map(|point| (point, stiffness)));
            all.push((support, &own.place));
        }
    }
    // A clamp is as stiff as the stiffest spring, so that neither drowns in the other.
    let finite = held.iter().map(|(_, k)| k.max_element()).filter(|k| k.is_finite()).fold(0.0, f64::max);
    let clamp = DVec3::splat(if finite > 0.0 { finite } else { 1.0 });
    held.iter_mut().filter(|(_, k)| !k.is_finite()).for_each(|(_, k)| *k = clamp);
    let motions = free_motions(&held);
    if whole && motions > 0 {
        problems.error(first.place.clone(), Problem::Support(SupportProblem::Free { body: name(), motions }));
    }
    all.into_iter().map(|(support, _)| support).collect()
}

/// Where a region is looked at besides its middle, in its half extents.
const WITHIN: f64 = 0.6;

/// Points of a body in a region: corners of the parts of its triangles there, and places in the region with
/// the nearest points of the surface.
fn points_in(surface: &MeshSurface, region: &SupportRegion) -> Vec<DVec3> {
    let mesh = &surface.mesh;
    let (middle, half) = region.bounds();
    let (low, high) = (middle - half, middle + half);
    let mut points = Vec::new();
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let [least, most] = [corners.into_iter().reduce(DVec3::min), corners.into_iter().reduce(DVec3::max)];
        let apart = |(least, most): (DVec3, DVec3)| (least.cmpgt(high) | most.cmplt(low)).any();
        if least.zip(most).is_none_or(apart) {
            continue;
        }
        let part = clipped(corners, low, high);
        points.extend(part.into_iter().filter(|x| region.distance(*x) <= 1e-12 * half.max_element()));
    }
    // A region may lie within a triangle or within the body.
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let around = axes.into_iter().flat_map(|axis| [axis, -axis]).map(|axis| middle + WITHIN * half * axis);
    for place in std::iter::once(middle).chain(around) {
        let nearest = surface.nearest(place).map(|nearest| nearest.position);
        points.extend(nearest.filter(|x| region.distance(*x) == 0.0));
        if surface.contains(place) {
            points.push(place);
        }
    }
    points
}

/// The part of a triangle in a box: its corners in order (Sutherland and Hodgman 1974).
fn clipped(corners: [DVec3; 3], low: DVec3, high: DVec3) -> Vec<DVec3> {
    let mut part = corners.to_vec();
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let bound = if side > 0.0 { low[axis] } else { -high[axis] };
        let depth = |x: DVec3| side * x[axis] - bound;
        let mut kept = Vec::with_capacity(part.len() + 1);
        for (k, to) in part.iter().enumerate() {
            let from = part[(k + part.len() - 1) % part.len()];
            let (a, b) = (depth(from), depth(*to));
            if (a < 0.0) != (b < 0.0) {
                let mut crossing = from.lerp(*to, a / (a - b));
                crossing[axis] = side * bound;
                kept.push(crossing);
            }
            if b >= 0.0 {
                kept.push(*to);
            }
        }
        part = kept;
    }
    part
}

/// Distance of a region from the surface \[m\]: at a local minimum from its middle.
fn distance(surface: &MeshSurface, region: &SupportRegion) -> f64 {
    let (mut from, _) = region.bounds();
    let mut distance = f64::INFINITY;
    // Between the region and the surface to and fro, towards the nearest pair.
    for _ in 0..20 {
        let Some(nearest) = surface.nearest(from) else { break };
        distance = distance.min(region.distance(nearest.position));
        from = match *region {
            SupportRegion::Box { low, high } => nearest.position.clamp(low, high),
            SupportRegion::Ball { centre, radius } => {
                centre + (nearest.position - centre).clamp_length_max(radius)
            }
        };
    }
    distance
}
