//! Detection of meshes that are axisymmetric about y, apart from the roughness of their triangles, and fit of
//! their section.
//!
//! A scanned or voxelised bowl is axisymmetric, although its vertices lie on no circles. Its section is the
//! zero of the signed distance to the surface, averaged over the angle φ. The mesh is cut at one angle; the
//! cut is moved to this zero and approximated by arcs.

use std::f64::consts::TAU;

use clangor_core::geometry::meridian::{Meridian, Piece};
use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DVec2, DVec3};

use crate::mesh::tetrahedra::isosurface_stuffing::wall_thickness;

/// A fitted section, and its distance from the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeridianFit {
    /// The section.
    pub meridian: Meridian,
    /// Largest distance of the section from the mesh, at any angle \[m\].
    pub deviation: f64,
    /// Thickness of the walls \[m\].
    pub wall: f64,
}

/// Largest deviation over the thickness of the walls.
const MOST_DEVIATION: f64 = 0.1;
/// Largest distance of an arc from the averaged surface, over the thickness.
const ARC_ERROR: f64 = 0.01;
/// Longest and shortest arcs over the thickness.
const LONGEST: f64 = 2.0;
const SHORTEST: f64 = 0.2;
/// Number of averaged angles; odd, to avoid aliasing with a grid.
const ANGLES: usize = 23;
/// Vertices of the first test, which rotates them and checks that they stay on the surface.
const PROBES: usize = 100;

/// The section of a mesh about its centre of mass; `None` if it is not axisymmetric about y.
pub fn fitted_meridian(mesh: &TriMesh) -> Option<MeridianFit> {
    let tree = SurfaceTree::new(mesh);
    // Cheap bounds first: no wall is thicker than the body, and most other bodies are rejected before their
    // walls are measured.
    let mut surface = Surface { mesh, tree: &tree, wall: mesh.bounding_radius(DVec3::ZERO) };
    let step = (mesh.vertices.len() / PROBES).max(1);
    let mut spread = 0.0_f64;
    for v in mesh.vertices.iter().step_by(step) {
        spread = spread.max(surface.spread(DVec2::new(v.x.hypot(v.z), v.y)));
        if spread > MOST_DEVIATION * surface.wall {
            return None;
        }
    }
    let wall = wall_thickness(mesh, &tree).min(surface.wall);
    if spread > MOST_DEVIATION * wall {
        return None;
    }
    surface.wall = wall;
    let path = surface.slice()?;
    let meridian = Meridian::try_new(surface.pieces(&path)?).ok()?;
    let samples = meridian.pieces().iter().flat_map(|p| [0.25, 0.75].map(|t| p.point(t)));
    let deviation = samples.map(|p| surface.spread(p)).fold(0.0, f64::max);
    (deviation <= MOST_DEVIATION * wall).then_some(MeridianFit { meridian, deviation, wall })
}

struct Surface<'a> {
    mesh: &'a TriMesh,
    tree: &'a SurfaceTree,
    wall: f64,
}

/// Points along a cut, from the axis to the axis or around.
struct Path {
    points: Vec<DVec2>,
    closed: bool,
}

