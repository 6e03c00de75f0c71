//! Sharp inner edges where two walls meet, as at the bottom of a box.
//!
//! An edge is an inner one if each of its triangles lies in front of the other's plane. Both walls must go on
//! for some of their thickness: the foot of a bowl or a step in a face is not a wall. Of a compact body less
//! is enough: its stress is singular at every such edge. Fillets of many small turns do not count.

use std::collections::HashMap;

use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::disjoint_sets::DisjointSets;
use glam::DVec3;

use crate::mesh::tetrahedra::isosurface_stuffing::wall_quantile;

/// Cosine of the least turn of a sharp edge: 30°.
const SHARP: f64 = 0.866;

/// Least length of a wall across the edge, in its thickness: of bodies that are thin or compact; and the
/// largest distance of its end from the surface that counts as on it, in that length.
const WALL: f64 = 2.0;
const COMPACT_WALL: f64 = 0.2;
const ON_SURFACE: f64 = 0.25;

/// Thickness in the longest extent below which a body is thin.
const THIN: f64 = 0.1;

/// Length of sharp inner edges from which on they matter: in typical walls of a thin body; of a compact body
/// less, by its walls across an edge.
const CREASED: f64 = 2.0;

/// The walls of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Walls {
    /// Thickness that half of the area exceeds \[m\].
    pub(crate) thickness: f64,
    /// Whether the body is thin.
    pub(crate) thin: bool,
    /// Whether they meet at sharp inner edges.
    pub(crate) creased: bool,
}

impl Walls {
    pub(crate) fn of(mesh: &TriMesh) -> Self {
        let tree = SurfaceTree::new(mesh);
        let thickness = wall_quantile(mesh, &tree, 0.5);
        let (low, high) = mesh.bounds();
        let thin = thickness < THIN * (high - low).max_element();
        let wall = if thin { WALL } else { COMPACT_WALL } * thickness;
        Walls { thickness, thin, creased: inner_creases(mesh, &tree, wall) >= CREASED * wall / WALL }
    }
}

/// Whether a body has sharp inner edges that its modes depend on.
pub(crate) fn has_inner_edges(mesh: &TriMesh) -> bool {
    inner_edges(mesh).next().is_some() && {
        let walls = Walls::of(mesh);
        walls.creased || !singular_edges(mesh, &walls).is_empty()
    }
}

/// The triangles at both sides of every sharp inner edge, and its ends in the direction of the first.
fn inner_edges(mesh: &TriMesh) -> impl Iterator<Item = ([usize; 2], [DVec3; 2])> {
    let mut sides: HashMap<[u32; 2], usize> = HashMap::with_capacity(3 * mesh.triangles.len());
    for (t, corners) in mesh.triangles.iter().enumerate() {
        (0..3).for_each(|k| {
            sides.insert([corners[k], corners[(k + 1) % 3]], t);
        });
    }
    let normal = |t: usize| mesh.area_vector(t).normalize_or(DVec3::ZERO);
    (0..mesh.triangles.len()).flat_map(|t| (0..3).map(move |k| (t, k))).filter_map(move |(t, k)| {
        let [a, b] = [mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]];
        let other = *sides.get(&[b, a]).filter(|_| a < b)?;
        let inner = (mesh.centroid(other) - mesh.centroid(t)).dot(normal(t)) > 0.0;
        let is_sharp = inner && normal(t).dot(normal(other)) < SHARP;
        is_sharp.then(|| ([t, other], [a, b].map(|v| mesh.vertices[v as usize])))
    })
}

/// Ends of the sharp inner edges at which stress is singular: all but those between faces that are short
/// against the walls, and, where walls meet, those along which they do, which are long.
pub(crate) fn singular_edges(mesh: &TriMesh, walls: &Walls) -> Vec<[DVec3; 2]> {
    if inner_edges(mesh).next().is_none() {
        return Vec::new();
    }
    let edges = inner_edges_of_walls(mesh, walls);
    match (walls.creased, walls.thin) {
        (false, _) => edges,
        (true, true) => short_chains(&edges, CREASED * walls.thickness),
        // All edges of such a body count as those where walls meet.
        (true, false) => Vec::new(),
    }
}

