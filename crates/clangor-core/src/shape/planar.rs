//! Plates cut from a sheet: a flat outline, meshed and given a thickness along y.
//!
//! The plane has coordinates (u, v) with x = u and z = −v, so that counter-clockwise is as seen from above.

use glam::{DVec2, DVec3};

use crate::geometry::convex::ConvexPart;
use crate::geometry::topology::boundary_edges;
use crate::geometry::tri_mesh::TriMesh;
use crate::math::random::SplitMix;
use crate::shape::axisymmetric::lace_pair;

/// Places a point of the plane at height `y` \[m\].
pub(super) fn place(point: DVec2, y: f64) -> DVec3 {
    DVec3::new(point.x, y, -point.y)
}

/// Triangles on a convex polygon about the origin, given counter-clockwise: concentric copies of the outline,
/// laced.
pub(super) fn polygon_mesh(corners: &[DVec2], edge: f64) -> TriMesh {
    let reach = corners.iter().map(|c| c.length()).fold(0.0, f64::max);
    let rings = (reach / edge).ceil().max(1.0) as usize;
    let sides = corners.len();
    let mut mesh = TriMesh::default();
    let mut outer: Option<(Vec<f64>, u32)> = None;
    for ring in (0..=rings).rev() {
        let scale = ring as f64 / rings as f64;
        let start = mesh.vertices.len() as u32;
        let mut turns = Vec::new();
        if ring == 0 {
            turns.push(0.0);
            mesh.vertices.push(DVec3::ZERO);
        } else {
            for side in 0..sides {
                let (from, to) = (corners[side] * scale, corners[(side + 1) % sides] * scale);
                let count = (from.distance(to) / edge).round().max(1.0) as usize;
                for k in 0..count {
                    let part = k as f64 / count as f64;
                    turns.push((side as f64 + part) / sides as f64);
                    mesh.vertices.push(place(from + (to - from) * part, 0.0));
                }
            }
        }
        if let Some((below, below_start)) = &outer {
            lace_pair(&mut mesh, (below, *below_start), (&turns, start));
        }
        outer = Some((turns, start));
    }
    mesh
}

/// Gives a flat mesh that faces up a thickness along y, half of it to each side.
pub(super) fn thicken(flat: &TriMesh, thickness: f64, edge: f64) -> TriMesh {
    let layers = (thickness / edge).ceil().max(1.0) as usize;
    let count = flat.vertices.len() as u32;
    let mut mesh = TriMesh::default();
    let levels = |k: usize| thickness * (0.5 - k as f64 / layers as f64);
    for k in [0, layers] {
        mesh.vertices.extend(flat.vertices.iter().map(|v| *v + DVec3::Y * levels(k)));
    }
    mesh.triangles.extend(&flat.triangles);
    mesh.triangles.extend(flat.triangles.iter().map(|[a, b, c]| [a + count, c + count, b + count]));
    let border = boundary_edges(flat);
    // Middle levels hold the border only.
    let mut column = vec![u32::MAX; flat.vertices.len()];
    for (k, (from, _)) in border.iter().enumerate() {
        column[*from as usize] = k as u32;
    }
    for k in 1..layers {
        mesh.vertices
            .extend(border.iter().map(|(from, _)| flat.vertices[*from as usize] + DVec3::Y * levels(k)));
    }
    let vertex = |v: u32, level: usize| match level {
        0 => v,
        level if level == layers => v + count,
        level => 2 * count + (level as u32 - 1) * border.len() as u32 + column[v as usize],
    };
    for (a, b) in &border {
        for level in 0..layers {
            let [top_a, top_b] = [vertex(*a, level), vertex(*b, level)];
            let [low_a, low_b] = [vertex(*a, level + 1), vertex(*b, level + 1)];
            mesh.triangles.extend([[low_a, low_b, top_b], [low_a, top_b, top_a]]);
        }
    }
    mesh
}

/// The hull of an outline, given a thickness.
pub(super) fn slab(outline: &[DVec2], thickness: f64) -> ConvexPart {
    ConvexPart::Hull(outline.iter().flat_map(|p| [0.5, -0.5].map(|s| place(*p, s * thickness))).collect())
}

/// Corners of a regular polygon.
pub(super) fn regular(sides: u32, radius: f64) -> Vec<DVec2> {
    let corner = |k| DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / f64::from(sides)) * radius;
    (0..sides).map(corner).collect()
}

/// A splinter of a pane: thickness over size.
pub(super) const SHARD_THICKNESS: f64 = 0.08;

/// Outline of a convex splinter with 4 to 7 corners on an ellipse of the given longer axis \[m\].
pub(super) fn shard_outline(seed: u64, size: f64) -> Vec<DVec2> {
    let mut random = SplitMix::new(seed);
    let count = 4 + (random.uniform(0.0, 4.0) as usize).min(3);
    let narrow = random.uniform(0.45, 0.85);
    (0..count)
        .map(|k| {
            let turn = (k as f64 + random.uniform(-0.3, 0.3)) / count as f64;
            DVec2::from_angle(std::f64::consts::TAU * turn) * DVec2::new(0.5, 0.5 * narrow) * size
        })
        .collect()
}
