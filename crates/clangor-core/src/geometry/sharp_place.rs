//! Creases and corners of a triangle surface: where they are, and how a crease bends.
//!
//! An edge between two triangles is a crease where their normals differ by more than 53°. A vertex at which
//! two creases meet, and bend little, lies on one line; at any other sharp vertex the surface has a corner.
//!
//! The curvature vector of a crease at a vertex V, from points A and B of it on both sides,
//!
//! ```text
//! b = 2 (a/|a| + b/|b|)/(|a| + |b|),   a = A − V, b = B − V
//! ```
//!
//! is that of the circle through the three points, for any lengths: it points to the centre and has the
//! length 1/r. A and B lie up to eight edges away, so that noise of the vertices counts little.
//!
//! All is found at the place that is asked for; nothing is stored for the mesh.

use glam::DVec3;

use super::tri_mesh::TriMesh;

/// Cosine of the angle between the normals of two triangles below which their edge is a crease: 53°.
const CREASE_COSINE: f64 = 0.6;
/// Cosine of the turn of a line of creases at one vertex below which the vertex is a corner: 53°.
const LINE_COSINE: f64 = 0.6;
/// Cosine of the angle between a triangle and the normal of a vertex below which the vertex is sharp: 30°.
const SMOOTH_COSINE: f64 = 0.866;
/// Most triangles around a vertex that are looked at.
const MOST_AROUND: usize = 64;
/// Edges along a crease on each side from which its curvature is found.
const MOST_EDGES: usize = 8;
/// Least cosine between the first edge of a crease and the chord from there that still shows its curvature:
/// an arc of 60°.
const LEAST_CHORD_COSINE: f64 = 0.866;

/// A place of a surface where its normal jumps.
#[derive(Clone, Debug, PartialEq)]
pub enum SharpPlace {
    /// A convex line between two faces.
    Crease {
        /// Unit vector along the line.
        tangent: DVec3,
        /// Curvature vector of the line [1/m], towards the centre of its circle; 0 for a straight one.
        bend: DVec3,
        /// Outward unit normals of the two faces.
        faces: [DVec3; 2],
    },
    /// A point where several faces meet: their outward unit normals.
    Corner {
        /// Normals of the faces.
        faces: Vec<DVec3>,
    },
}

/// A closed mesh with the neighbours of its triangles, as [`Topology`](super::topology::Topology) numbers
/// them.
#[derive(Clone, Copy)]
pub(super) struct JoinedMesh<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) neighbours: &'a [[u32; 3]],
}

/// A corner of a triangle: which triangle, and which of its corners.
type Wedge = (usize, usize);

