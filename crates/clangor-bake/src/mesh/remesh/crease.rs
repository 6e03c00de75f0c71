//! Sharp edges of a surface, as curves.
//!
//! A *crease* is an edge whose triangles turn by more than a given angle, or that has a triangle on one side
//! only: the *border* where a surface was cut at a plane of symmetry. Creases chain into curves that end at
//! *corners*: where more or fewer than two creases meet, or where they turn sharply. A vertex on a curve is
//! stored as curve and arc length, so that moving it along the curve keeps it on the sharp edge.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{BVec3, DVec3};

/// Marks a side of a triangle that is no crease.
pub(super) const SMOOTH: u32 = u32::MAX;

/// A curve that turns by more than this within one vertex has a corner there: cos 45°.
const CORNER_COSINE: f64 = 0.707;

/// Constraint of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    /// It moves on the surface.
    Surface,
    /// It moves along a curve; its arc length \[m\].
    Curve(u32, f64),
    /// It does not move.
    Corner,
}

/// A polyline along a sharp edge.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    points: Vec<DVec3>,
    /// Arc length of each point \[m\]. A closed curve repeats its first point at the end.
    arc: Vec<f64>,
    /// Whether it is a loop without a corner.
    closed: bool,
    /// Whether the surface is smooth there and the curve only a border.
    border: bool,
}

impl Curve {
    fn new(points: Vec<DVec3>, closed: bool, border: bool) -> Self {
        let mut arc = vec![0.0];
        for pair in points.windows(2) {
            arc.push(arc.last().copied().unwrap_or(0.0) + pair[0].distance(pair[1]));
        }
        Curve { points, arc, closed, border }
    }

    fn length(&self) -> f64 {
        self.arc.last().copied().unwrap_or(0.0)
    }

    /// An arc length wrapped or clamped to the curve.
    fn confined(&self, s: f64) -> f64 {
        if self.closed { s.rem_euclid(self.length()) } else { s.clamp(0.0, self.length()) }
    }

    /// The point at an arc length.
    pub(super) fn point(&self, s: f64) -> DVec3 {
        let k = self.arc.partition_point(|a| *a <= s).clamp(1, self.arc.len() - 1);
        let (from, to) = (self.arc[k - 1], self.arc[k]);
        self.points[k - 1].lerp(self.points[k], ((s - from) / (to - from)).clamp(0.0, 1.0))
    }

    /// The shortest signed distance along the curve from one arc length to another.
    fn way(&self, from: f64, to: f64) -> f64 {
        let way = to - from;
        if self.closed { way - self.length() * (way / self.length()).round() } else { way }
    }
}

/// The sharp edges of a mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Creases {
    pub(super) curves: Vec<Curve>,
    /// Constraint of each vertex.
    pub(super) anchors: Vec<Anchor>,
    /// Curve of each side of each triangle, or [`SMOOTH`]; side k runs from corner k to corner k + 1.
    pub(super) sides: Vec<[u32; 3]>,
}

