//! Triangulation of a plane polygon with a given element size.
//!
//! Ear clipping gives an initial triangulation. Edges are flipped until it is Delaunay. Then the
//! circumcentres of triangles that are too large become new corners, except near the border, which stays
//! unchanged. Triangles keep a positive area despite rounding, because only convex pairs are flipped.
//!
//! Source: Lawson (1977) for the flips; Chew (1989), Ruppert (1995) for the circumcentres. Differs: the
//! border is never divided, because its edges already have the right size.

use glam::DVec2;

const NONE: u32 = u32::MAX;
/// Circumradius, relative to the target size, above which a triangle gets a new corner: 0.58 is that of an
/// equilateral triangle.
const TOO_LARGE: f64 = 0.85;
/// Largest ratio of circumradius to shortest edge: an angle of 21°.
const TOO_FLAT: f64 = 1.4;
/// Passes of smoothing.
const SMOOTHINGS: usize = 4;

/// Triangles, counter-clockwise, and the neighbour opposite each corner.
pub(in crate::modal_analysis) struct Triangulation {
    pub(in crate::modal_analysis) points: Vec<DVec2>,
    pub(in crate::modal_analysis) triangles: Vec<[u32; 3]>,
    neighbours: Vec<[u32; 3]>,
    border: usize,
}

/// Twice the area.
fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Fills a simple polygon, counter-clockwise, whose edges have about the length given by `size`; `None` if it
/// is not simple.
pub(in crate::modal_analysis) fn fill(
    polygon: &[DVec2],
    size: &dyn Fn(DVec2) -> f64,
) -> Option<Triangulation> {
    let triangles = clip_ears(polygon)?;
    let mut mesh = Triangulation {
        points: polygon.to_vec(),
        neighbours: neighbours(&triangles),
        triangles,
        border: polygon.len(),
    };
    let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    mesh.flip_all(all);
    mesh.refine(size);
    for _ in 0..SMOOTHINGS {
        mesh.smooth();
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        mesh.flip_all(all);
    }
    Some(mesh)
}

fn clip_ears(polygon: &[DVec2]) -> Option<Vec<[u32; 3]>> {
    let mut ring: Vec<u32> = (0..polygon.len() as u32).collect();
    let mut triangles = Vec::with_capacity(polygon.len());
    let at = |n: u32| polygon[n as usize];
    let (mut k, mut failures) = (0, 0);
    // Cut off convex corners whose triangle contains no other vertex.
    while ring.len() > 3 {
        let count = ring.len();
        if failures > count {
            return None;
        }
        k %= count;
        let corners = [ring[(k + count - 1) % count], ring[k], ring[(k + 1) % count]];
        let [a, b, c] = corners.map(at);
        let size = (b - a).length_squared().max((c - b).length_squared());
        let within = |n: &u32| {
            let p = at(*n);
            let least = -1e-12 * size;
            !corners.contains(n) && area(a, b, p) >= least && area(b, c, p) >= least && area(c, a, p) >= least
        };
        if area(a, b, c) > 1e-9 * size && !ring.iter().any(within) {
            triangles.push(corners);
            ring.remove(k);
            failures = 0;
            // Skip the next corner, so that ears do not form a fan.
            k += 1;
        } else {
            k += 1;
            failures += 1;
        }
    }
    let last = [ring[0], ring[1], ring[2]];
    let [a, b, c] = last.map(at);
    triangles.push(last);
    (area(a, b, c) > 0.0).then_some(triangles)
}

fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * triangles.len());
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            sides.push(([a.min(b), a.max(b)], t as u32, k));
        }
    }
    sides.sort_unstable();
    let mut neighbours = vec![[NONE; 3]; triangles.len()];
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let ((_, s, i), (_, t, k)) = (pair[0], pair[1]);
        neighbours[s as usize][i] = t;
        neighbours[t as usize][k] = s;
    }
    neighbours
}

