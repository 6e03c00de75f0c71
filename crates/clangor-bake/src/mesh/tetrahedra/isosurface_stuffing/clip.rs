//! The part of a tetrahedron on the inner side of a surface, divided into tetrahedra.
//!
//! The part is a convex polyhedron with triangular and quadrangular faces. A quadrangle on a face of the
//! tetrahedron belongs to two neighbours, so its diagonal must be the same for both: the shorter one. The
//! polyhedron is a fan from one of its corners if that gives no flat piece, otherwise from a new point in its
//! middle.

use glam::DVec3;

use crate::mesh::tetrahedra::FACES;

/// Points and tetrahedra of the clipped grid.
pub(super) struct Clipped {
    pub(super) points: Vec<DVec3>,
    pub(super) tetrahedra: Vec<[u32; 4]>,
}

impl Clipped {
    /// Without points that no tetrahedron uses.
    pub(super) fn compact(self) -> Self {
        let mut number = vec![u32::MAX; self.points.len()];
        let mut points = Vec::new();
        let mut tetrahedra = self.tetrahedra;
        for corner in tetrahedra.iter_mut().flatten() {
            let old = *corner as usize;
            if number[old] == u32::MAX {
                number[old] = points.len() as u32;
                points.push(self.points[old]);
            }
            *corner = number[old];
        }
        Clipped { points, tetrahedra }
    }

    /// Drops tetrahedra whose smallest height is less than `height` \[m\].
    pub(super) fn drop_flatter_than(&mut self, height: f64) {
        let points = &self.points;
        self.tetrahedra.retain(|t| {
            let corners = t.map(|n| points[n as usize]);
            let [a, b, c, d] = corners;
            let volume = (b - a).cross(c - a).dot(d - a).abs();
            let base = FACES.map(|f| {
                let [a, b, c] = f.map(|k| corners[k]);
                (b - a).cross(c - a).length()
            });
            volume >= height * base.into_iter().fold(0.0, f64::max)
        });
    }

    fn distance(&self, a: u32, b: u32) -> f64 {
        self.points[a as usize].distance_squared(self.points[b as usize])
    }

    /// The two triangles of a quadrangle, or the triangle itself.
    fn triangles(&self, face: &[u32]) -> Vec<[u32; 3]> {
        match *face {
            [a, b, c] => vec![[a, b, c]],
            [a, b, c, d] => {
                let (ac, bd) = (self.distance(a, c), self.distance(b, d));
                // Equal lengths up to rounding: the diagonal with the smallest number.
                let even = (ac - bd).abs() <= 1e-9 * (ac + bd);
                let first = if even { a.min(c) < b.min(d) } else { ac < bd };
                if first { vec![[a, b, c], [a, c, d]] } else { vec![[b, c, d], [b, d, a]] }
            }
            _ => Vec::new(),
        }
    }
}

/// Adds the part of a tetrahedron where `depth` is positive. `cut` returns the point on the edge from an
/// inner to an outer corner.
pub(super) fn inner_part(
    clipped: &mut Clipped,
    corners: [u32; 4],
    depth: [f64; 4],
    cut: &impl Fn(u32, u32) -> u32,
) {
    if depth.iter().all(|d| *d <= 0.0) {
        return;
    }
    if depth.iter().all(|d| *d >= 0.0) {
        clipped.tetrahedra.push(corners);
        return;
    }
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    // Segments of the section with the surface, one on each face that it crosses.
    let mut section: Vec<[u32; 2]> = Vec::new();
    // Clip each face to its inner polygon.
    for face in FACES {
        let mut polygon: Vec<u32> = Vec::new();
        let mut on_surface: Vec<u32> = Vec::new();
        for k in 0..3 {
            let (i, j) = (face[k], face[(k + 1) % 3]);
            if depth[i] >= 0.0 {
                polygon.push(corners[i]);
            }
            if depth[i] == 0.0 {
                on_surface.push(corners[i]);
            }
            if depth[i] * depth[j] < 0.0 {
                let point =
                    if depth[i] > 0.0 { cut(corners[i], corners[j]) } else { cut(corners[j], corners[i]) };
                polygon.push(point);
                on_surface.push(point);
            }
        }
        if face.iter().any(|k| depth[*k] > 0.0) {
            triangles.extend(clipped.triangles(&polygon));
        }
        if let [a, b] = on_surface[..] {
            section.push([a.min(b), a.max(b)]);
        }
    }
    // Close the polyhedron with the section, and divide it.
    section.sort_unstable();
    section.dedup();
    if let Some(ring) = ring_of(&section) {
        triangles.extend(clipped.triangles(&ring));
    }
    fan(clipped, &triangles);
}

/// The points of a closed chain of edges, in order.
fn ring_of(edges: &[[u32; 2]]) -> Option<Vec<u32>> {
    let mut ring = vec![edges.first()?[0], edges[0][1]];
    while ring.len() < edges.len() {
        let (last, before) = (ring[ring.len() - 1], ring[ring.len() - 2]);
        let next = edges.iter().find_map(|[a, b]| match (*a == last, *b == last) {
            (true, _) if *b != before => Some(*b),
            (_, true) if *a != before => Some(*a),
            _ => None,
        })?;
        ring.push(next);
    }
    Some(ring)
}

/// Divides a convex body with triangulated surface.
fn fan(clipped: &mut Clipped, triangles: &[[u32; 3]]) {
    let mut corners: Vec<u32> = triangles.iter().flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    let volume = |clipped: &Clipped, apex: DVec3, [a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|n| clipped.points[n as usize] - apex);
        a.dot(b.cross(c)).abs()
    };
    // Apex whose flattest tetrahedron is thickest. Triangles coplanar with a corner give no volume, and
    // exclude it as apex unless they contain it.
    let best = corners
        .iter()
        .map(|apex| {
            let place = clipped.points[*apex as usize];
            let pieces = triangles.iter().filter(|t| !t.contains(apex));
            (pieces.map(|t| volume(clipped, place, *t)).fold(f64::INFINITY, f64::min), *apex)
        })
        .fold((0.0, u32::MAX), |best, next| if next.0 > best.0 { next } else { best });
    let size = triangles.iter().map(|[a, b, _]| clipped.distance(*a, *b)).fold(0.0, f64::max).powf(1.5);
    // If no corner serves, a new point in the middle.
    let apex = if best.0 > 1e-6 * size {
        best.1
    } else {
        let middle =
            corners.iter().map(|n| clipped.points[*n as usize]).sum::<DVec3>() / corners.len() as f64;
        clipped.points.push(middle);
        clipped.points.len() as u32 - 1
    };
    for t in triangles.iter().filter(|t| !t.contains(&apex)) {
        clipped.tetrahedra.push([t[0], t[1], t[2], apex]);
    }
}
