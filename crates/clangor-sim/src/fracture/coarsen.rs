//! Merges the small and flat elements that result from cutting, without moving the body's surface.
//!
//! An edge is contracted: one end moves onto the other, and the elements between them vanish; or a point
//! moves towards the middle of its neighbours. Three conditions apply.
//!
//! * The topology of regions does not change: the link conditions of Dey, Edelsbrunner, Guha and Nekhayev,
//!   "Topology preserving edge contraction" (1999), for the whole complex with the outside, and for the
//!   strata of surfaces, lines and points at which regions meet. Each side of the outer surface, old or made
//!   by a crack, counts as a region.
//! * The outer surface does not move: its triangles around the moving end stay in their own planes. The walls
//!   between regions may move, but their area does not grow, so that the energy of the crack stays valid.
//!   Scored walls stay in their planes and leave them only to remove a sliver.
//! * The shapes of elements do not become worse: see [`GOOD`].
//!
//! The size of an element is compared with that of its original element in the first whole body, so that
//! repeated fractures do not produce ever smaller elements.

use clangor_core::glam::DVec3;

use super::cells::{Cell, Cells, OuterFace};
use super::star::{Star, keeps_regions, others, points_of};
use super::tetrahedron::shape;

/// Edges shorter than this share of the mean edge of the first element are contracted.
const SHORT: f64 = 0.45;
/// Elements of this shape (1 for the regular tetrahedron) may replace any others; otherwise the worst shape
/// must not become worse.
const GOOD: f64 = 0.4;
/// Elements of a worse shape are improved whatever their size.
const POOR: f64 = 0.25;
/// Rounds over all edges; few find anything after the third.
const ROUNDS: usize = 5;
/// A triangle stays in its plane if it leaves the plane by at most this share of the displacement.
const FLAT: f64 = 1e-10;
/// Distance by which flat walls may leave their planes, as a share of an element: always, and to remove a
/// poor element.
pub(super) const ON_PLANE: f64 = 1e-6;
const SNAP: f64 = 0.1;

/// Constraint on the motion of walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Walls {
    /// Free, as long as their area does not grow.
    Free,
    /// Within their planes.
    Flat,
}

/// Merges small and poor elements. Uncut elements keep all corners that no cut element shares.
pub(super) fn coarsen(cells: Cells, element_size: &[f64], walls: Walls) -> Cells {
    let mut merger = Merger::new(cells, element_size, walls);
    for _ in 0..ROUNDS {
        let merged = merger.contract_short() + merger.mend_poor();
        let moved = merger.smooth();
        if merged + moved == 0 {
            break;
        }
    }
    if walls == Walls::Flat {
        merger.leave = SNAP;
        while merger.mend_poor() > 0 {}
    }
    merger.finish()
}

/// Region number of the outside beyond the original surface; plus 1 beyond the surface of earlier cracks.
const OUTSIDE: u32 = u32::MAX - 1;

struct Merger<'a> {
    points: Vec<DVec3>,
    cells: Vec<Cell>,
    alive: Vec<bool>,
    outer: Vec<([u32; 3], bool)>,
    outer_alive: Vec<bool>,
    cells_of: Vec<Vec<u32>>,
    outer_of: Vec<Vec<u32>>,
    element_size: &'a [f64],
    walls: Walls,
    /// How far flat walls may leave their planes, as a share of an element.
    leave: f64,
    /// Allowed growth of the area of the walls \[m²\]: the area removed by contractions so far.
    spare_area: f64,
    /// Whether a cell was made by cutting or has changed since.
    touched: Vec<bool>,
}

impl<'a> Merger<'a> {
    fn new(cells: Cells, element_size: &'a [f64], walls: Walls) -> Self {
        let Cells { points, cells, outer } = cells;
        let mut cells_of = vec![Vec::new(); points.len()];
        let mut parts = vec![0_u32; element_size.len()];
        for (k, cell) in cells.iter().enumerate() {
            cell.corners.iter().for_each(|n| cells_of[*n as usize].push(k as u32));
            parts[cell.element as usize] += 1;
        }
        let mut outer_of = vec![Vec::new(); points.len()];
        for (k, face) in outer.iter().enumerate() {
            face.corners.iter().for_each(|n| outer_of[*n as usize].push(k as u32));
        }
        Merger {
            touched: cells.iter().map(|c| parts[c.element as usize] > 1).collect(),
            alive: vec![true; cells.len()],
            outer_alive: vec![true; outer.len()],
            outer: outer.iter().map(|f| (f.corners, f.inside)).collect(),
            points,
            cells,
            cells_of,
            outer_of,
            element_size,
            walls,
            leave: ON_PLANE,
            spare_area: 0.0,
        }
    }