/// Centre and radius of the circle through three points.
fn circle([a, b, c]: [DVec2; 3]) -> (DVec2, f64) {
    let (u, v) = (b - a, c - a);
    let twice = 2.0 * u.perp_dot(v);
    let offset = DVec2::new(
        v.y * u.length_squared() - u.y * v.length_squared(),
        u.x * v.length_squared() - v.x * u.length_squared(),
    ) / twice;
    (a + offset, offset.length())
}

impl Triangulation {
    fn corners(&self, t: u32) -> [DVec2; 3] {
        self.triangles[t as usize].map(|n| self.points[n as usize])
    }

    /// Flips edges of these triangles, and of those that this changes, until all are Delaunay's.
    fn flip_all(&mut self, mut stack: Vec<u32>) {
        // A bound that rounding cannot exceed indefinitely.
        let mut left = 100 * (stack.len() + self.triangles.len());
        while let Some(t) = stack.pop() {
            for k in 0..3 {
                let across = self.neighbours[t as usize][k];
                if left > 0 && self.flip(t, k) {
                    left -= 1;
                    let around = [t, across].map(|t| self.neighbours[t as usize]);
                    stack.extend(around.into_iter().flatten().filter(|n| *n != NONE));
                    stack.extend([t, across]);
                    break;
                }
            }
        }
    }

    /// Flips the edge opposite corner k if that is closer to Delaunay.
    fn flip(&mut self, t: u32, k: usize) -> bool {
        let s = self.neighbours[t as usize][k];
        if s == NONE {
            return false;
        }
        let own = self.triangles[t as usize];
        let other = self.triangles[s as usize];
        let Some(j) = (0..3).find(|j| self.neighbours[s as usize][*j] == t) else { return false };
        // The two triangles must form a convex quadrangle.
        let [a, b, c, d] = [own[k], own[(k + 1) % 3], own[(k + 2) % 3], other[j]];
        let [pa, pb, pc, pd] = [a, b, c, d].map(|n| self.points[n as usize]);
        let scale = (pc - pb).length_squared();
        if area(pa, pb, pd) <= 1e-9 * scale || area(pa, pd, pc) <= 1e-9 * scale {
            return false;
        }
        // Delaunay test: the angles at a and d sum to more than π, sin(α + δ) < 0.
        let (ab, ac, db, dc) = (pb - pa, pc - pa, pb - pd, pc - pd);
        let (cos_a, sin_a) = (ab.dot(ac), ab.perp_dot(ac));
        let (cos_d, sin_d) = (dc.dot(db), dc.perp_dot(db));
        if sin_a * cos_d + cos_a * sin_d >= -1e-10 * scale * scale {
            return false;
        }
        // Replace both triangles and relink the neighbours.
        let beyond = |t: u32, k: usize| self.neighbours[t as usize][k];
        let (t_b, t_c) = (beyond(t, (k + 1) % 3), beyond(t, (k + 2) % 3));
        // In s the corners run d, c, b.
        let (s_c, s_b) = (beyond(s, (j + 1) % 3), beyond(s, (j + 2) % 3));
        self.triangles[t as usize] = [a, b, d];
        self.neighbours[t as usize] = [s_c, s, t_c];
        self.triangles[s as usize] = [a, d, c];
        self.neighbours[s as usize] = [s_b, t_b, t];
        self.relink(s_c, s, t);
        self.relink(t_b, t, s);
        true
    }

    fn relink(&mut self, t: u32, from: u32, to: u32) {
        if t != NONE {
            for n in &mut self.neighbours[t as usize] {
                if *n == from {
                    *n = to;
                }
            }
        }
    }

    /// The triangle that contains a point, walking from another; `None` if the border intervenes.
    fn walk(&self, from: u32, to: DVec2) -> Option<u32> {
        let mut t = from;
        for _ in 0..self.triangles.len() {
            let corners = self.corners(t);
            let side = |k: usize| area(corners[(k + 1) % 3], corners[(k + 2) % 3], to);
            let k = (0..3).min_by(|i, k| side(*i).total_cmp(&side(*k)))?;
            if side(k) >= 0.0 {
                return Some(t);
            }
            t = self.neighbours[t as usize][k];
            if t == NONE {
                return None;
            }
        }
        None
    }