impl Surface<'_> {
    fn distance(&self, p: DVec2, turn: f64) -> f64 {
        let (sin, cos) = (TAU * turn).sin_cos();
        let at = DVec3::new(p.x * cos, p.y, p.x * sin);
        self.tree.signed_distance(self.mesh, at).unwrap_or(f64::INFINITY)
    }

    fn around(&self, p: DVec2) -> impl Iterator<Item = f64> {
        (0..ANGLES).map(move |k| self.distance(p, k as f64 / ANGLES as f64))
    }

    /// Signed distance, averaged over φ.
    fn mean(&self, p: DVec2) -> f64 {
        self.around(p).sum::<f64>() / ANGLES as f64
    }

    /// Largest distance at any φ.
    fn spread(&self, p: DVec2) -> f64 {
        self.around(p).map(f64::abs).fold(0.0, f64::max)
    }

    /// The point of the averaged surface near `p`.
    fn settled(&self, mut p: DVec2) -> DVec2 {
        let on_axis = p.x <= 1e-9 * self.wall;
        let step = 0.02 * self.wall;
        for _ in 0..3 {
            let slope = |by: DVec2| self.mean(p + by) - self.mean(p - by);
            let across = if on_axis { 0.0 } else { slope(DVec2::X * step) };
            let gradient = DVec2::new(across, slope(DVec2::Y * step)) / (2.0 * step);
            p -= gradient * (self.mean(p) / gradient.length_squared().max(0.25));
            p.x = p.x.max(0.0);
        }
        p
    }

    /// The cut of the mesh by a half-plane beside the axis; `None` unless it is one line.
    fn slice(&self) -> Option<Path> {
        // An angle that avoids all vertices.
        let (sin, cos) = 0.123_456_7_f64.sin_cos();
        let (along, across) = (DVec3::new(cos, 0.0, sin), DVec3::new(-sin, 0.0, cos));
        // Each segment of the cut with the mesh edges at its ends.
        let mut ends: Vec<([u32; 2], usize)> = Vec::new();
        let mut pieces: Vec<[DVec2; 2]> = Vec::new();
        for t in &self.mesh.triangles {
            let side = t.map(|v| self.mesh.vertices[v as usize].dot(across));
            let mut crossed = Vec::new();
            for k in 0..3 {
                let (i, j) = (k, (k + 1) % 3);
                if (side[i] < 0.0) != (side[j] < 0.0) {
                    let [a, b] = [t[i], t[j]].map(|v| self.mesh.vertices[v as usize]);
                    let p = a + (b - a) * (side[i] / (side[i] - side[j]));
                    crossed.push(([t[i].min(t[j]), t[i].max(t[j])], DVec2::new(p.dot(along), p.y)));
                }
            }
            if let [(e, p), (f, q)] = crossed[..] {
                ends.extend([(e, pieces.len()), (f, pieces.len())]);
                pieces.push([p, q]);
            }
        }
        ends.sort_unstable();
        let loops = chains(&ends, &pieces);
        let mut paths: Vec<Path> = loops.iter().flat_map(|points| beside_axis(points)).collect();
        let path = paths.pop().filter(|_| paths.is_empty())?;
        Some(path.counter_clockwise())
    }

    /// Arcs that approximate a path.
    fn pieces(&self, path: &Path) -> Option<Vec<Piece>> {
        // Arc length of the path.
        let mut lengths = vec![0.0];
        for pair in path.points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
        }
        let total = lengths[lengths.len() - 1];
        let at = |s: f64| {
            let k = lengths.partition_point(|l| *l < s).clamp(1, lengths.len() - 1);
            let within = (s - lengths[k - 1]) / (lengths[k] - lengths[k - 1]).max(f64::MIN_POSITIVE);
            path.points[k - 1].lerp(path.points[k], within.clamp(0.0, 1.0))
        };
        // Initial cuts, projected onto the averaged surface.
        let count = (total / (LONGEST * self.wall)).ceil().max(4.0) as usize;
        if count > 2000 {
            return None;
        }
        let mut cuts: Vec<(f64, DVec2)> =
            (0..=count).map(|k| total * k as f64 / count as f64).map(|s| (s, self.settled(at(s)))).collect();
        if path.closed {
            cuts[count].1 = cuts[0].1;
        }
        // Bisect until each arc meets the tolerance.
        let mut pieces = Vec::new();
        let mut stack: Vec<[(f64, DVec2); 2]> = cuts.windows(2).map(|c| [c[0], c[1]]).rev().collect();
        while let Some([from, to]) = stack.pop() {
            let s = 0.5 * (from.0 + to.0);
            let middle = (s, self.settled(at(s)));
            let piece = arc(from.1, middle.1, to.1);
            let worst = [0.2, 0.8].map(|t| self.mean(piece.point(t)).abs()).into_iter().fold(0.0, f64::max);
            if worst > ARC_ERROR * self.wall && to.0 - from.0 > 2.0 * SHORTEST * self.wall {
                stack.extend([[middle, to], [from, middle]]);
            } else {
                pieces.push(piece);
            }
        }
        Some(pieces)
    }
}

