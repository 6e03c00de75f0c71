//! A triangle mesh that supports splitting, collapsing and flipping of edges, and stays a manifold of the
//! same topology.
//!
//! Every operation validates before it changes anything: the link condition preserves handles and holes (Dey,
//! Edelsbrunner, Guha, Nekhayev 1999), normals may not invert, and sharp edges keep their position.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::crease::{Anchor, Creases, SMOOTH};

/// Longest edge that a collapse may create, in target lengths: longer ones would be split again.
const LONGEST_AFTER_COLLAPSE: f64 = 1.4;
/// Smallest cosine between the normals of a triangle before and after a collapse.
const COLLAPSE_COSINE: f64 = 0.5;
/// Smallest cosine between the normals around a flipped edge.
const FLIP_COSINE: f64 = 0.8;

/// Roundness below which a triangle counts as a sliver: about 15°.
const SLIVER: f64 = 0.25;

/// The mesh.
pub(super) struct EditableMesh<'a> {
    pub(super) creases: &'a Creases,
    pub(super) position: Vec<DVec3>,
    pub(super) anchor: Vec<Anchor>,
    /// Target edge length at each vertex \[m\].
    pub(super) size: Vec<f64>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Curve of each side of each triangle.
    sides: Vec<[u32; 3]>,
    alive: Vec<bool>,
    /// Triangles around each vertex; empty for a removed vertex.
    pub(super) around: Vec<Vec<u32>>,
}

impl<'a> EditableMesh<'a> {
    pub(super) fn new(mesh: &TriMesh, creases: &'a Creases, size: Vec<f64>) -> Self {
        let mut around = vec![Vec::new(); mesh.vertices.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            corners.iter().for_each(|v| around[*v as usize].push(t as u32));
        }
        EditableMesh {
            creases,
            position: mesh.vertices.clone(),
            anchor: creases.anchors.clone(),
            size,
            triangles: mesh.triangles.clone(),
            sides: creases.sides.clone(),
            alive: vec![true; mesh.triangles.len()],
            around,
        }
    }

    /// The mesh without removed elements, and the constraint of each of its vertices.
    pub(super) fn finish(&self) -> (TriMesh, Vec<Anchor>) {
        let mut number = vec![u32::MAX; self.position.len()];
        let mut mesh = TriMesh::default();
        let mut anchors = Vec::new();
        for (t, corners) in self.triangles.iter().enumerate().filter(|(t, _)| self.alive[*t]) {
            let _ = t;
            mesh.triangles.push(corners.map(|v| {
                let v = v as usize;
                if number[v] == u32::MAX {
                    number[v] = mesh.vertices.len() as u32;
                    mesh.vertices.push(self.position[v]);
                    anchors.push(self.anchor[v]);
                }
                number[v]
            }));
        }
        (mesh, anchors)
    }