impl Creases {
    /// Finds the edges that turn by more than `angle` \[rad\] and form nets of at least `least_length` \[m\],
    /// and the borders on the coordinate planes that are `mirrors`.
    pub(super) fn find(mesh: &TriMesh, angle: f64, least_length: f64, mirrors: BVec3) -> Self {
        // Sharp edges, without noise, and their adjacency.
        let (sharp, border) = prune(mesh, &sharp_edges(mesh, angle, mirrors), least_length);
        let mut around: Vec<Vec<(u32, u32)>> = vec![Vec::new(); mesh.vertices.len()];
        for (edge, [a, b]) in sharp.iter().enumerate() {
            around[*a as usize].push((*b, edge as u32));
            around[*b as usize].push((*a, edge as u32));
        }
        // A corner: not exactly two sharp edges, or a sharp turn between them.
        let corner = |v: u32| match around[v as usize][..] {
            [(a, _), (b, _)] => {
                let [a, v, b] = [a, v, b].map(|i| mesh.vertices[i as usize]);
                (v - a).normalize_or_zero().dot((b - v).normalize_or_zero()) < CORNER_COSINE
            }
            _ => true,
        };
        let mut curve_of = vec![SMOOTH; sharp.len()];
        let mut anchors = vec![Anchor::Surface; mesh.vertices.len()];
        let mut curves = Vec::new();
        // Curves between corners first; the remaining ones are loops.
        for closed in [false, true] {
            for edge in 0..sharp.len() {
                for [start, next] in [sharp[edge], [sharp[edge][1], sharp[edge][0]]] {
                    if curve_of[edge] != SMOOTH || corner(start) == closed {
                        continue;
                    }
                    let id = curves.len() as u32;
                    curve_of[edge] = id;
                    let mut chain = vec![start, next];
                    let mut tip = next;
                    let mut all_border = border[edge];
                    // Follow the crease to the next corner.
                    while !corner(tip) && tip != start {
                        let Some((far, along)) =
                            around[tip as usize].iter().find(|(_, e)| curve_of[*e as usize] == SMOOTH)
                        else {
                            break;
                        };
                        curve_of[*along as usize] = id;
                        all_border &= border[*along as usize];
                        chain.push(*far);
                        tip = *far;
                    }
                    // Store the curve, and its arc lengths at the vertices.
                    let points = chain.iter().map(|v| mesh.vertices[*v as usize]).collect();
                    let curve = Curve::new(points, closed, all_border);
                    for (v, s) in chain.iter().zip(&curve.arc).take(chain.len() - 1) {
                        anchors[*v as usize] = Anchor::Curve(id, *s);
                    }
                    curves.push(curve);
                }
            }
        }
        // Corners keep their position.
        for v in 0..mesh.vertices.len() as u32 {
            if !around[v as usize].is_empty() && corner(v) {
                anchors[v as usize] = Anchor::Corner;
            }
        }
        let curve_between = |a: u32, b: u32| {
            let found = around[a as usize].iter().find(|(far, _)| *far == b);
            found.map_or(SMOOTH, |(_, edge)| curve_of[*edge as usize])
        };
        // Curve of each side of each triangle.
        let sides =
            mesh.triangles.iter().map(|t| [0, 1, 2].map(|k| curve_between(t[k], t[(k + 1) % 3]))).collect();
        Creases { curves, anchors, sides }
    }

    /// Whether the surface is sharp at the constraint of a vertex, and not only cut.
    pub(super) fn is_sharp(&self, anchor: Anchor) -> bool {
        match anchor {
            Anchor::Surface => false,
            Anchor::Curve(curve, _) => !self.curves[curve as usize].border,
            Anchor::Corner => true,
        }
    }

    /// Distance along `curve` from an arc length to a vertex that lies on it or ends it.
    pub(super) fn way_to(&self, curve: u32, from: f64, anchor: Anchor, position: DVec3) -> f64 {
        let line = &self.curves[curve as usize];
        match anchor {
            Anchor::Curve(id, s) if id == curve => line.way(from, s),
            _ => {
                let ends = [(0.0, line.points[0]), (line.length(), line.points[line.points.len() - 1])];
                let ways = ends.iter().filter(|(_, p)| *p == position).map(|(s, _)| s - from);
                ways.reduce(|a, b| if b.abs() < a.abs() { b } else { a }).unwrap_or(0.0)
            }
        }
    }

    /// The middle of an edge along `curve`.
    pub(super) fn middle(&self, curve: u32, ends: [(Anchor, DVec3); 2]) -> (Anchor, DVec3) {
        let line = &self.curves[curve as usize];
        let on = |(anchor, _): (Anchor, DVec3)| match anchor {
            Anchor::Curve(id, s) if id == curve => Some(s),
            _ => None,
        };
        let s = match (on(ends[0]), on(ends[1])) {
            (Some(s), _) => s + 0.5 * self.way_to(curve, s, ends[1].0, ends[1].1),
            (None, Some(s)) => s + 0.5 * self.way_to(curve, s, ends[0].0, ends[0].1),
            (None, None) => 0.5 * line.length(),
        };
        self.moved(curve, s, 0.0)
    }