impl Path {
    /// Oriented with the material to the left.
    fn counter_clockwise(mut self) -> Self {
        // ∮ r² dy; segments along the axis contribute nothing.
        let sum: f64 = self
            .points
            .windows(2)
            .map(|w| (w[0].x * w[0].x + w[0].x * w[1].x + w[1].x * w[1].x) * (w[1].y - w[0].y))
            .sum();
        if sum < 0.0 {
            self.points.reverse();
        }
        self
    }
}

/// Closed lines made of pieces that share ends; the first point is repeated at the end.
fn chains(ends: &[([u32; 2], usize)], pieces: &[[DVec2; 2]]) -> Vec<Vec<DVec2>> {
    let mut used = vec![false; pieces.len()];
    let mut edges = vec![[[0; 2]; 2]; pieces.len()];
    let mut filled = vec![0; pieces.len()];
    // Mesh edges at the ends of each segment.
    for (edge, piece) in ends {
        edges[*piece][filled[*piece]] = *edge;
        filled[*piece] += 1;
    }
    // The ends are sorted, so the edges of a segment may be swapped. Its end points are found from the
    // neighbour, which shares one of them.
    let mut chains = Vec::new();
    // Walk from segment to segment through shared edges.
    for start in 0..pieces.len() {
        if used[start] {
            continue;
        }
        let mut points = Vec::new();
        let (mut piece, mut leave) = (start, edges[start][1]);
        loop {
            used[piece] = true;
            let from = ends.partition_point(|(e, _)| *e < leave);
            let next = ends[from..].iter().take_while(|(e, _)| *e == leave).find(|(_, p)| *p != piece);
            let Some((_, next)) = next else { break };
            points.push(shared(&pieces[piece], &pieces[*next]));
            if *next == start || used[*next] {
                break;
            }
            piece = *next;
            leave = if edges[piece][0] == leave { edges[piece][1] } else { edges[piece][0] };
        }
        if let Some(first) = points.first().copied() {
            points.push(first);
        }
        chains.push(points);
    }
    chains
}

/// The end that two pieces have in common.
fn shared(a: &[DVec2; 2], b: &[DVec2; 2]) -> DVec2 {
    let nearest = |p: &DVec2| b[0].distance_squared(*p).min(b[1].distance_squared(*p));
    if nearest(&a[0]) < nearest(&a[1]) { a[0] } else { a[1] }
}

/// The parts of a closed line at r ≥ 0.
fn beside_axis(points: &[DVec2]) -> Vec<Path> {
    if points.iter().all(|p| p.x > 0.0) {
        return vec![Path { points: points.to_vec(), closed: true }];
    }
    let Some(start) = points.iter().position(|p| p.x <= 0.0) else { return Vec::new() };
    let open = &points[..points.len().saturating_sub(1)];
    let mut paths = Vec::new();
    let mut current: Vec<DVec2> = Vec::new();
    for k in 0..open.len() {
        let (a, b) = (open[(start + k) % open.len()], open[(start + k + 1) % open.len()]);
        let crossing = || DVec2::new(0.0, a.y + (b.y - a.y) * a.x / (a.x - b.x));
        match (a.x > 0.0, b.x > 0.0) {
            (false, true) => current = vec![crossing(), b],
            (true, true) => current.push(b),
            (true, false) => {
                current.push(crossing());
                paths.push(Path { points: std::mem::take(&mut current), closed: false });
            }
            (false, false) => {}
        }
    }
    paths
}

/// The arc through three points, or a line if they are nearly on one.
fn arc(from: DVec2, middle: DVec2, to: DVec2) -> Piece {
    let (u, v) = (middle - from, to - from);
    let twice = 2.0 * u.perp_dot(v);
    if twice.abs() < 4e-3 * v.length_squared() {
        return Piece::Line { from, to };
    }
    let offset = DVec2::new(
        v.y * u.length_squared() - u.y * v.length_squared(),
        u.x * v.length_squared() - v.x * u.length_squared(),
    ) / twice;
    let centre = from + offset;
    let start = (-offset).to_angle();
    // Counter-clockwise if the middle lies to the right of the chord.
    let sign = if twice > 0.0 { 1.0 } else { -1.0 };
    let angle = sign * (sign * (-offset).angle_to(to - centre)).rem_euclid(TAU);
    Piece::Arc { centre, semi_axes: DVec2::splat(offset.length()), from: start, to: start + angle }
}