/// Ends of the sharp inner edges but those between faces that are short against the walls.
pub(crate) fn inner_edges_of_walls(mesh: &TriMesh, walls: &Walls) -> Vec<[DVec3; 2]> {
    edges_of_walls(mesh, &SurfaceTree::new(mesh), COMPACT_WALL * walls.thickness)
}

/// The edges that hang together with others up to less than a length \[m\].
fn short_chains(edges: &[[DVec3; 2]], length: f64) -> Vec<[DVec3; 2]> {
    let mut chains = DisjointSets::new(edges.len());
    let mut at: HashMap<[u64; 3], usize> = HashMap::with_capacity(2 * edges.len());
    for (edge, ends) in edges.iter().enumerate() {
        for end in ends {
            let other = *at.entry(end.to_array().map(f64::to_bits)).or_insert(edge);
            chains.join(edge, other);
        }
    }
    let roots: Vec<usize> = (0..edges.len()).map(|edge| chains.root(edge)).collect();
    let mut lengths = vec![0.0; edges.len()];
    edges.iter().zip(&roots).for_each(|([a, b], root)| lengths[*root] += a.distance(*b));
    let short = edges.iter().zip(&roots).filter(|(_, root)| lengths[**root] < length);
    short.map(|(ends, _)| *ends).collect()
}

/// Length of all sharp inner edges between walls that go on for a length \[m\].
fn inner_creases(mesh: &TriMesh, tree: &SurfaceTree, wall: f64) -> f64 {
    edges_of_walls(mesh, tree, wall).into_iter().map(|[a, b]| a.distance(b)).sum()
}

/// Ends of all sharp inner edges between walls that go on for a length \[m\].
fn edges_of_walls(mesh: &TriMesh, tree: &SurfaceTree, wall: f64) -> Vec<[DVec3; 2]> {
    let normal = |t: usize| mesh.area_vector(t).normalize_or(DVec3::ZERO);
    // Whether a triangle is part of a wall that goes on across its side from a to b.
    let goes_on = |t: usize, a: DVec3, b: DVec3| {
        let across = normal(t).cross(b - a).normalize_or_zero();
        let end = 0.5 * (a + b) + wall * across;
        tree.nearest(mesh, end).is_some_and(|n| n.position.distance(end) < ON_SURFACE * wall)
    };
    let meet =
        inner_edges(mesh).filter(|([t, other], [a, b])| goes_on(*t, *a, *b) && goes_on(*other, *b, *a));
    meet.map(|(_, ends)| ends).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clangor_core::shape::Shape;

    #[test]
    fn convex_and_smooth_bodies_have_none() {
        for shape in ["box:0.1x0.2x0.05", "torus:0.03x0.01@0.001", "sphere:0.1@0.01"] {
            let mesh = Shape::parse(shape).expect("a shape").mesh();
            assert_eq!(inner_creases(&mesh, &SurfaceTree::new(&mesh), 0.02), 0.0, "{shape}");
        }
    }

    /// Three edges in a row, of which two are joined, and one alone.
    #[test]
    fn edges_that_hang_together_are_one_long_edge() {
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        let edges = [[at(0.0), at(1.0)], [at(5.0), at(6.0)], [at(2.0), at(1.0)]];
        assert_eq!(short_chains(&edges, 1.5), [edges[1]]);
        assert_eq!(short_chains(&edges, 3.0), edges);
    }

    #[test]
    fn a_notched_block_has_one() {
        // An L of unit depth: six corners, of which the fourth is an inner one.
        let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let level = |z: f64| outline.map(|[x, y]| DVec3::new(x, y, z));
        let mut mesh = TriMesh { vertices: [level(0.0), level(1.0)].concat(), triangles: Vec::new() };
        for [a, b, c] in [[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]] {
            mesh.triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
        }
        for k in 0..6 {
            let n = (k + 1) % 6;
            mesh.triangles.extend([[k, n, n + 6], [k, n + 6, k + 6]]);
        }
        let tree = SurfaceTree::new(&mesh);
        assert!((inner_creases(&mesh, &tree, 0.8) - 1.0).abs() < 1e-15);
        // Not if its walls are thought to be thicker than they are long.
        assert_eq!(inner_creases(&mesh, &tree, 3.0), 0.0);
    }
}
