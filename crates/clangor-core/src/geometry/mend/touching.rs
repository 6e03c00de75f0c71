//! Shells that share edges, as two boxes on each other do after their vertices were merged: each gets
//! vertices of its own.
//!
//! Files hold one part after the other as a rule: a part ends where all edges of the triangles so far have
//! triangles on both sides. Where that is not so, parts are found around each edge with four triangles or
//! more. Material begins at triangles that run along it in one sense, and ends at those that run in the
//! other. A triangle at which it ends belongs to the last one before at which it begins. Where material ends
//! and begins in one place, it ends first: the parts touch.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::super::mesh_error::MeshError;
use super::super::topology::Topology;
use super::super::tri_mesh::TriMesh;
use super::Repair;
use super::edges::{Side, Sides, angles};
use crate::math::disjoint_sets::DisjointSets;

/// Largest angle between triangles that lie on each other \[rad\].
const SAME_ANGLE: f64 = 1e-6;

/// Gives shells that share edges vertices of their own; what was wrong, if that could be done.
pub(super) fn separate(work: &mut Repair) -> Option<MeshError> {
    let error = Topology::try_new(&work.mesh).err()?;
    if let MeshError::NonManifold { .. } = error {
        let apart = in_runs(&work.mesh);
        work.mesh = separated(&apart).or_else(|| separated(&work.mesh))?;
        return Some(error);
    }
    None
}

/// The mesh with vertices of its own for each run of triangles that bounds something.
fn in_runs(mesh: &TriMesh) -> TriMesh {
    let mut open: HashMap<[u32; 2], i64> = HashMap::new();
    let mut places: HashMap<u32, u32> = HashMap::new();
    let mut apart = TriMesh::default();
    for corners in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let edge = [a.min(b), a.max(b)];
            let sense = open.entry(edge).or_insert(0);
            *sense += if a < b { 1 } else { -1 };
            if *sense == 0 {
                open.remove(&edge);
            }
        }
        apart.triangles.push(corners.map(|v| {
            *places.entry(v).or_insert_with(|| {
                apart.vertices.push(mesh.vertices[v as usize]);
                apart.vertices.len() as u32 - 1
            })
        }));
        if open.is_empty() {
            places.clear();
        }
    }
    apart
}

/// The mesh with shells that share no edge; `None` where triangles around an edge do not bound parts.
fn separated(mesh: &TriMesh) -> Option<TriMesh> {
    let mut groups = DisjointSets::new(3 * mesh.triangles.len());
    for edge in Sides::new(mesh).edges() {
        for [a, b] in pairs(mesh, edge)? {
            for end in [a.low, a.high] {
                let [a, b] = [a, b].map(|side| corner(mesh, side, end));
                groups.join(a, b);
            }
        }
    }
    let mut places = vec![u32::MAX; groups.count()];
    let mut vertices = Vec::new();
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    for (t, corners) in mesh.triangles.iter().enumerate() {
        triangles.push([0, 1, 2].map(|k| {
            let root = groups.root(3 * t + k);
            if places[root] == u32::MAX {
                places[root] = vertices.len() as u32;
                vertices.push(mesh.vertices[corners[k] as usize]);
            }
            places[root]
        }));
    }
    let separated = TriMesh { vertices, triangles };
    let (_, shell) = Topology::try_new(&separated).ok()?.components();
    faces_are_of_two_shells(mesh, &shell).then_some(separated)
}

/// Whether triangles of the same corners face each other, and belong to different shells: two parts touch
/// there. Others are double, or both sides of a sheet.
fn faces_are_of_two_shells(mesh: &TriMesh, shell: &[u32]) -> bool {
    let mut seen: HashMap<[u32; 3], usize> = HashMap::with_capacity(mesh.triangles.len());
    mesh.triangles.iter().enumerate().all(|(t, [a, b, c])| {
        let least = *a.min(b).min(c);
        let from_least = [[*a, *b, *c], [*b, *c, *a], [*c, *a, *b]].into_iter().find(|own| own[0] == least);
        let Some(own @ [first, second, third]) = from_least else { return false };
        let opposite = seen.get(&[first, third, second]);
        opposite.is_none_or(|other| shell[*other] != shell[t]) && seen.insert(own, t).is_none()
    })
}

/// The sides at an edge, in pairs that bound a part; `None` if some have no other.
fn pairs(mesh: &TriMesh, edge: &[Side]) -> Option<Vec<[Side; 2]>> {
    if let [a, b] = edge {
        return Some(vec![[*a, *b]]);
    }
    let angles = angles(mesh, edge);
    let angle = |k: usize| if angles[k] > TAU - SAME_ANGLE { angles[k] - TAU } else { angles[k] };
    // Material lies at smaller angles than a side that ascends, and at larger ones than one that descends.
    let place = |(k, side): (usize, &Side)| angle(k) - if side.ascending { SAME_ANGLE } else { 0.0 };
    let mut around: Vec<(f64, Side)> = edge.iter().enumerate().map(|own| (place(own), *own.1)).collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Begin where least material is.
    let (mut depth, mut least, mut start) = (0_i64, 0_i64, 0);
    for (k, (_, side)) in around.iter().enumerate() {
        depth += if side.ascending { -1 } else { 1 };
        if depth < least {
            (least, start) = (depth, k + 1);
        }
    }
    if depth != 0 {
        return None;
    }
    around.rotate_left(start);
    let (mut open, mut found) = (Vec::new(), Vec::new());
    for (_, side) in around {
        if side.ascending { found.push([open.pop()?, side]) } else { open.push(side) }
    }
    Some(found)
}

/// The corner of a side at one end of its edge, numbered over all triangles.
fn corner(mesh: &TriMesh, side: Side, end: u32) -> usize {
    let corners = mesh.triangles[side.triangle as usize];
    let slot = (0..3).find(|k| corners[*k] == end).unwrap_or(0);
    3 * side.triangle as usize + slot
}
