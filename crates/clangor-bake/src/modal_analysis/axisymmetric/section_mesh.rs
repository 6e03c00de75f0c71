//! The section of an axisymmetric body as quadratic triangles with edges along its curve.
//!
//! Elements have the requested size, at most the local thickness of the wall, so that at least one spans it.
//! Sizes vary gradually.

use clangor_core::geometry::meridian::{Meridian, Piece};
use glam::DVec2;

use super::triangulation::{Triangulation, fill};

/// Growth of the size per distance.
const GROWTH: f64 = 0.35;
/// Longest edge over the radius of curvature.
const CHORD: f64 = 0.7;
/// Shortest edges, at sharp corners, over the median thickness.
const LEAST_WALL: f64 = 0.15;
/// Elements whose Jacobian falls below this fraction of the straight element's keep straight edges.
const LEAST_CURVED: f64 = 0.3;

/// Dense sample points on the curve, for measurements.
const MEASURES: usize = 48;

/// Quadratic triangles; coordinates are (r, y).
#[derive(Clone, Debug)]
pub(crate) struct SectionMesh {
    /// Positions \[m\].
    pub(crate) nodes: Vec<DVec2>,
    /// Corners counter-clockwise, then the middles of edges 0–1, 1–2, 2–0.
    pub(crate) elements: Vec<[u32; 6]>,
    /// Edges along the curve, in its order.
    pub(crate) border: Vec<BorderEdge>,
}

/// An edge of the section that lies on a piece of the meridian.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BorderEdge {
    /// Which piece.
    pub(crate) piece: usize,
    /// Its parameter at the ends.
    pub(crate) range: [f64; 2],
    /// Nodes at the start, in the middle, at the end.
    pub(crate) nodes: [u32; 3],
}

/// A sample on the curve with its size.
struct Measure {
    point: DVec2,
    /// Length of edges \[m\].
    size: f64,
}

/// Lengths of edges.
struct Sizes {
    /// As many on each piece, evenly spaced in its parameter.
    measures: Vec<Measure>,
    most: f64,
    fineness: f64,
}

impl Sizes {
    /// `most` \[m\] where no other limit applies; all multiplied by `fineness`.
    fn of(pieces: &[Piece], most: f64, fineness: f64) -> Self {
        let walls = walls(pieces);
        let least = LEAST_WALL * quantile(&walls, 0.5).min(most);
        let measure = |(k, wall): (usize, &f64)| {
            let (piece, t) = place(pieces, k);
            let size = (CHORD * piece.curvature_radius(t)).min(*wall).min(most).max(least);
            Measure { point: piece.point(t), size }
        };
        let mut measures: Vec<Measure> = walls.iter().enumerate().map(measure).collect();
        let graded: Vec<f64> = measures.iter().map(|m| graded(&measures, m.point)).collect();
        measures.iter_mut().zip(graded).for_each(|(m, size)| m.size = size);
        Sizes { measures, most, fineness }
    }

    fn at(&self, point: DVec2) -> f64 {
        self.fineness * graded(&self.measures, point).min(self.most)
    }

    /// Parameters at which a piece is cut, both ends included.
    fn cuts(&self, piece: usize, curve: &Piece) -> Vec<f64> {
        let own = &self.measures[piece * MEASURES..(piece + 1) * MEASURES];
        let lengths = (0..MEASURES).map(|k| {
            let [a, b] = [k, k + 1].map(|k| k as f64 / MEASURES as f64);
            curve.length(a, b) / (self.fineness * own[k].size)
        });
        let sums: Vec<f64> = std::iter::once(0.0)
            .chain(lengths.scan(0.0, |sum, length| {
                *sum += length;
                Some(*sum)
            }))
            .collect();
        let total = sums[MEASURES];
        let count = (total - 1e-6).ceil().max(1.0) as usize;
        (0..=count)
            .map(|n| {
                let wanted = total * n as f64 / count as f64;
                let k = sums.partition_point(|s| *s < wanted).clamp(1, MEASURES);
                let within = (wanted - sums[k - 1]) / (sums[k] - sums[k - 1]);
                ((k - 1) as f64 + within.clamp(0.0, 1.0)) / MEASURES as f64
            })
            .collect()
    }
}

fn graded(measures: &[Measure], point: DVec2) -> f64 {
    measures.iter().map(|m| m.size + GROWTH * m.point.distance(point)).fold(f64::INFINITY, f64::min)
}

