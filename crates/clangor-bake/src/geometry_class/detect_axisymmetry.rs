//! Detection of meshes that are axisymmetric about y, apart from the roughness of their triangles, and fit of
//! their section.
//!
//! A scanned or voxelised bowl is axisymmetric, although its vertices lie on no circles. Its section is the
//! zero of the signed distance to the surface, averaged over the angle φ. The mesh is cut at one angle; the
//! cut is moved to this zero and approximated by arcs, and by lines between sharp corners. A polygon around
//! the axis so becomes the circle of its mean radius.
//!
//! Facets and roughness vary quickly around the axis. What varies slowly is a form of its own: an oval, a
//! wedge, a bent tube. Its first harmonics about the axis are bounded more tightly.

use std::f64::consts::TAU;
use std::ops::Range;

use clangor_core::geometry::meridian::{Meridian, Piece};
use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DVec2, DVec3};

use super::agreement::{follows_roughly, thickness};
use super::bake_geometry::BakeGeometry;
use super::section_corners::StraightRuns;
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

/// Largest distance of a probed vertex from the surface at another angle, over the bounding radius: a cheap
/// bound, which rejects most other bodies.
const MOST_SPREAD: f64 = 0.02;
/// Largest amplitude of the slow harmonics around the axis, over the thickness of the body there and over the
/// bounding radius.
const SLOW_PER_THICKNESS: f64 = 0.02;
const SLOW_PER_RADIUS: f64 = 1e-3;
/// Highest slow harmonic, and the number of angles at which harmonics are measured.
const SLOWEST: usize = 6;
const HARMONIC_ANGLES: usize = 211;
/// Largest distance of an arc from the averaged surface, over the thickness, beyond the noise of the average.
const ARC_ERROR: f64 = 0.01;
/// Standard errors of an average that are noise.
const NOISE: f64 = 2.0;
/// Where an arc is compared with the averaged surface.
const ALONG_ARC: [f64; 4] = [0.1, 0.3, 0.7, 0.9];
/// Longest and shortest arcs over the thickness.
const LONGEST: f64 = 8.0;
const SHORTEST: f64 = 0.2;
/// Number of averaged angles; odd, to avoid aliasing with a grid.
const ANGLES: usize = 23;
/// Vertices of the first test, which rotates them and checks that they stay on the surface.
const PROBES: usize = 100;

/// The section of a mesh about its centre of mass; `None` if it is not axisymmetric about y.
pub fn fitted_meridian(mesh: &TriMesh) -> Option<MeridianFit> {
    let tree = SurfaceTree::new(mesh);
    let radius = mesh.bounding_radius(DVec3::ZERO);
    let mut surface = Surface { mesh, tree: &tree, wall: radius };
    // Cheap bound first, before walls are measured.
    let step = (mesh.vertices.len() / PROBES).max(1);
    let leaves = |v: &DVec3| surface.spread(DVec2::new(v.x.hypot(v.z), v.y)) > MOST_SPREAD * radius;
    if mesh.vertices.iter().step_by(step).any(leaves) {
        return None;
    }
    surface.wall = wall_thickness(mesh, &tree).min(radius);
    // Cut, and move the cut to the averaged surface.
    let path = surface.slice()?;
    let meridian = Meridian::try_new(surface.pieces(path)?).ok()?;
    // Compare the section with the mesh.
    let samples: Vec<DVec2> = meridian.pieces().iter().flat_map(|p| samples(p, surface.wall)).collect();
    let deviation = samples.iter().map(|p| surface.spread(*p)).fold(0.0, f64::max);
    let same = follows_roughly(mesh, &tree, &BakeGeometry::axisymmetric(meridian.clone()))
        && samples.iter().all(|p| surface.is_round(*p));
    same.then_some(MeridianFit { meridian, deviation, wall: surface.wall })
}