    fn finish(self) -> Cells {
        let alive = |k: &usize| self.alive[*k];
        let cells = (0..self.cells.len()).filter(alive).map(|k| self.cells[k]).collect();
        let outer = (0..self.outer.len())
            .filter(|k| self.outer_alive[*k])
            .map(|k| OuterFace { corners: self.outer[k].0, inside: self.outer[k].1 })
            .collect();
        Cells { points: self.points, cells, outer }
    }

    fn place(&self, n: u32) -> DVec3 {
        self.points[n as usize]
    }

    fn size_of(&self, cell: u32) -> f64 {
        self.element_size[self.cells[cell as usize].element as usize]
    }

    /// Contracts short edges, the shortest first. Returns their number.
    fn contract_short(&mut self) -> usize {
        let mut short: Vec<(u64, [u32; 2])> = Vec::new();
        for k in (0..self.cells.len()).filter(|k| self.alive[*k] && self.touched[*k]) {
            let limit = SHORT * self.size_of(k as u32);
            for [i, j] in clangor_bake::mesh::tetrahedra::EDGES {
                let (a, b) = (self.cells[k].corners[i], self.cells[k].corners[j]);
                let length = self.place(a).distance(self.place(b));
                if length < limit {
                    short.push(((length / limit).to_bits(), [a.min(b), a.max(b)]));
                }
            }
        }
        short.sort_unstable();
        short.dedup_by_key(|s| s.1);
        short.iter().filter(|(_, edge)| self.contract(*edge, 0.0)).count()
    }

    /// Contracts an edge of each badly shaped cell if that improves the shapes. Returns their number.
    fn mend_poor(&mut self) -> usize {
        let mut count = 0;
        for k in 0..self.cells.len() {
            if !self.alive[k] || !self.touched[k] {
                continue;
            }
            let corners = self.cells[k].corners;
            let now = shape(corners.map(|n| self.place(n)));
            if now >= POOR {
                continue;
            }
            let mut edges = clangor_bake::mesh::tetrahedra::EDGES.map(|[i, j]| [corners[i], corners[j]]);
            edges.sort_by(|a, b| {
                let length = |e: &[u32; 2]| self.place(e[0]).distance_squared(self.place(e[1]));
                length(a).total_cmp(&length(b)).then(a.cmp(b))
            });
            count += usize::from(edges.into_iter().any(|edge| self.contract(edge, 1.1)));
        }
        count
    }

    /// Contracts an edge onto the end that gives the better shapes, if allowed. With a positive `gain` the
    /// worst shape must improve by that factor, even if it is good.
    fn contract(&mut self, [a, b]: [u32; 2], gain: f64) -> bool {
        let joined = self.cells_of[a as usize].iter().any(|k| self.cells[*k as usize].corners.contains(&b));
        if !joined {
            return false;
        }
        let rated = |from, to| self.rate(from, to, gain).map(|(worst, growth)| (worst, growth, from, to));
        let best = match (rated(a, b), rated(b, a)) {
            (Some(x), Some(y)) => Some(if x.0 >= y.0 { x } else { y }),
            (x, y) => x.or(y),
        };
        let Some((_, growth, from, to)) = best else { return false };
        if !keeps_regions(&self.star(from), &self.star(to), to) {
            return false;
        }
        self.spare_area -= growth;
        self.merge(from, to);
        true
    }