/// Thickness that all but 2 % of the curve exceed \[m\].
pub(super) fn wall(meridian: &Meridian) -> f64 {
    quantile(&walls(&closed(meridian)), 0.02)
}

/// The pieces, and the axis between their ends.
fn closed(meridian: &Meridian) -> Vec<Piece> {
    let mut pieces = meridian.pieces().to_vec();
    if !meridian.is_loop() {
        let (from, to) = (pieces[pieces.len() - 1].point(1.0), pieces[0].point(0.0));
        pieces.push(Piece::Line { from, to });
    }
    pieces
}

/// The piece and parameter of a sample.
fn place(pieces: &[Piece], measure: usize) -> (&Piece, f64) {
    (&pieces[measure / MEASURES], ((measure % MEASURES) as f64 + 0.5) / MEASURES as f64)
}

/// Thickness behind each sample of the curve \[m\].
fn walls(pieces: &[Piece]) -> Vec<f64> {
    let chords: Vec<[DVec2; 2]> = pieces
        .iter()
        .flat_map(|piece| {
            let count = if matches!(piece, Piece::Line { .. }) { 1 } else { MEASURES };
            (0..count).map(move |k| [k, k + 1].map(|k| piece.point(k as f64 / count as f64)))
        })
        .collect();
    (0..pieces.len() * MEASURES)
        .map(|k| {
            let (piece, t) = place(pieces, k);
            first_hit(&chords, piece.point(t), piece.velocity(t).normalize_or_zero().perp())
        })
        .collect()
}

fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((part * sorted.len() as f64) as usize).copied().unwrap_or(f64::INFINITY)
}

/// Distance to the first chord along a direction.
fn first_hit(chords: &[[DVec2; 2]], from: DVec2, direction: DVec2) -> f64 {
    chords
        .iter()
        .filter_map(|[a, b]| {
            let (u, v) = (*b - *a, *a - from);
            let cross = direction.perp_dot(u);
            // Only chords of opposite direction, across the material.
            if cross <= 1e-9 * u.length() {
                return None;
            }
            let (distance, along) = (v.perp_dot(u) / cross, v.perp_dot(direction) / cross);
            (distance > 1e-9 && (0.0..=1.0).contains(&along)).then_some(distance)
        })
        .fold(f64::INFINITY, f64::min)
}

impl SectionMesh {
    /// A mesh with edges of at most `most` \[m\] and at most the wall thickness, all times `fineness`; `None`
    /// if the curve intersects itself.
    pub(crate) fn new(meridian: &Meridian, most: f64, fineness: f64) -> Option<Self> {
        let (pieces, on_curve) = (closed(meridian), meridian.pieces().len());
        let sizes = Sizes::of(&pieces, most, fineness);
        // Boundary polygon, with the piece and parameters of each edge.
        let mut polygon = Vec::new();
        let mut ranges: Vec<(usize, [f64; 2])> = Vec::new();
        for (k, piece) in pieces.iter().enumerate() {
            for range in sizes.cuts(k, piece).windows(2) {
                polygon.push(piece.point(range[0]));
                ranges.push((k, [range[0], range[1]]));
            }
        }
        // Triangulate, then place midpoints on the curve.
        let Triangulation { points, triangles, .. } = fill(&polygon, &|p| sizes.at(p))?;
        let count = polygon.len();
        let middle_of = |edge: [u32; 2]| {
            let [a, b] = edge.map(|n| n as usize);
            let straight = 0.5 * (points[a] + points[b]);
            // An edge of the polygon has consecutive ends.
            let start = if b == a + 1 { Some(a) } else { (a == 0 && b + 1 == count).then_some(b) };
            match start.filter(|_| b < count) {
                Some(start) => {
                    let (piece, [from, to]) = ranges[start];
                    pieces[piece].point(0.5 * (from + to))
                }
                None => straight,
            }
        };
        let mut mesh = quadratic(&points, &triangles, middle_of);
        // Border edges with their nodes.
        mesh.border = (0..count)
            .filter(|k| ranges[*k].0 < on_curve)
            .map(|k| {
                let ends = [k as u32, ((k + 1) % count) as u32];
                let (piece, range) = ranges[k];
                BorderEdge { piece, range, nodes: [ends[0], mesh.middle(ends), ends[1]] }
            })
            .collect();
        Some(mesh)
    }