/// Points of a piece, at least two, about a wall apart.
fn samples(piece: &Piece, wall: f64) -> Vec<DVec2> {
    let count = (piece.length(0.0, 1.0) / wall).ceil().max(2.0) as usize;
    (0..count).map(|k| piece.point((k as f64 + 0.5) / count as f64)).collect()
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

    /// Distance of the averaged surface, less the noise of the average over φ.
    fn off(&self, p: DVec2) -> f64 {
        let count = ANGLES as f64;
        let [sum, squares] = self.around(p).fold([0.0; 2], |[sum, squares], d| [sum + d, squares + d * d]);
        let mean = sum / count;
        let variance = (squares / count - mean * mean).max(0.0);
        mean.abs() - NOISE * (variance / count).sqrt()
    }

    /// Largest distance at any φ.
    fn spread(&self, p: DVec2) -> f64 {
        self.around(p).map(f64::abs).fold(0.0, f64::max)
    }

    /// Whether the surface near `p` varies little, and not slowly, around the axis.
    fn is_round(&self, p: DVec2) -> bool {
        let around: Vec<f64> =
            (0..HARMONIC_ANGLES).map(|k| self.distance(p, k as f64 / HARMONIC_ANGLES as f64)).collect();
        let amplitude = |m: usize| {
            let term = |(k, d): (usize, &f64)| {
                *d * DVec2::from_angle(TAU * (m * k % HARMONIC_ANGLES) as f64 / HARMONIC_ANGLES as f64)
            };
            let sum: DVec2 = around.iter().enumerate().map(term).sum();
            2.0 * sum.length() / HARMONIC_ANGLES as f64
        };
        let slow = (1..=SLOWEST).map(amplitude).fold(0.0, f64::max);
        let radius = self.mesh.bounding_radius(DVec3::ZERO);
        slow <= (SLOW_PER_THICKNESS * self.thickness(p)).min(SLOW_PER_RADIUS * radius)
    }

    /// Thickness of the body behind the surface near `p` \[m\].
    fn thickness(&self, p: DVec2) -> f64 {
        let radius = self.mesh.bounding_radius(DVec3::ZERO);
        // Near an edge, the side that the surface there belongs to is the one of the greater thickness.
        let behind = |turn: f64| {
            let (sin, cos) = (TAU * turn).sin_cos();
            let nearest = self.tree.nearest(self.mesh, DVec3::new(p.x * cos, p.y, p.x * sin));
            nearest.map_or(0.0, |n| thickness(self.mesh, self.tree, (n.position, n.triangle), radius))
        };
        [0.012, 0.123, 0.456, 0.789].map(behind).into_iter().fold(0.0, f64::max)
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

    /// Lines and arcs that approximate a path.
    fn pieces(&self, path: Path) -> Option<Vec<Piece>> {
        let runs = path.straight_runs(self.wall);
        let Some(first) = runs.corners().next() else {
            return self.arcs(&Line::new(&path.points), None, path.closed);
        };
        // A loop starts at a corner.
        let (path, runs) = match path.closed && first != 0 {
            true => {
                let turned = path.starting_at(first);
                let runs = turned.straight_runs(self.wall);
                (turned, runs)
            }
            false => (path, runs),
        };
        let points = &path.points;
        let last = points.len() - 1;
        let mut marks: Vec<usize> = runs.corners().collect();
        marks.extend([0, last]);
        marks.sort_unstable();
        marks.dedup();
        // Corners, where the lines through the averaged surface on both sides meet.
        let place = |mark: usize| -> Option<DVec2> {
            let axis = || Some((DVec2::ZERO, DVec2::Y));
            let [before, after] = runs.beside(mark);
            let at_axis = |at: usize| !path.closed && mark == at;
            let beside_is_straight =
                |k: usize| marks.windows(2).any(|w| w[k] == mark && runs.is_straight(w[0], w[1]));
            if (at_axis(0) && !beside_is_straight(0)) || (at_axis(last) && !beside_is_straight(1)) {
                return Some(self.settled(points[mark]));
            }
            let before = if at_axis(0) { axis() } else { self.averaged_line(points, before?) };
            let after = if at_axis(last) { axis() } else { self.averaged_line(points, after?) };
            let corner = crossing(before?, after?)?;
            (corner.distance(points[mark]) <= self.wall).then_some(DVec2::new(corner.x.max(0.0), corner.y))
        };
        let corners: Vec<DVec2> = marks.iter().map(|mark| place(*mark)).collect::<Option<_>>()?;
        let mut pieces = Vec::new();
        for k in 1..marks.len() {
            let ends = [corners[k - 1], corners[k % corners.len()]];
            let ends = if path.closed && k + 1 == marks.len() { [ends[0], corners[0]] } else { ends };
            match runs.is_straight(marks[k - 1], marks[k]) {
                true => pieces.push(Piece::Line { from: ends[0], to: ends[1] }),
                false => {
                    let run = Line::new(&points[marks[k - 1]..=marks[k]]);
                    pieces.extend(self.arcs(&run, Some(ends), false)?);
                }
            }
        }
        Some(pieces)
    }

    /// A point and the direction of the line near a straight run of a path along the averaged surface.
    fn averaged_line(&self, points: &[DVec2], run: Range<usize>) -> Option<(DVec2, DVec2)> {
        let (from, to) = (points[run.start], points[run.end]);
        // The outward normal is to the right.
        let outward = -(to - from).normalize_or_zero().perp();
        let [a, b] = [0.25, 0.75].map(|t| from.lerp(to, t)).map(|p| p - outward * self.mean(p));
        Some((a, (b - a).try_normalize()?))
    }

    /// Arcs that approximate a line, between given ends or those of the averaged surface.
    fn arcs(&self, line: &Line<'_>, ends: Option<[DVec2; 2]>, closed: bool) -> Option<Vec<Piece>> {
        let total = line.length();
        // Initial cuts, projected onto the averaged surface.
        let count = (total / (LONGEST * self.wall)).ceil().max(4.0) as usize;
        if count > 2000 {
            return None;
        }
        let mut cuts: Vec<(f64, DVec2)> = (0..=count)
            .map(|k| total * k as f64 / count as f64)
            .map(|s| (s, self.settled(line.at(s))))
            .collect();
        if closed {
            cuts[count].1 = cuts[0].1;
        }
        if let Some([from, to]) = ends {
            (cuts[0].1, cuts[count].1) = (from, to);
        }
        // Bisect until each arc meets the tolerance.
        let mut pieces = Vec::new();
        let mut stack: Vec<[(f64, DVec2); 2]> = cuts.windows(2).map(|c| [c[0], c[1]]).rev().collect();
        while let Some([from, to]) = stack.pop() {
            let s = 0.5 * (from.0 + to.0);
            let middle = (s, self.settled(line.at(s)));
            let piece = arc(from.1, middle.1, to.1);
            let worst = ALONG_ARC.map(|t| self.off(piece.point(t))).into_iter().fold(0.0, f64::max);
            if worst > ARC_ERROR * self.wall && to.0 - from.0 > 2.0 * SHORTEST * self.wall {
                stack.extend([[middle, to], [from, middle]]);
            } else {
                pieces.push(piece);
            }
        }
        Some(pieces)
    }
}

/// A line of straight segments, by its length.
struct Line<'a> {
    points: &'a [DVec2],
    /// Length up to each point \[m\].
    lengths: Vec<f64>,
}