    /// The worst shape and the growth of the walls' area if `from` moves onto `to`; `None` if the geometry
    /// forbids it.
    fn rate(&self, from: u32, to: u32, gain: f64) -> Option<(f64, f64)> {
        let (source, target) = (self.place(from), self.place(to));
        let way = source.distance(target);
        let goes_on = |corners: [u32; 3], slack: f64| {
            let area = |moved: bool| {
                let place = |n: u32| if moved && n == from { target } else { self.place(n) };
                let [a, b, c] = corners.map(place);
                (b - a).cross(c - a)
            };
            let normal = area(false).normalize_or_zero();
            normal.dot(target - source).abs() <= slack && normal.dot(area(true)) > 0.0
        };
        for k in &self.outer_of[from as usize] {
            let corners = self.outer[*k as usize].0;
            if !corners.contains(&to) && !goes_on(corners, FLAT * way) {
                return None;
            }
        }
        // Worst shapes before and after.
        let (mut before, mut after) = (f64::INFINITY, f64::INFINITY);
        for k in &self.cells_of[from as usize] {
            let corners = self.cells[*k as usize].corners;
            before = before.min(shape(corners.map(|n| self.place(n))));
            if !corners.contains(&to) {
                after = after.min(shape(corners.map(|n| if n == from { target } else { self.place(n) })));
            }
        }
        let enough = if gain > 0.0 { after >= gain * before } else { after >= GOOD || after >= before };
        if !enough || after <= 0.0 {
            return None;
        }
        // Area of the walls.
        let mut growth = 0.0;
        for [p, q] in self.crack_edges(from) {
            let old = (self.place(p) - source).cross(self.place(q) - source).length();
            growth -= 0.5 * old;
            if p != to && q != to {
                growth += 0.5 * (self.place(p) - target).cross(self.place(q) - target).length();
                let size = self.size_of(self.cells_of[from as usize][0]);
                let slack = (FLAT * way).max(self.leave * size);
                if self.walls == Walls::Flat && !goes_on([from, p, q], slack) {
                    return None;
                }
            }
        }
        let allowed = self.walls != Walls::Free || growth <= self.spare_area;
        allowed.then_some((after, growth))
    }

    /// Moves points of touched cells towards the mean of their neighbours on the same line, on the same wall
    /// or inside. Returns the number of moved points.
    fn smooth(&mut self) -> usize {
        let touched = (0..self.cells.len()).filter(|k| self.alive[*k] && self.touched[*k]);
        let mut points: Vec<u32> = touched.flat_map(|k| self.cells[k].corners).collect();
        points.sort_unstable();
        points.dedup();
        points.into_iter().filter(|n| self.smooth_point(*n)).count()
    }

    fn smooth_point(&mut self, point: u32) -> bool {
        let star = self.star(point);
        let like = match (&star.line_points[..], &star.wall_points[..]) {
            ([], []) => &star.points,
            ([], walls) => walls,
            (lines, _) if lines.len() == 2 => lines,
            _ => return false,
        };
        let middle = like.iter().map(|n| self.place(*n)).sum::<DVec3>() / like.len() as f64;
        let now = self.place(point);
        let Some(way) = self.along_surfaces(point, middle - now) else { return false };
        let walls = self.crack_edges(point);
        let rate = |at: DVec3| {
            let cells = self.cells_of[point as usize].iter().map(|k| self.cells[*k as usize].corners);
            let shapes = cells.map(|c| shape(c.map(|n| if n == point { at } else { self.place(n) })));
            let area = |[p, q]: &[u32; 2]| 0.5 * (self.place(*p) - at).cross(self.place(*q) - at).length();
            (shapes.fold(f64::INFINITY, f64::min), walls.iter().map(area).sum::<f64>())
        };
        // Longest of three steps that improves the shapes or smooths the walls.
        let (worst, area) = rate(now);
        for step in [1.0, 0.5, 0.25] {
            let (shape, walls) = rate(now + step * way);
            let better = shape > 1.02 * worst && worst < GOOD;
            let smoother = walls < 0.99 * area && shape >= worst.min(GOOD);
            if (better || smoother) && shape > 0.0 && walls - area <= self.spare_area {
                self.spare_area -= walls - area;
                self.points[point as usize] = now + step * way;
                return true;
            }
        }
        false
    }

    /// The component of a displacement within the planes of the outer surface at a point, and of flat walls;
    /// `None` if there is none.
    fn along_surfaces(&self, point: u32, way: DVec3) -> Option<DVec3> {
        let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
        let outer = self.outer_of[point as usize].iter().map(|k| self.outer[*k as usize]);
        let mut marks = outer.clone().map(|o| o.1);
        let first = marks.next();
        if marks.any(|mark| Some(mark) != first) {
            return None;
        }
        let mut normals: Vec<DVec3> = outer.map(|o| normal(o.0.map(|n| self.place(n)))).collect();
        if self.walls == Walls::Flat {
            let walls = self.crack_edges(point).into_iter();
            normals.extend(walls.map(|[p, q]| normal([point, p, q].map(|n| self.place(n)))));
        }
        // Normals that differ less than this are equal.
        const SAME: f64 = 1e-10;
        let Some(first) = normals.first().copied() else { return Some(way) };
        let other = normals.iter().map(|n| first.cross(*n)).find(|axis| axis.length() > SAME);
        let Some(axis) = other else { return Some(way.reject_from(first)) };
        let axis = axis.normalize();
        let held = normals.iter().any(|n| n.dot(axis).abs() > SAME);
        (!held).then(|| way.project_onto(axis))
    }

