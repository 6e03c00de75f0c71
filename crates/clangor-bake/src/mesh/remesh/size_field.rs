//! Target edge length at each vertex of a surface.
//!
//! `h = clamp(0.6/κ, h_min, h_max)`, then graded: h grows by at most 0.4 of the distance. κ is the largest
//! turn of the smoothed normal per length along an edge. On a sharp edge h is h_min: the potential there
//! varies like r^{2/3} or worse, and the two faces of a thin wall interact across its rim.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use clangor_core::geometry::curvature::vertex_normals;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{BVec3, DVec3};

use super::crease::Creases;

/// Edges per radius of curvature: 0.6 makes ten edges of a full circle.
const CURVATURE_SHARE: f64 = 0.6;
/// Largest growth of h per length.
const GRADATION: f64 = 0.4;
/// Passes that average normals over neighbours, to suppress the noise of fine meshes.
const SMOOTHING_PASSES: usize = 3;

/// h at each vertex \[m\], for a surface that is cut at the coordinate planes that are `mirrors`.
pub(super) fn size_field(
    mesh: &TriMesh,
    creases: &Creases,
    mirrors: BVec3,
    min_edge: f64,
    max_edge: f64,
) -> Vec<f64> {
    let curvature = curvature(mesh, creases, mirrors);
    let wanted = |v: usize| CURVATURE_SHARE / curvature[v];
    let mut size: Vec<f64> =
        (0..mesh.vertices.len()).map(|v| wanted(v).max(min_edge).min(max_edge)).collect();
    grade(mesh, &edges(mesh), &mut size);
    size
}

/// Largest turn of the smoothed normal per length at each vertex [1/m]; infinite on sharp edges.
pub(super) fn curvature(mesh: &TriMesh, creases: &Creases, mirrors: BVec3) -> Vec<f64> {
    let edges = edges(mesh);
    let sharp: Vec<bool> = creases.anchors.iter().map(|a| creases.is_sharp(*a)).collect();
    // Normals are undefined on a sharp edge: neither smoothing nor curvature crosses it.
    let smooth: Vec<(usize, usize)> =
        edges.iter().copied().filter(|(a, b)| !sharp[*a] && !sharp[*b]).collect();
    let mut normals = vertex_normals(mesh);
    // With its mirror image, a normal at a border lies in the plane.
    for (normal, position) in normals.iter_mut().zip(&mesh.vertices) {
        *normal =
            DVec3::select(mirrors & position.cmpeq(DVec3::ZERO), DVec3::ZERO, *normal).normalize_or_zero();
    }
    for _ in 0..SMOOTHING_PASSES {
        let before = normals.clone();
        for (a, b) in &smooth {
            normals[*a] += 0.5 * before[*b];
            normals[*b] += 0.5 * before[*a];
        }
        normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    }
    let mut curvature: Vec<f64> = sharp.iter().map(|s| if *s { f64::INFINITY } else { 0.0 }).collect();
    for (a, b) in &smooth {
        let turn = normals[*a].distance(normals[*b]) / mesh.vertices[*a].distance(mesh.vertices[*b]);
        curvature[*a] = curvature[*a].max(turn);
        curvature[*b] = curvature[*b].max(turn);
    }
    curvature
}

/// Lowers sizes until none exceeds another by more than the gradation times their distance: shortest paths
/// from all vertices at once, each starting at its own size.
fn grade(mesh: &TriMesh, edges: &[(usize, usize)], size: &mut [f64]) {
    // Adjacency in compressed rows.
    let mut start = vec![0_usize; size.len() + 1];
    for (a, b) in edges {
        start[*a + 1] += 1;
        start[*b + 1] += 1;
    }
    for v in 0..size.len() {
        start[v + 1] += start[v];
    }
    let mut place = start.clone();
    let mut neighbours = vec![0; 2 * edges.len()];
    for (a, b) in edges {
        for (v, far) in [(*a, *b), (*b, *a)] {
            neighbours[place[v]] = far;
            place[v] += 1;
        }
    }
    // Dijkstra's algorithm. Positive numbers sort like their bits.
    let mut heap: BinaryHeap<Reverse<(u64, usize)>> =
        size.iter().enumerate().map(|(v, h)| Reverse((h.to_bits(), v))).collect();
    while let Some(Reverse((bits, v))) = heap.pop() {
        let h = f64::from_bits(bits);
        if h > size[v] {
            continue;
        }
        for far in &neighbours[start[v]..start[v + 1]] {
            let reach = h + GRADATION * mesh.vertices[v].distance(mesh.vertices[*far]);
            if reach < size[*far] {
                size[*far] = reach;
                heap.push(Reverse((reach.to_bits(), *far)));
            }
        }
    }
}

/// Every edge once, lower vertex first, in order.
fn edges(mesh: &TriMesh) -> Vec<(usize, usize)> {
    let sides = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    let ordered = |(a, b): (u32, u32)| (a.min(b) as usize, a.max(b) as usize);
    let mut all: Vec<_> = mesh.triangles.iter().flat_map(sides).map(ordered).collect();
    all.sort_unstable();
    all.dedup();
    all
}