impl<'a> Line<'a> {
    fn new(points: &'a [DVec2]) -> Self {
        let mut lengths = vec![0.0];
        for pair in points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
        }
        Line { points, lengths }
    }

    fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    fn at(&self, s: f64) -> DVec2 {
        let lengths = &self.lengths;
        let k = lengths.partition_point(|l| *l < s).clamp(1, lengths.len() - 1);
        let within = (s - lengths[k - 1]) / (lengths[k] - lengths[k - 1]).max(f64::MIN_POSITIVE);
        self.points[k - 1].lerp(self.points[k], within.clamp(0.0, 1.0))
    }
}

/// Where two lines cross, each a point and a direction; `None` if they are nearly parallel.
fn crossing((p, u): (DVec2, DVec2), (q, v): (DVec2, DVec2)) -> Option<DVec2> {
    let sine = u.perp_dot(v);
    (sine.abs() > 0.05).then(|| p + u * ((q - p).perp_dot(v) / sine))
}

impl Path {
    fn straight_runs(&self, wall: f64) -> StraightRuns {
        StraightRuns::of(&self.points, self.closed, ARC_ERROR * wall, wall)
    }

    /// A loop from another of its points.
    fn starting_at(mut self, point: usize) -> Self {
        self.points.pop();
        self.points.rotate_left(point);
        self.points.extend(self.points.first().copied());
        self
    }

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
