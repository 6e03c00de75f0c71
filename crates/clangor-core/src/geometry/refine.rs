//! Smaller triangles on the same surface, by bisection of longest edges.
//!
//! The polyhedron stays exactly what it was: new vertices are midpoints of edges. Rivara (1984), "Algorithms
//! for refining triangular grids suitable for adaptive and multigrid techniques": the smallest angle never
//! falls below half of the smallest of the start.

use std::collections::HashMap;

use glam::DVec3;

use super::tri_mesh::TriMesh;

/// Splits edges until none is longer than `edge` \[m\].
pub fn refine_to_edge(mesh: &TriMesh, edge: f64) -> TriMesh {
    let mut mesh = mesh.clone();
    loop {
        let mut midpoints: HashMap<(u32, u32), u32> = HashMap::new();
        let mut marked: Vec<usize> =
            (0..mesh.triangles.len()).filter(|t| longest_edge(&mesh, *t).1 > edge).collect();
        if marked.is_empty() {
            return mesh;
        }
        // A triangle with any split edge splits its longest edge too, so that marks spread until nothing
        // changes.
        while !marked.is_empty() {
            for t in marked.drain(..) {
                let key = side(&mesh, t, longest_edge(&mesh, t).0);
                let vertices = &mut mesh.vertices;
                midpoints.entry(key).or_insert_with(|| {
                    vertices.push(0.5 * (vertices[key.0 as usize] + vertices[key.1 as usize]));
                    (vertices.len() - 1) as u32
                });
            }
            marked.extend((0..mesh.triangles.len()).filter(|t| {
                (0..3).any(|k| midpoints.contains_key(&side(&mesh, *t, k)))
                    && !midpoints.contains_key(&side(&mesh, *t, longest_edge(&mesh, *t).0))
            }));
        }
        let mut triangles = Vec::with_capacity(2 * mesh.triangles.len());
        for t in 0..mesh.triangles.len() {
            let first = longest_edge(&mesh, t).0;
            let corners = [0, 1, 2].map(|k| mesh.triangles[t][(first + k) % 3]);
            let middle = [0, 1, 2].map(|k| midpoints.get(&side(&mesh, t, (first + k) % 3)).copied());
            let [a, b, c] = corners;
            match middle {
                [None, ..] => triangles.push([a, b, c]),
                [Some(m), right, left] => {
                    match right {
                        Some(r) => triangles.extend([[m, b, r], [m, r, c]]),
                        None => triangles.push([m, b, c]),
                    }
                    match left {
                        Some(l) => triangles.extend([[m, c, l], [m, l, a]]),
                        None => triangles.push([m, c, a]),
                    }
                }
            }
        }
        mesh.triangles = triangles;
    }
}

/// The edge from corner k to corner k+1, as its two vertices in order of index.
fn side(mesh: &TriMesh, triangle: usize, k: usize) -> (u32, u32) {
    let (a, b) = (mesh.triangles[triangle][k], mesh.triangles[triangle][(k + 1) % 3]);
    (a.min(b), a.max(b))
}

/// Number and length \[m\] of the longest edge. Ties go by vertex number, so that two neighbours agree on
/// them.
fn longest_edge(mesh: &TriMesh, triangle: usize) -> (usize, f64) {
    let length = |k: usize| {
        let (a, b) = side(mesh, triangle, k);
        let ends: [DVec3; 2] = [mesh.vertices[a as usize], mesh.vertices[b as usize]];
        ends[0].distance(ends[1])
    };
    let longer = |i: usize, j: usize| {
        let (li, lj) = (length(i), length(j));
        if li > lj || (li == lj && side(mesh, triangle, i) > side(mesh, triangle, j)) { i } else { j }
    };
    let k = longer(longer(0, 1), 2);
    (k, length(k))
}
