//! Lines along which the triangles of two surfaces cross.
//!
//! An edge from p to q pierces a triangle abc if p and q lie on different sides of its plane, and the line
//! through them passes all its sides in one sense:
//!
//! ```text
//! [abcp] [abcq] < 0,    [pqab], [pqbc], [pqca] of one sign,    x = p + (q − p) [abcp]/([abcp] − [abcq])
//! ```
//!
//! with the volume \[abcd\] of a tetrahedron times six. Its sign is exact (Shewchuk (1997), "Adaptive
//! Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates"; crate `robust`).

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use robust::{Coord3D, orient3d};

use super::super::super::tri_mesh::TriMesh;
use super::{Degenerate, sorted};

/// Points and lines of two surfaces in one mesh.
pub(super) struct Lines<'a> {
    mesh: &'a TriMesh,
    /// Places of the points, which are numbered after the vertices.
    points: Vec<DVec3>,
    /// The point of each edge and triangle that were compared.
    pierced: HashMap<([u32; 2], usize), Option<u32>>,
    /// Points on each edge, with the fraction of the edge from its lower end.
    on_edges: HashMap<[u32; 2], Vec<(f64, u32)>>,
    /// Points within each triangle.
    inside: BTreeMap<usize, Vec<u32>>,
    /// Lines in each triangle.
    segments: BTreeMap<usize, Vec<[u32; 2]>>,
}

/// What divides a triangle.
pub(super) struct Within {
    /// Its corners and the points on its sides, in their order around it.
    pub(super) border: Vec<u32>,
    /// Its area vector \[m²\].
    pub(super) area: DVec3,
    /// Points within it.
    pub(super) inside: Vec<u32>,
    /// Lines in it.
    pub(super) segments: Vec<[u32; 2]>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(mesh: &'a TriMesh) -> Self {
        Lines {
            mesh,
            points: Vec::new(),
            pierced: HashMap::new(),
            on_edges: HashMap::new(),
            inside: BTreeMap::new(),
            segments: BTreeMap::new(),
        }
    }

    pub(super) fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Adds the line along which two triangles cross, if they do.
    pub(super) fn cross(&mut self, [first, second]: [usize; 2]) -> Result<(), Degenerate> {
        let mut ends = Vec::new();
        for (of, through) in [(first, second), (second, first)] {
            let corners = self.mesh.triangles[of];
            for k in 0..3 {
                ends.extend(self.point(sorted(corners[k], corners[(k + 1) % 3]), through)?);
            }
        }
        match ends[..] {
            [] => Ok(()),
            [a, b] => {
                for t in [first, second] {
                    self.segments.entry(t).or_default().push([a, b]);
                }
                Ok(())
            }
            _ => Err(Degenerate),
        }
    }

    /// The lines and points in a triangle, if there are any.
    pub(super) fn within(&self, t: usize) -> Option<Within> {
        let corners = self.mesh.triangles[t];
        let mut border = Vec::new();
        for k in 0..3 {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            let mut points = self.on_edges.get(&sorted(from, to)).cloned().unwrap_or_default();
            points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            if from > to {
                points.reverse();
            }
            border.push(from);
            border.extend(points.into_iter().map(|(_, point)| point));
        }
        let segments = self.segments.get(&t).cloned().unwrap_or_default();
        let is_divided = border.len() > 3 || !segments.is_empty();
        let inside = self.inside.get(&t).cloned().unwrap_or_default();
        is_divided.then(|| Within { border, area: self.mesh.area_vector(t), inside, segments })
    }

    /// Where an edge pierces a triangle.
    fn point(&mut self, edge: [u32; 2], t: usize) -> Result<Option<u32>, Degenerate> {
        if let Some(known) = self.pierced.get(&(edge, t)) {
            return Ok(*known);
        }
        let ends = edge.map(|v| self.mesh.vertices[v as usize]);
        let point = fraction_of_edge(ends, self.mesh.corners(t))?.map(|fraction| {
            let number = (self.mesh.vertices.len() + self.points.len()) as u32;
            self.points.push(ends[0].lerp(ends[1], fraction));
            self.on_edges.entry(edge).or_default().push((fraction, number));
            self.inside.entry(t).or_default().push(number);
            number
        });
        self.pierced.insert((edge, t), point);
        Ok(point)
    }
}

/// The fraction of an edge at which it pierces a triangle.
fn fraction_of_edge([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> Result<Option<f64>, Degenerate> {
    let (of_p, of_q) = (volume(a, b, c, p)?, volume(a, b, c, q)?);
    if (of_p > 0.0) == (of_q > 0.0) {
        return Ok(None);
    }
    let senses = [volume(p, q, a, b)?, volume(p, q, b, c)?, volume(p, q, c, a)?].map(|v| v > 0.0);
    let is_through = senses == [true; 3] || senses == [false; 3];
    Ok(is_through.then(|| of_p / (of_p - of_q)))
}

/// Six times the volume of a tetrahedron, of exact sign.
fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Result<f64, Degenerate> {
    let [a, b, c, d] = [a, b, c, d].map(|x| Coord3D { x: x.x, y: x.y, z: x.z });
    let volume = orient3d(a, b, c, d);
    if volume == 0.0 || !volume.is_finite() { Err(Degenerate) } else { Ok(volume) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn edges_pierce_triangles_inside_of_their_sides() {
        let edge = |x: f64, y: f64| [DVec3::new(x, y, 1.0), DVec3::new(x, y, -3.0)];
        let [p, q] = edge(0.25, 0.5);
        assert_eq!(fraction_of_edge([p, q], CORNERS), Ok(Some(0.25)));
        assert_eq!(fraction_of_edge([q, p], CORNERS), Ok(Some(0.75)));
        assert_eq!(fraction_of_edge(edge(0.6, 0.5), CORNERS), Ok(None));
        assert_eq!(fraction_of_edge([p, p - 0.9 * DVec3::Z], CORNERS), Ok(None));
        // Through a side; with an end in the plane.
        assert_eq!(fraction_of_edge(edge(0.5, 0.5), CORNERS), Err(Degenerate));
        assert_eq!(fraction_of_edge([p, p - DVec3::Z], CORNERS), Err(Degenerate));
    }

    /// A triangle through which another stands.
    #[test]
    fn triangles_that_cross_share_a_line() {
        let upright = [DVec3::new(0.1, 0.2, -1.0), DVec3::new(0.6, 0.21, -1.0), DVec3::new(0.3, 0.2, 1.0)];
        let mesh = TriMesh { vertices: [CORNERS, upright].concat(), triangles: vec![[0, 1, 2], [3, 4, 5]] };
        let mut lines = Lines::new(&mesh);
        assert_eq!(lines.cross([0, 1]), Ok(()));
        assert_eq!(lines.points().len(), 2);
        let (flat, upright) = (lines.within(0).expect("a line"), lines.within(1).expect("a line"));
        assert_eq!((flat.border, flat.inside.len()), (vec![0, 1, 2], 2));
        assert_eq!((upright.border.len(), upright.inside.len()), (5, 0));
        assert_eq!(flat.segments, upright.segments);
    }
}
