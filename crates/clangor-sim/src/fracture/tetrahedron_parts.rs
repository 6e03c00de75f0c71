//! The parts of one tetrahedron whose corners belong to several regions, and the walls between them.
//!
//! With barycentric coordinates λ the part of region A contains the points at which its corners have the
//! largest total weight:
//!
//! ```text
//! S_A(λ) = Σ_{k in A} λ_k,      part of A = { λ : S_A ≥ S_B for every other region B }
//! ```
//!
//! Each part is a convex polyhedron. Its vertices are its own corners, the middles of edges between two
//! regions, the centroids of faces between three, and the centroid of the tetrahedron between four; its faces
//! are triangles and flat quadrangles. Two tetrahedra have the same polygons on a shared face. A convex
//! polyhedron is divided by the fan from its vertex of lowest number, and each of its quadrangles by the
//! diagonal from the quadrangle's vertex of lowest number. On its own faces the fan does the same, so
//! neighbours agree.
//!
//! With two regions the cut points may lie anywhere on the edges, and the division stays valid.

use clangor_bake::mesh::tetrahedra::FACES;

/// A point of a tetrahedron: bit k is set if corner k is one of those whose centroid it is.
pub(super) type PointMask = u8;

/// A triangle or quadrangle, its points in order around it; empty if the part has no polygon there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Polygon {
    points: [PointMask; 4],
    count: usize,
}

impl Polygon {
    fn push(&mut self, point: PointMask) {
        self.points[self.count] = point;
        self.count += 1;
    }

    pub(super) fn points(&self) -> &[PointMask] {
        &self.points[..self.count]
    }
}

/// The part of a region on one face, counter-clockwise seen from outside.
pub(super) fn face_polygon(face: [usize; 3], regions: [u32; 4], region: u32) -> Polygon {
    let mut polygon = Polygon::default();
    let [a, b, c] = face.map(|k| regions[k]);
    if ![a, b, c].contains(&region) {
        return polygon;
    }
    let three = a != b && b != c && c != a;
    for k in 0..3 {
        let (p, q) = (face[k], face[(k + 1) % 3]);
        let (own, next) = (regions[p] == region, regions[q] == region);
        if own {
            polygon.push(1 << p);
        }
        if own != next {
            polygon.push(1 << p | 1 << q);
        } else if three && !own {
            polygon.push(1 << face[0] | 1 << face[1] | 1 << face[2]);
        }
    }
    polygon
}

/// The wall between two regions of a tetrahedron; its points run around it in either sense.
pub(super) fn wall(regions: [u32; 4], a: u32, b: u32) -> Polygon {
    let mut polygon = Polygon::default();
    let of = |region: u32| (0..4).filter(move |k| regions[*k] == region).map(|k| 1_u8 << k);
    let mut others = (0..4).filter(|k| regions[*k] != a && regions[*k] != b).map(|k| 1_u8 << k);
    let (few, many) = if of(a).count() <= of(b).count() { (a, b) } else { (b, a) };
    let (mut few, mut many) = (of(few), of(many));
    let (Some(p), Some(q)) = (few.next(), many.next()) else { return polygon };
    match (few.next(), many.next(), many.next()) {
        // One corner against three.
        (None, Some(r), Some(s)) => [p | q, p | r, p | s].into_iter().for_each(|m| polygon.push(m)),
        // Two against two.
        (Some(o), Some(r), _) => {
            [p | q, o | q, o | r, p | r].into_iter().for_each(|m| polygon.push(m));
        }
        // One against two, and a third region.
        (None, Some(r), None) => {
            let third = others.next().unwrap_or(0);
            [p | q, p | r, p | r | third, p | q | third].into_iter().for_each(|m| polygon.push(m));
        }
        // One against one.
        _ => {
            polygon.push(p | q);
            if let (Some(r), Some(s)) = (others.next(), others.next()) {
                polygon.push(p | q | r);
                // The other two corners belong to one region or two; only for two is there an inner point.
                if regions[r.trailing_zeros() as usize] != regions[s.trailing_zeros() as usize] {
                    polygon.push(p | q | r | s);
                }
                polygon.push(p | q | s);
            }
        }
    }
    polygon
}

/// The regions of a tetrahedron, each once, in the order of its corners.
pub(super) fn distinct(regions: [u32; 4]) -> impl Iterator<Item = u32> {
    (0..4).filter(move |k| !regions[..*k].contains(&regions[*k])).map(move |k| regions[k])
}

