//! Triangles close to equilateral, of a given size, on a given surface.
//!
//! Source: Botsch and Kobbelt (2004), "A remeshing approach to multiresolution modeling": split edges longer
//! than 4/3 of the target, collapse those shorter than 4/5, flip edges towards six neighbours per vertex,
//! move vertices towards the centroid of their surroundings within the tangent plane, and back onto the
//! surface.
//!
//! Differs: sharp edges are separate curves. Collapses process the shortest edges first, in passes until no
//! edge is short, because inputs are many times finer than the target.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::crease::{Anchor, Creases};
use super::editable_mesh::EditableMesh;
use super::guide::Guide;

/// Rounds of split, collapse, flip and smooth.
const ROUNDS: usize = 8;
/// Passes of collapses in the first round, which reduces a fine input to the target, and in the others.
const FIRST_COLLAPSES: usize = 12;
const COLLAPSES: usize = 2;
/// Fraction of the way to the centroid that a vertex moves.
const SMOOTHING: f64 = 0.8;
/// The same along a sharp edge.
const SMOOTHING_ALONG: f64 = 0.5;
/// Smallest cosine between the normals of a triangle before and after one of its vertices moves.
const MOVE_COSINE: f64 = 0.3;

/// Remeshes `input`, whose vertices have the target edge lengths `size`.
pub(super) fn remesh_isotropic(
    input: &TriMesh,
    creases: &Creases,
    size: &[f64],
    guide: &Guide,
) -> (TriMesh, Vec<Anchor>) {
    let mut mesh = EditableMesh::new(input, creases, size.to_vec());
    for round in 0..ROUNDS {
        for (a, b) in mesh.edges() {
            if mesh.relative_length(a, b) > 4.0 / 3.0 && mesh.joined(a, b) {
                mesh.split(a, b);
            }
        }
        let passes = if round == 0 { FIRST_COLLAPSES } else { COLLAPSES };
        for _ in 0..passes {
            if !collapse_short_edges(&mut mesh, guide) {
                break;
            }
        }
        for (a, b) in mesh.edges() {
            if mesh.joined(a, b) {
                mesh.flip(a, b);
            }
        }
        smooth(&mut mesh, guide);
    }
    mesh.finish()
}

/// One pass over the edges shorter than 4/5 of their target; whether anything changed.
fn collapse_short_edges(mesh: &mut EditableMesh, guide: &Guide) -> bool {
    let with_length = |(a, b): (u32, u32)| (mesh.relative_length(a, b), a, b);
    let mut short: Vec<(f64, u32, u32)> =
        mesh.edges().into_iter().map(with_length).filter(|(length, ..)| *length < 0.8).collect();
    short.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut merged = Vec::new();
    for (_, a, b) in short {
        let gone = mesh.around[a as usize].is_empty() || mesh.around[b as usize].is_empty();
        if !gone && mesh.relative_length(a, b) < 0.8 {
            merged.extend(mesh.collapse(a, b));
        }
    }
    merged.sort_unstable();
    merged.dedup();
    // Midpoints of edges lie inside a convex surface: without projection, many passes would shrink it.
    for v in &merged {
        if mesh.anchor[*v as usize] == Anchor::Surface && !mesh.around[*v as usize].is_empty() {
            let normal = surroundings(mesh, &mesh.position, *v).normal;
            settle(mesh, &mesh.position.clone(), guide, *v, mesh.position[*v as usize], normal);
        }
    }
    !merged.is_empty()
}

/// Moves every vertex towards the middle of its surroundings, and back onto the surface.
fn smooth(mesh: &mut EditableMesh, guide: &Guide) {
    let before = mesh.position.clone();
    for v in 0..mesh.position.len() {
        if mesh.around[v].is_empty() {
            continue;
        }
        match mesh.anchor[v] {
            Anchor::Surface => {
                let Surroundings { centroid, normal } = surroundings(mesh, &before, v as u32);
                let way = centroid - before[v];
                let target = before[v] + SMOOTHING * way.reject_from_normalized(normal);
                settle(mesh, &before, guide, v as u32, target, normal);
            }
            Anchor::Curve(curve, s) => {
                let ends = mesh.along(v as u32, curve);
                let ways = ends.iter().map(|e| {
                    mesh.creases.way_to(curve, s, mesh.anchor[*e as usize], mesh.position[*e as usize])
                });
                let step = SMOOTHING_ALONG * ways.sum::<f64>() / ends.len().max(1) as f64;
                let (anchor, position) = mesh.creases.moved(curve, s, step);
                if place(mesh, &before, v as u32, position) {
                    mesh.anchor[v] = anchor;
                }
            }
            Anchor::Corner => {}
        }
    }
}

/// Centroid and unit normal of the triangles around a vertex, weighted by area in units of the target size.
struct Surroundings {
    centroid: DVec3,
    normal: DVec3,
}

fn surroundings(mesh: &EditableMesh, position: &[DVec3], v: u32) -> Surroundings {
    let (mut centroid, mut weight, mut normal) = (DVec3::ZERO, 0.0, DVec3::ZERO);
    for t in &mesh.around[v as usize] {
        let corners = mesh.triangles[*t as usize].map(|c| c as usize);
        let [a, b, c] = corners.map(|c| position[c]);
        let area_vector = (b - a).cross(c - a);
        let size: f64 = corners.iter().map(|c| mesh.size[*c]).sum();
        let area = area_vector.length() / (size * size);
        centroid += area * (a + b + c) / 3.0;
        weight += area;
        normal += area_vector;
    }
    Surroundings { centroid: centroid / weight, normal: normal.normalize_or_zero() }
}

/// Projects a vertex onto the surface near `target` and assigns the target size there.
fn settle(mesh: &mut EditableMesh, before: &[DVec3], guide: &Guide, v: u32, target: DVec3, normal: DVec3) {
    let reach = 4.0 * mesh.size[v as usize];
    if let Some(nearest) = guide.nearest(target, normal, reach)
        && place(mesh, before, v, nearest.position)
    {
        mesh.size[v as usize] = guide.size_at(&nearest);
    }
}

/// Moves a vertex unless that inverts a triangle; returns whether it moved.
fn place(mesh: &mut EditableMesh, before: &[DVec3], v: u32, position: DVec3) -> bool {
    let kept = std::mem::replace(&mut mesh.position[v as usize], position);
    let upright = mesh.around[v as usize].iter().all(|t| {
        let corners = mesh.triangles[*t as usize];
        let [a, b, c] = corners.map(|c| before[c as usize]);
        let old = (b - a).cross(c - a);
        let new = mesh.normal(corners);
        old.dot(new) >= MOVE_COSINE * old.length() * new.length()
    });
    if !upright {
        mesh.position[v as usize] = kept;
    }
    upright
}