    /// The vertex at arc length `s` moved by `step` along its curve.
    pub(super) fn moved(&self, curve: u32, s: f64, step: f64) -> (Anchor, DVec3) {
        let line = &self.curves[curve as usize];
        let s = line.confined(s + step);
        (Anchor::Curve(curve, s), line.point(s))
    }
}

/// Drops creases that are noise of a scanned or engraved surface: branches with a free end, and small nets.
///
/// The edges between the faces of a solid form loops; a single fold in a rough surface does not. Borders are
/// kept.
fn prune(mesh: &TriMesh, edges: &[Edge], least_length: f64) -> (Vec<[u32; 2]>, Vec<bool>) {
    let sharp: Vec<[u32; 2]> = edges.iter().map(|e| e.ends).collect();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); mesh.vertices.len()];
    for (edge, ends) in sharp.iter().enumerate() {
        ends.iter().for_each(|v| around[*v as usize].push(edge as u32));
    }
    let mut keep = vec![true; sharp.len()];
    // Remove branches, from their free ends inwards.
    let mut loose: Vec<u32> = (0..around.len() as u32).filter(|v| around[*v as usize].len() == 1).collect();
    while let Some(v) = loose.pop() {
        let Some(edge) = around[v as usize].iter().copied().find(|e| keep[*e as usize]) else { continue };
        keep[edge as usize] = false;
        loose.extend(
            sharp[edge as usize]
                .iter()
                .filter(|far| around[**far as usize].iter().filter(|e| keep[**e as usize]).count() == 1),
        );
    }
    // Remove connected nets that are too short.
    let mut seen = vec![false; sharp.len()];
    for first in 0..sharp.len() {
        if seen[first] || !keep[first] {
            continue;
        }
        let mut net = vec![first as u32];
        seen[first] = true;
        let mut next = 0;
        while next < net.len() {
            for v in sharp[net[next] as usize] {
                for edge in &around[v as usize] {
                    if keep[*edge as usize] && !std::mem::replace(&mut seen[*edge as usize], true) {
                        net.push(*edge);
                    }
                }
            }
            next += 1;
        }
        let ends = |edge: &u32| sharp[*edge as usize].map(|v| mesh.vertices[v as usize]);
        let length: f64 = net.iter().map(ends).map(|[a, b]| a.distance(b)).sum();
        if length < least_length && net.iter().all(|e| !edges[*e as usize].border) {
            net.iter().for_each(|edge| keep[*edge as usize] = false);
        }
    }
    let kept = edges.iter().zip(keep).filter(|(_, keep)| *keep);
    kept.map(|(edge, _)| (edge.ends, edge.border)).unzip()
}

/// A crease.
struct Edge {
    ends: [u32; 2],
    border: bool,
}

/// Edges that turn by more than `angle` or have one triangle, each once, in order of their vertices.
fn sharp_edges(mesh: &TriMesh, angle: f64, mirrors: BVec3) -> Vec<Edge> {
    let normals: Vec<DVec3> =
        (0..mesh.triangles.len()).map(|t| mesh.area_vector(t).normalize_or_zero()).collect();
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), t as u32));
        }
    }
    // Pair the triangles at each edge, then compare their normals.
    sides.sort_unstable();
    let limit = angle.cos();
    // The triangle across a border is the mirror image: the edge is sharp if the triangle is inclined by half
    // the angle.
    let leans = |a: u32, b: u32, t: u32| {
        let on_plane =
            mesh.vertices[a as usize].cmpeq(DVec3::ZERO) & mesh.vertices[b as usize].cmpeq(DVec3::ZERO);
        let across = DVec3::select(on_plane & mirrors, normals[t as usize], DVec3::ZERO);
        across.length() > (0.5 * angle).sin()
    };
    sides
        .chunk_by(|x, y| (x.0, x.1) == (y.0, y.1))
        .filter_map(|edge| {
            let ends = [edge[0].0, edge[0].1];
            match edge {
                [x, y] if normals[x.2 as usize].dot(normals[y.2 as usize]) >= limit => None,
                [only] => Some(Edge { ends, border: !leans(only.0, only.1, only.2) }),
                _ => Some(Edge { ends, border: false }),
            }
        })
        .collect()
}