    /// Edges, each once.
    pub(super) fn edges(&self) -> Vec<(u32, u32)> {
        let mut edges = Vec::with_capacity(3 * self.triangles.len() / 2);
        for (t, corners) in self.triangles.iter().enumerate().filter(|(t, _)| self.alive[*t]) {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                if a < b || (self.sides[t][k] != SMOOTH && self.shared(a, b).count() == 1) {
                    edges.push((a, b));
                }
            }
        }
        edges
    }

    /// Whether two vertices are still joined by an edge.
    pub(super) fn joined(&self, a: u32, b: u32) -> bool {
        self.shared(a, b).next().is_some()
    }

    /// Length of an edge in target lengths.
    pub(super) fn relative_length(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (a as usize, b as usize);
        self.position[a].distance(self.position[b]) / (0.5 * (self.size[a] + self.size[b]))
    }

    /// Twice the area vector of three vertices.
    pub(super) fn normal(&self, corners: [u32; 3]) -> DVec3 {
        let [a, b, c] = corners.map(|v| self.position[v as usize]);
        (b - a).cross(c - a)
    }

    /// Twice the area over the square of the longest side: √3/2 for an equilateral triangle, 0 for a sliver.
    fn roundness(&self, corners: [u32; 3]) -> f64 {
        roundness(corners.map(|v| self.position[v as usize]))
    }

    /// Triangles at an edge.
    fn shared(&self, a: u32, b: u32) -> impl Iterator<Item = u32> {
        self.around[a as usize].iter().copied().filter(move |t| self.triangles[*t as usize].contains(&b))
    }

    /// Neighbours of a vertex, in order of number.
    fn ring(&self, v: u32) -> Vec<u32> {
        let corners = self.around[v as usize].iter().flat_map(|t| self.triangles[*t as usize]);
        let mut ring: Vec<u32> = corners.filter(|c| *c != v).collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    /// Curve along an edge, or [`SMOOTH`].
    fn curve(&self, a: u32, b: u32) -> u32 {
        self.shared(a, b).next().map_or(SMOOTH, |t| self.sides[t as usize][self.side(t, a, b)])
    }

    /// Which side of a triangle joins two of its corners.
    fn side(&self, t: u32, a: u32, b: u32) -> usize {
        let corners = self.triangles[t as usize];
        (0..3).find(|k| ![a, b].contains(&corners[(k + 2) % 3])).unwrap_or(0)
    }

    /// The corner of a triangle that is neither of two others.
    fn opposite(&self, t: u32, a: u32, b: u32) -> u32 {
        self.triangles[t as usize][(self.side(t, a, b) + 2) % 3]
    }

    /// The neighbours of a vertex along a curve.
    pub(super) fn along(&self, v: u32, curve: u32) -> Vec<u32> {
        let mut ends = Vec::with_capacity(2);
        for t in &self.around[v as usize] {
            let corners = self.triangles[*t as usize];
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                if self.sides[*t as usize][k] == curve && (a == v || b == v) {
                    ends.push(if a == v { b } else { a });
                }
            }
        }
        ends.sort_unstable();
        ends.dedup();
        ends
    }

    /// Divides an edge in the middle.
    pub(super) fn split(&mut self, a: u32, b: u32) {
        let n = self.position.len() as u32;
        let curve = self.curve(a, b);
        let ends = [a, b].map(|v| (self.anchor[v as usize], self.position[v as usize]));
        // New vertex at the middle of the edge, or of the curve along it.
        let (anchor, position) = match curve {
            SMOOTH => (Anchor::Surface, 0.5 * (ends[0].1 + ends[1].1)),
            _ => self.creases.middle(curve, ends),
        };
        self.position.push(position);
        self.anchor.push(anchor);
        self.size.push(0.5 * (self.size[a as usize] + self.size[b as usize]));
        self.around.push(Vec::new());
        let shared: Vec<u32> = self.shared(a, b).collect();
        // Divide the triangles at the edge.
        for t in shared {
            let (corners, sides) = (self.triangles[t as usize], self.sides[t as usize]);
            let o = self.opposite(t, a, b);
            let (to_a, to_b) = (self.side(t, o, a), self.side(t, o, b));
            let new = self.triangles.len() as u32;
            self.triangles[t as usize] = corners.map(|v| if v == b { n } else { v });
            self.triangles.push(corners.map(|v| if v == a { n } else { v }));
            // The half at a keeps its side to a, the half at b its side to b. The cut between them is smooth.
            self.sides[t as usize][to_b] = SMOOTH;
            self.sides.push(sides);
            self.sides[new as usize][to_a] = SMOOTH;
            self.alive.push(true);
            self.around[b as usize].retain(|x| *x != t);
            self.around[b as usize].push(new);
            self.around[n as usize].extend([t, new]);
            self.around[o as usize].push(new);
        }
    }

    /// Merges two neighbours if topology, orientation and sharp edges permit; returns the remaining vertex.
    pub(super) fn collapse(&mut self, a: u32, b: u32) -> Option<u32> {
        // Link condition: exactly the opposite corners are common neighbours.
        let shared: Vec<u32> = self.shared(a, b).collect();
        let (ring_a, ring_b) = (self.ring(a), self.ring(b));
        let common = ring_a.iter().filter(|v| ring_b.contains(v)).count();
        if shared.is_empty() || common != shared.len() || ring_a.len().min(ring_b.len()) <= shared.len() + 1 {
            return None;
        }
        // Position of the merged vertex, and no two creases merged.
        let (anchor, position) = self.merged(a, b)?;
        if shared.iter().any(|t| {
            let o = self.opposite(*t, a, b);
            self.curve(a, o) != SMOOTH && self.curve(b, o) != SMOOTH
        }) {
            return None;
        }
        let (keep, drop) = (a, b);
        // The remaining triangles keep their orientation and shape, and the edges their length.
        let kept: Vec<u32> = [a, b]
            .iter()
            .flat_map(|v| &self.around[*v as usize])
            .copied()
            .filter(|t| !shared.contains(t))
            .collect();
        let moved = |v: u32| if v == a || v == b { position } else { self.position[v as usize] };
        let upright = kept.iter().all(|t| {
            let corners = self.triangles[*t as usize];
            let before = self.normal(corners);
            let after = corners.map(moved);
            let normal = (after[1] - after[0]).cross(after[2] - after[0]);
            before.dot(normal) > COLLAPSE_COSINE * before.length() * normal.length()
                && roundness(after) > self.roundness(corners).min(SLIVER)
        });
        let size = 0.5 * (self.size[a as usize] + self.size[b as usize]);
        let short = ring_a.iter().chain(&ring_b).filter(|v| **v != a && **v != b).all(|v| {
            let target = 0.5 * (size + self.size[*v as usize]);
            self.position[*v as usize].distance(position) < LONGEST_AFTER_COLLAPSE * target
        });
        if !upright || !short {
            return None;
        }
        // Remove the triangles at the edge; creases pass to the merged sides.
        for t in shared {
            let o = self.opposite(t, a, b);
            let curve = self.curve(keep, o).min(self.curve(drop, o));
            self.alive[t as usize] = false;
            for v in self.triangles[t as usize] {
                self.around[v as usize].retain(|x| *x != t);
            }
            for end in [keep, drop] {
                let rest: Vec<u32> = self.shared(end, o).collect();
                for t in rest {
                    let side = self.side(t, end, o);
                    self.sides[t as usize][side] = curve;
                }
            }
        }
        // Reattach the triangles of the dropped vertex.
        for t in std::mem::take(&mut self.around[drop as usize]) {
            for v in &mut self.triangles[t as usize] {
                if *v == drop {
                    *v = keep;
                }
            }
            self.around[keep as usize].push(t);
        }
        let k = keep as usize;
        (self.position[k], self.anchor[k], self.size[k]) = (position, anchor, size);
        Some(keep)
    }

    /// Constraint and position of two merged neighbours; `None` where sharp edges forbid it.
    fn merged(&self, a: u32, b: u32) -> Option<(Anchor, DVec3)> {
        let ends = [a, b].map(|v| (self.anchor[v as usize], self.position[v as usize]));
        let curve = self.curve(a, b);
        match (ends[0].0, ends[1].0) {
            (Anchor::Surface, Anchor::Surface) => Some((Anchor::Surface, 0.5 * (ends[0].1 + ends[1].1))),
            (Anchor::Surface, _) => Some(ends[1]),
            (_, Anchor::Surface) => Some(ends[0]),
            (Anchor::Corner, Anchor::Corner) => None,
            _ if curve == SMOOTH => None,
            (Anchor::Corner, _) => Some(ends[0]),
            (_, Anchor::Corner) => Some(ends[1]),
            _ => Some(self.creases.middle(curve, ends)),
        }
    }

    /// Flips an edge if that brings the valences closer to six (four at a border).
    pub(super) fn flip(&mut self, a: u32, b: u32) {
        // Two triangles, no crease, and no existing edge between the opposite corners.
        let mut shared = self.shared(a, b);
        let (Some(s), Some(t), None) = (shared.next(), shared.next(), shared.next()) else { return };
        drop(shared);
        let (c, d) = (self.opposite(s, a, b), self.opposite(t, a, b));
        if self.curve(a, b) != SMOOTH || c == d || self.joined(c, d) {
            return;
        }
        // Change of the squared deviation from the ideal valence.
        let excess = |v: u32, change: i64| {
            let border = self.around[v as usize].len() != self.ring(v).len();
            let ideal = if border { 3 } else { 6 };
            (self.around[v as usize].len() as i64 + change - ideal).pow(2)
        };
        let gain: i64 =
            [(a, -1), (b, -1), (c, 1), (d, 1)].map(|(v, n)| excess(v, 0) - excess(v, n)).iter().sum();
        let few = self.around[a as usize].len().min(self.around[b as usize].len()) <= 3;
        let swap =
            |t: u32, from: u32, to: u32| self.triangles[t as usize].map(|v| if v == from { to } else { v });
        let (new_s, new_t) = (swap(s, b, d), swap(t, a, c));
        let flatness = |x: [u32; 3], y: [u32; 3]| self.roundness(x).min(self.roundness(y));
        let (now, then) =
            (flatness(self.triangles[s as usize], self.triangles[t as usize]), flatness(new_s, new_t));
        // A sliver is removed regardless of the valences, and none is created.
        let better = if now < SLIVER { then > now } else { gain > 0 && then > SLIVER };
        if !better || few {
            return;
        }
        // No triangle may tilt too far from its neighbours.
        let old = [s, t].map(|t| self.normal(self.triangles[t as usize]).normalize_or_zero());
        let new = [new_s, new_t].map(|t| self.normal(t).normalize_or_zero());
        let least = new.iter().flat_map(|n| old.iter().map(|o| n.dot(*o))).fold(old[0].dot(old[1]), f64::min);
        if least < FLIP_COSINE {
            return;
        }
        // Replace both triangles and update the adjacency.
        let (side_bc, side_ad) = (self.curve(b, c), self.curve(a, d));
        self.triangles[s as usize] = new_s;
        self.triangles[t as usize] = new_t;
        for (t, end, curve) in [(s, (a, d), side_ad), (t, (b, c), side_bc)] {
            let (outer, inner) = (self.side(t, end.0, end.1), self.side(t, c, d));
            self.sides[t as usize][outer] = curve;
            self.sides[t as usize][inner] = SMOOTH;
        }
        self.around[b as usize].retain(|x| *x != s);
        self.around[a as usize].retain(|x| *x != t);
        self.around[d as usize].push(s);
        self.around[c as usize].push(t);
    }
}

/// Twice the area of a triangle over the square of its longest side.
fn roundness([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).cross(c - a).length() / longest
}