    /// The edges whose triangles with a point are walls inside the body.
    fn crack_edges(&self, point: u32) -> Vec<[u32; 2]> {
        let sides = self.sides(point);
        let inner = sides.chunk_by(|a, b| a.0 == b.0).filter(|s| s.len() == 2 && s[0].1 != s[1].1);
        inner.map(|s| s[0].0).collect()
    }

    /// For each triangle at a point its opposite edge and the region of one of its sides, sorted.
    fn sides(&self, point: u32) -> Vec<([u32; 2], u32)> {
        let mut sides = Vec::with_capacity(3 * self.cells_of[point as usize].len());
        for k in &self.cells_of[point as usize] {
            let cell = &self.cells[*k as usize];
            let [a, b, c] = others(cell.corners, point);
            sides.extend([[a, b], [a, c], [b, c]].map(|edge| (edge, cell.region)));
        }
        sides.sort_unstable();
        sides
    }

    fn star(&self, point: u32) -> Star {
        let mut star = Star::default();
        for k in &self.cells_of[point as usize] {
            star.triangles.push(others(self.cells[*k as usize].corners, point));
        }
        star.triangles.sort_unstable();
        let mut outer: Vec<([u32; 2], bool)> = Vec::new();
        for k in &self.outer_of[point as usize] {
            let (corners, inside) = self.outer[*k as usize];
            let mut edge = [0; 2];
            corners.iter().filter(|n| **n != point).zip(&mut edge).for_each(|(n, e)| *e = *n);
            edge.sort_unstable();
            outer.push((edge, inside));
        }
        outer.sort_unstable();
        star.outer_edges = outer.iter().map(|o| o.0).collect();
        star.outer_points = points_of(&star.outer_edges);
        // Walls at each neighbour, with the regions on their sides.
        let mut walls: Vec<(u32, [u32; 2])> = Vec::new();
        for same in self.sides(point).chunk_by(|a, b| a.0 == b.0) {
            let edge = same[0].0;
            star.edges.push(edge);
            let between = match same {
                [a, b] => [a.1.min(b.1), a.1.max(b.1)],
                _ => {
                    let inside = outer.binary_search_by(|o| o.0.cmp(&edge)).is_ok_and(|k| outer[k].1);
                    [same[0].1, OUTSIDE + u32::from(inside)]
                }
            };
            if between[0] != between[1] {
                star.wall_edges.push(edge);
                walls.extend(edge.map(|n| (n, between)));
            }
        }
        star.points = points_of(&star.edges);
        walls.sort_unstable();
        for at in walls.chunk_by(|a, b| a.0 == b.0) {
            star.wall_points.push(at[0].0);
            if at.len() != 2 || at[0].1 != at[1].1 {
                star.line_points.push(at[0].0);
            }
        }
        star
    }

    /// Moves `from` onto `to`.
    fn merge(&mut self, from: u32, to: u32) {
        for k in std::mem::take(&mut self.cells_of[from as usize]) {
            let cell = &mut self.cells[k as usize];
            if cell.corners.contains(&to) {
                self.alive[k as usize] = false;
                let gone = cell.corners;
                for n in gone {
                    self.cells_of[n as usize].retain(|other| *other != k);
                }
            } else {
                cell.corners.iter_mut().filter(|n| **n == from).for_each(|n| *n = to);
                self.cells_of[to as usize].push(k);
                self.touched[k as usize] = true;
            }
        }
        for k in std::mem::take(&mut self.outer_of[from as usize]) {
            let corners = &mut self.outer[k as usize].0;
            if corners.contains(&to) {
                self.outer_alive[k as usize] = false;
                let gone = *corners;
                for n in gone {
                    self.outer_of[n as usize].retain(|other| *other != k);
                }
            } else {
                corners.iter_mut().filter(|n| **n == from).for_each(|n| *n = to);
                self.outer_of[to as usize].push(k);
            }
        }
    }
}