    /// Positions of an element's nodes \[m\].
    pub(crate) fn positions(&self, element: usize) -> [DVec2; 6] {
        self.elements[element].map(|n| self.nodes[n as usize])
    }

    /// The node between two corners that share an edge.
    fn middle(&self, [a, b]: [u32; 2]) -> u32 {
        let found = self.elements.iter().find_map(|e| {
            (0..3).find_map(|k| {
                let pair = [e[k], e[(k + 1) % 3]];
                (pair == [a, b] || pair == [b, a]).then_some(e[3 + k])
            })
        });
        found.unwrap_or(a)
    }
}

/// Triangles with mid-edge nodes. Elements that curved edges would invert keep straight edges.
fn quadratic(points: &[DVec2], triangles: &[[u32; 3]], middle: impl Fn([u32; 2]) -> DVec2) -> SectionMesh {
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| [a.min(b), a.max(b)]);
    // Unique edges and their midpoints.
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(sides).collect();
    edges.sort_unstable();
    edges.dedup();
    let mut nodes = points.to_vec();
    nodes.extend(edges.iter().map(|e| middle(*e)));
    let number = |edge: [u32; 2]| (points.len() + edges.partition_point(|e| *e < edge)) as u32;
    let elements: Vec<[u32; 6]> = triangles
        .iter()
        .map(|t| {
            let middles = sides(t).map(number);
            std::array::from_fn(|k| if k < 3 { t[k] } else { middles[k - 3] })
        })
        .collect();
    // Straighten elements with a small Jacobian.
    for element in &elements {
        let nodes_of = |nodes: &[DVec2]| element.map(|n| nodes[n as usize]);
        let own = nodes_of(&nodes);
        let straight = (own[1] - own[0]).perp_dot(own[2] - own[0]);
        let places = (0..6).map(|k| -> [f64; 3] {
            std::array::from_fn(|i| match k < 3 {
                true => f64::from(u8::from(i == k)),
                false => 0.5 * f64::from(u8::from(i == k - 3 || i == (k - 2) % 3)),
            })
        });
        let least = places.map(|at| super::section_element::jacobian(&own, at).determinant());
        if least.fold(f64::INFINITY, f64::min) < LEAST_CURVED * straight {
            for k in 0..3 {
                nodes[element[3 + k] as usize] = 0.5 * (own[k] + own[(k + 1) % 3]);
            }
        }
    }
    SectionMesh { nodes, elements, border: Vec::new() }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use clangor_core::shape::Shape;

    use super::super::section_element::{jacobian, shapes};
    use super::*;
    use crate::quadrature::TRIANGLE_FIFTH_DEGREE;

    /// Volume of the body, and the smallest angle between edges [rad].
    fn measure(mesh: &SectionMesh) -> (f64, f64) {
        let (mut volume, mut smallest) = (0.0, f64::INFINITY);
        for e in 0..mesh.elements.len() {
            let nodes = mesh.positions(e);
            for (at, weight) in TRIANGLE_FIFTH_DEGREE {
                let r: f64 = nodes.iter().zip(shapes(at)).map(|(x, n)| x.x * n).sum();
                volume += TAU * r * weight * 0.5 * jacobian(&nodes, at).determinant();
            }
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|i| nodes[(k + i) % 3]);
                smallest = f64::min(smallest, (b - a).angle_to(c - a));
            }
        }
        (volume, smallest)
    }

    #[test]
    fn sections_are_filled_with_well_shaped_triangles() {
        for shape in [
            "sphere:0.02",
            "coin",
            "cylinder:0.01x0.2",
            "torus:0.05x0.01",
            "bowl",
            "plate",
            "wineglass",
            "moneybox",
        ] {
            let meridian = Shape::parse(shape).unwrap().meridian().unwrap();
            for fineness in [1.0, 0.5, 0.2] {
                let mesh = SectionMesh::new(&meridian, 0.01, fineness).expect("a section");
                let (volume, angle) = measure(&mesh);
                let error = (volume / meridian.volume() - 1.0).abs();
                // Seen: 1e-4 on a tenth of the sphere's elements, 3e-4 on the torus; angles from 0.46.
                assert!(
                    error < 2e-3 * fineness.powi(4) && angle > 0.2,
                    "{shape} {fineness}: {error:.1e} {angle:.2}"
                );
            }
        }
    }
}