/// The share of each corner's region in the volume; corners of the same region have the same number.
pub(super) fn shares(regions: [u32; 4]) -> [f64; 4] {
    let count = distinct(regions).count();
    regions.map(|region| {
        let own = regions.iter().filter(|r| **r == region).count();
        match (count, own) {
            (1, _) => 1.0,
            (2, 1) => 0.125,
            (2, 2) => 0.5,
            (2, _) => 0.875,
            // P(λ_c > λ_a + λ_b and λ_c > λ_d) for a point drawn evenly from the tetrahedron.
            (3, 1) => 7.0 / 36.0,
            (3, _) => 11.0 / 18.0,
            _ => 0.25,
        }
    })
}

/// Triangles of a polygon whose points have `number`s: the fan from the least.
pub(super) fn triangles(polygon: &Polygon, number: impl Fn(PointMask) -> u32) -> Vec<[u32; 3]> {
    let ring: Vec<u32> = polygon.points().iter().map(|p| number(*p)).collect();
    let Some(start) = (0..ring.len()).min_by_key(|k| ring[*k]) else { return Vec::new() };
    let at = |k: usize| ring[(start + k) % ring.len()];
    (1..ring.len() - 1).map(|k| [at(0), at(k), at(k + 1)]).collect()
}

/// Tetrahedra of a region's part, in either sense.
pub(super) fn tetrahedra(regions: [u32; 4], region: u32, number: impl Fn(PointMask) -> u32) -> Vec<[u32; 4]> {
    let on_faces = FACES.into_iter().map(|face| face_polygon(face, regions, region));
    let walls = distinct(regions).filter(|other| *other != region).map(|other| wall(regions, region, other));
    let polygons: Vec<Polygon> = on_faces.chain(walls).filter(|p| p.count > 0).collect();
    let numbers = polygons.iter().flat_map(|p| p.points()).map(|p| number(*p));
    let Some(apex) = numbers.min() else { return Vec::new() };
    let away = polygons.iter().filter(|p| p.points().iter().all(|point| number(*point) != apex));
    away.flat_map(|p| triangles(p, &number)).map(|[a, b, c]| [apex, a, b, c]).collect()
}

#[cfg(test)]
mod tests {
    use clangor_core::glam::DVec3;

    use super::*;

    const CORNERS: [DVec3; 4] =
        [DVec3::ZERO, DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.2, 0.9, 0.1), DVec3::new(0.1, 0.3, 0.8)];

    fn place(mask: PointMask) -> DVec3 {
        let own = (0..4).filter(|k| mask >> k & 1 == 1);
        own.map(|k| CORNERS[k]).sum::<DVec3>() / f64::from(mask.count_ones())
    }

    /// Every division of four corners into regions, and every order of the numbers that matters to the fans.
    #[test]
    fn parts_fill_the_tetrahedron_in_their_shares() {
        let [a, b, c, d] = CORNERS;
        let whole = (b - a).cross(c - a).dot(d - a);
        for code in 0..256_u32 {
            let regions: [u32; 4] = std::array::from_fn(|k| code >> (2 * k) & 3);
            for turn in 0..16_u32 {
                // Corners first, as in a mesh, but within each kind in any order.
                let number = |mask: PointMask| 32 * mask.count_ones() + (u32::from(mask) ^ turn);
                let mut sum = 0.0;
                for region in distinct(regions) {
                    let mut part = 0.0;
                    for corners in tetrahedra(regions, region, number) {
                        let back = |n: u32| ((n % 32) ^ turn) as PointMask;
                        let [p, q, r, s] = corners.map(|n| place(back(n)));
                        part += (q - p).cross(r - p).dot(s - p).abs();
                    }
                    let corner = regions.iter().position(|r| *r == region).unwrap();
                    // Seen: 2e-16.
                    assert!((part / whole - shares(regions)[corner]).abs() < 1e-14, "{regions:?}");
                    sum += part;
                }
                assert!((sum / whole - 1.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn walls_are_flat() {
        for code in 0..256_u32 {
            let regions: [u32; 4] = std::array::from_fn(|k| code >> (2 * k) & 3);
            for a in distinct(regions) {
                for b in distinct(regions).filter(|b| *b != a) {
                    let points: Vec<DVec3> = wall(regions, a, b).points().iter().map(|m| place(*m)).collect();
                    assert!(points.len() >= 3);
                    if let [p, q, r, s] = points[..] {
                        // Seen: 1e-17.
                        assert!((q - p).cross(r - p).dot(s - p).abs() < 1e-14);
                    }
                }
            }
        }
    }
}