impl JoinedMesh<'_> {
    /// The crease or corner within `tolerance` \[m\] of a position on a triangle; `None` where the surface is
    /// smooth there.
    pub(super) fn sharp_place(self, triangle: usize, position: DVec3, tolerance: f64) -> Option<SharpPlace> {
        let corners = self.mesh.corners(triangle);
        let near = |k: &usize| corners[*k].distance(position) <= tolerance;
        let nearest_corner = (0..3).filter(near).min_by(|a, b| {
            let distance = |k: usize| corners[k].distance(position);
            distance(*a).total_cmp(&distance(*b))
        });
        if let Some(k) = nearest_corner {
            match self.vertex((triangle, k)) {
                VertexPlace::Smooth => {}
                VertexPlace::Line { ends } => return self.crease_at(ends, position),
                VertexPlace::Corner { faces } => return Some(SharpPlace::Corner { faces }),
            }
        }
        // The nearest convex crease among the edges of the triangle.
        let height = |slot: usize| {
            let along = corners[(slot + 1) % 3] - corners[slot];
            (position - corners[slot]).reject_from(along).length()
        };
        let creases = (0..3).filter(|slot| {
            height(*slot) <= tolerance && self.is_crease(triangle, *slot) && self.is_convex(triangle, *slot)
        });
        let slot = creases.min_by(|a, b| height(*a).total_cmp(&height(*b)))?;
        self.crease_of(triangle, slot, position)
    }

    /// The outward unit normal of a triangle; 0 for one without area.
    fn face(self, triangle: usize) -> DVec3 {
        self.mesh.area_vector(triangle).normalize_or_zero()
    }

    /// Whether the edge from corner `slot` to the next one is a crease.
    fn is_crease(self, triangle: usize, slot: usize) -> bool {
        let across = self.neighbours[triangle][slot] as usize;
        let (one, other) = (self.face(triangle), self.face(across));
        one != DVec3::ZERO && other != DVec3::ZERO && one.dot(other) < CREASE_COSINE
    }

    /// Whether the surface bends away from its outside at an edge.
    fn is_convex(self, triangle: usize, slot: usize) -> bool {
        let across = self.neighbours[triangle][slot] as usize;
        let start = self.mesh.corners(triangle)[slot];
        (self.mesh.centroid(across) - start).dot(self.face(triangle)) < 0.0
    }

    /// The corners of the triangles around a vertex, in order; the first is the given one.
    fn around(self, (triangle, corner): Wedge) -> Vec<Wedge> {
        let mut ring = vec![(triangle, corner)];
        let mut at = (triangle, corner);
        while let Some(next) = self.across(at) {
            if next == (triangle, corner) || ring.len() >= MOST_AROUND {
                break;
            }
            ring.push(next);
            at = next;
        }
        ring
    }

    /// The corner at the same vertex in the triangle across the edge that leaves it.
    fn across(self, (triangle, corner): Wedge) -> Option<Wedge> {
        let vertex = self.mesh.triangles[triangle][corner];
        let next = self.neighbours[triangle][corner] as usize;
        let at = self.mesh.triangles[next].iter().position(|index| *index == vertex)?;
        Some((next, at))
    }

    /// What the surface is like at a vertex.
    fn vertex(self, at: Wedge) -> VertexPlace {
        let ring = self.around(at);
        let creases: Vec<Wedge> = ring.iter().copied().filter(|(t, k)| self.is_crease(*t, *k)).collect();
        let faces = || ring.iter().map(|(t, _)| self.face(*t)).filter(|n| *n != DVec3::ZERO).collect();
        if let [one, other] = creases[..] {
            let convex = [one, other].iter().all(|(t, k)| self.is_convex(*t, *k));
            let [a, b] = [one, other].map(|wedge| self.along(wedge).normalize_or_zero());
            if convex && -a.dot(b) > LINE_COSINE {
                return VertexPlace::Line { ends: [one, other] };
            }
        }
        let normal = self.fan_normal(&ring);
        let sharp = |(t, _): &Wedge| {
            let face = self.face(*t);
            face != DVec3::ZERO && face.dot(normal) < SMOOTH_COSINE
        };
        if ring.iter().any(sharp) { VertexPlace::Corner { faces: faces() } } else { VertexPlace::Smooth }
    }

    /// The edge that leaves a corner \[m\].
    fn along(self, (triangle, corner): Wedge) -> DVec3 {
        let corners = self.mesh.corners(triangle);
        corners[(corner + 1) % 3] - corners[corner]
    }

    /// The crease through the edge from corner `slot` of a triangle.
    fn crease_of(self, triangle: usize, slot: usize, position: DVec3) -> Option<SharpPlace> {
        let across = self.neighbours[triangle][slot] as usize;
        let tangent = self.along((triangle, slot)).try_normalize()?;
        // The bend at the ends that lie on a line of creases, by nearness.
        let corners = self.mesh.corners(triangle);
        let (mut bend, mut weights) = (DVec3::ZERO, 0.0);
        for (end, other) in [(slot, (slot + 1) % 3), ((slot + 1) % 3, slot)] {
            if let VertexPlace::Line { ends } = self.vertex((triangle, end)) {
                let weight = corners[other].distance(position);
                bend += weight * self.bend(ends);
                weights += weight;
            }
        }
        let bend = if weights > 0.0 { bend / weights } else { DVec3::ZERO };
        let bend = bend.reject_from_normalized(tangent);
        Some(SharpPlace::Crease { tangent, bend, faces: [self.face(triangle), self.face(across)] })
    }

    /// The crease at a vertex between two edges that leave it.
    fn crease_at(self, ends: [Wedge; 2], position: DVec3) -> Option<SharpPlace> {
        let [a, b] = ends.map(|end| self.along(end).normalize_or_zero());
        let tangent = (a - b).try_normalize()?;
        let bend = self.bend(ends).reject_from_normalized(tangent);
        // The faces of the edge on whose side the point lies.
        let from = position - self.mesh.corners(ends[0].0)[ends[0].1];
        let (triangle, slot) = if from.dot(tangent) >= 0.0 { ends[0] } else { ends[1] };
        let across = self.neighbours[triangle][slot] as usize;
        Some(SharpPlace::Crease { tangent, bend, faces: [self.face(triangle), self.face(across)] })
    }

    /// Curvature vector [1/m] of the line of creases through a vertex, from which two of its edges leave.
    fn bend(self, ends: [Wedge; 2]) -> DVec3 {
        let [a, b] = ends.map(|end| self.chord(end));
        let length = a.length() + b.length();
        let circle = 2.0 * (a.normalize_or_zero() + b.normalize_or_zero()) / length;
        if circle.is_finite() { circle } else { DVec3::ZERO }
    }

    /// The chord \[m\] from a vertex to a later point of the line of creases that starts along an edge.
    fn chord(self, start: Wedge) -> DVec3 {
        let origin = self.mesh.corners(start.0)[start.1];
        let first = self.along(start).normalize_or_zero();
        let (mut chord, mut edge) = (self.along(start), start);
        for _ in 1..MOST_EDGES {
            let far = (edge.0, (edge.1 + 1) % 3);
            let VertexPlace::Line { ends } = self.vertex(far) else { break };
            // Of the two edges at the far vertex, the one that does not lead back.
            let back = -self.along(edge);
            let onward = |end: &Wedge| self.along(*end).dot(back);
            edge = if onward(&ends[0]) < onward(&ends[1]) { ends[0] } else { ends[1] };
            let longer = self.mesh.corners(edge.0)[(edge.1 + 1) % 3] - origin;
            if longer.normalize_or_zero().dot(first) < LEAST_CHORD_COSINE {
                break;
            }
            chord = longer;
        }
        chord
    }

    /// Normal at a corner of a triangle from the triangles around it up to the next creases, by their angles.
    pub(super) fn smooth_normal(self, at: Wedge) -> DVec3 {
        let ring = self.around(at);
        let crease = |(t, k): &Wedge| self.is_crease(*t, *k);
        let Some(first) = ring.iter().position(crease) else { return self.fan_normal(&ring) };
        // The ring in order: up to the first crease, and back to the last one.
        let last = ring.iter().rposition(crease).unwrap_or(first);
        let fan: Vec<Wedge> = ring[last + 1..].iter().chain(&ring[..=first]).copied().collect();
        self.fan_normal(&fan)
    }

    /// Mean normal of some triangles at their vertex, weighted by angle.
    fn fan_normal(self, fan: &[Wedge]) -> DVec3 {
        let weighted = |(t, k): &Wedge| {
            let corners = self.mesh.corners(*t);
            let (u, v) = (corners[(k + 1) % 3] - corners[*k], corners[(k + 2) % 3] - corners[*k]);
            self.face(*t) * u.cross(v).length().atan2(u.dot(v))
        };
        fan.iter().map(weighted).sum::<DVec3>().normalize_or_zero()
    }

    /// Whether a triangle next to the vertex of a corner is tilted by more than 30° against its normal.
    pub(super) fn is_sharp(self, at: Wedge) -> bool {
        !matches!(self.vertex(at), VertexPlace::Smooth)
    }
}

/// What a surface is like at a vertex.
enum VertexPlace {
    Smooth,
    /// On a convex crease: the corners from which its two edges leave.
    Line {
        ends: [Wedge; 2],
    },
    Corner {
        faces: Vec<DVec3>,
    },
}