    /// Inserts corners until all triangles meet the size and shape limits.
    fn refine(&mut self, size: &dyn Fn(DVec2) -> f64) {
        let mut stack: Vec<u32> = (0..self.triangles.len() as u32).collect();
        while let Some(t) = stack.pop() {
            let corners = self.corners(t);
            let (centre, radius) = circle(corners);
            let [a, b, c] = corners;
            let shortest = (b - a).length().min((c - b).length()).min((a - c).length());
            let wanted = size((a + b + c) / 3.0);
            let bad =
                radius > TOO_LARGE * wanted || (radius > TOO_FLAT * shortest && shortest > 0.3 * wanted);
            if !bad {
                continue;
            }
            let Some(place) = self.walk(t, centre) else { continue };
            if self.crowds(place, centre, wanted) {
                continue;
            }
            let first = self.triangles.len() as u32;
            self.split(place, centre);
            let touched = [place, first, first + 1];
            self.flip_all(touched.to_vec());
            stack.extend([t, place, first, first + 1]);
            stack.extend(touched.iter().flat_map(|t| self.neighbours[*t as usize]).filter(|n| *n != NONE));
        }
    }

    /// Whether a point in a triangle is too close to the border or to a corner.
    fn crowds(&self, t: u32, point: DVec2, wanted: f64) -> bool {
        let near = |t: u32| {
            (0..3).any(|k| {
                let [own, from, to] = [0, 1, 2].map(|i| self.triangles[t as usize][(k + i) % 3] as usize);
                let [own, from, to] = [own, from, to].map(|n| self.points[n]);
                let facing = self.neighbours[t as usize][k] == NONE
                    && point.distance_squared(0.5 * (from + to)) < 0.25 * from.distance_squared(to);
                facing || point.distance(own) < 0.35 * wanted.min(from.distance(to))
            })
        };
        near(t) || self.neighbours[t as usize].iter().any(|n| *n != NONE && near(*n))
    }

    /// Splits a triangle into three.
    fn split(&mut self, t: u32, point: DVec2) {
        let p = self.points.len() as u32;
        self.points.push(point);
        let ([a, b, c], [na, nb, nc]) = (self.triangles[t as usize], self.neighbours[t as usize]);
        let (u, v) = (self.triangles.len() as u32, self.triangles.len() as u32 + 1);
        self.triangles[t as usize] = [p, a, b];
        self.neighbours[t as usize] = [nc, u, v];
        self.triangles.extend([[p, b, c], [p, c, a]]);
        self.neighbours.extend([[na, v, t], [nb, t, u]]);
        self.relink(na, t, u);
        self.relink(nb, t, v);
    }

    /// Moves inner corners to the mean of their neighbours where no triangle degrades.
    fn smooth(&mut self) {
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            corners.iter().for_each(|n| around[*n as usize].push(t as u32));
        }
        let roundness = |[a, b, c]: [DVec2; 3]| {
            let edges = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
            area(a, b, c) / edges
        };
        for (n, around) in around.iter().enumerate().skip(self.border) {
            let worst = |mesh: &Self| {
                around.iter().map(|t| roundness(mesh.corners(*t))).fold(f64::INFINITY, f64::min)
            };
            let (before, old) = (worst(self), self.points[n]);
            // Every neighbour occurs twice.
            let others = around.iter().flat_map(|t| self.triangles[*t as usize]).filter(|m| *m as usize != n);
            let (sum, count) =
                others.fold((DVec2::ZERO, 0.0), |(s, c), m| (s + self.points[m as usize], c + 1.0));
            self.points[n] = sum / count;
            if worst(self) < before {
                self.points[n] = old;
            }
        }
    }
}
