//! A coarser surface on some of the vertices of a fine one (edge collapse with quadric errors).
//!
//! ```text
//! collapse of a onto b, if Q_a(x_b) = Σ A_t (distance of x_b from plane t)² / Σ A_t ≤ tolerance²
//! ```
//!
//! over the planes of the triangles of area A_t that a has gathered. Vertices that remain keep their places,
//! so that they lie on the body. A vertex inherits the planes of those that collapsed onto it. The topology
//! is preserved (link condition), and no triangle turns over. Shapes of triangles are not improved: the
//! result carries values; boundary elements, but for drafts ([`draft_surface`](super::draft_surface)), need
//! those of [`remesh`](super::remesh).
//!
//! Source: Garland, Heckbert (1997), "Surface simplification using quadric error metrics", SIGGRAPH.
//! `Differs`: vertices do not move, and edges are taken by length, so that triangles stay of similar size.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DMat3, DVec3};

/// Smallest cosine between the normals of a triangle before and after a collapse.
const TURNED: f64 = 0.5;
/// Smallest height of a new triangle in its longest side.
const FLATTEST: f64 = 1e-3;
/// Share of removed vertices below which no further pass is made, and most passes.
const FEW: f64 = 0.01;
const MOST_PASSES: usize = 30;

/// Mean of squared distances from planes: (xᵀ A x + 2 b·x + c) / weight.
#[derive(Clone, Copy)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
    weight: f64,
}

impl Quadric {
    const ZERO: Self = Quadric { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0, weight: 0.0 };

    /// The plane through a point, with the length of its normal as weight.
    fn plane(area: DVec3, point: DVec3) -> Self {
        let (normal, weight) = (area.normalize_or_zero(), area.length());
        let offset = -normal.dot(point);
        let a = DMat3::from_cols(area * normal.x, area * normal.y, area * normal.z);
        Quadric { a, b: offset * area, c: offset * offset * weight, weight }
    }

    fn add(&mut self, other: &Quadric) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }

    fn at(&self, x: DVec3) -> f64 {
        ((x.dot(self.a * x) + 2.0 * self.b.dot(x) + self.c) / self.weight).max(0.0)
    }
}

/// A closed surface with edges of up to `longest` \[m\] where it is flat to within `tolerance` \[m\]. Edges
/// that are longer stay.
pub(crate) fn decimate(surface: &TriMesh, longest: f64, tolerance: f64) -> TriMesh {
    let mut mesh = Decimation::new(surface);
    for _ in 0..MOST_PASSES {
        let before = mesh.count;
        mesh.pass(longest, tolerance);
        if ((before - mesh.count) as f64) < FEW * before as f64 {
            break;
        }
    }
    mesh.finish()
}

struct Decimation {
    position: Vec<DVec3>,
    quadric: Vec<Quadric>,
    triangles: Vec<[u32; 3]>,
    alive: Vec<bool>,
    /// Triangles around each vertex.
    around: Vec<Vec<u32>>,
    /// Vertices left.
    count: usize,
}

impl Decimation {
    fn new(surface: &TriMesh) -> Self {
        let mut around = vec![Vec::new(); surface.vertices.len()];
        let mut quadric = vec![Quadric::ZERO; surface.vertices.len()];
        for (t, corners) in surface.triangles.iter().enumerate() {
            let plane = Quadric::plane(surface.area_vector(t), surface.centroid(t));
            for v in corners {
                around[*v as usize].push(t as u32);
                quadric[*v as usize].add(&plane);
            }
        }
        Decimation {
            position: surface.vertices.clone(),
            quadric,
            triangles: surface.triangles.clone(),
            alive: vec![true; surface.triangles.len()],
            count: around.iter().filter(|around| !around.is_empty()).count(),
            around,
        }
    }

    /// Tries to collapse every edge once, short ones first.
    fn pass(&mut self, longest: f64, tolerance: f64) {
        let mut edges: Vec<(f64, [u32; 2])> = Vec::new();
        for corners in self.triangles.iter().zip(&self.alive).filter(|(_, alive)| **alive).map(|(t, _)| t) {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let length = self.position[a as usize].distance(self.position[b as usize]);
                if a < b && length < longest {
                    edges.push((length, [a, b]));
                }
            }
        }
        edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, [a, b]) in edges {
            if self.around[a as usize].is_empty() || self.around[b as usize].is_empty() {
                continue;
            }
            let error = |from: u32, to: u32| self.quadric[from as usize].at(self.position[to as usize]);
            let (from, to) = if error(a, b) <= error(b, a) { (a, b) } else { (b, a) };
            if error(from, to) <= tolerance * tolerance && self.may_collapse(from, to, longest) {
                self.collapse(from, to);
            }
        }
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let around = self.around[v as usize].iter().flat_map(|t| self.triangles[*t as usize]);
        let mut all: Vec<u32> = around.filter(|n| *n != v).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn may_collapse(&self, from: u32, to: u32, longest: f64) -> bool {
        let (own, other) = (self.neighbours(from), self.neighbours(to));
        // Link condition: still an edge, with one triangle on each side and nothing else in common.
        if own.binary_search(&to).is_err()
            || own.iter().filter(|n| other.binary_search(n).is_ok()).count() != 2
        {
            return false;
        }
        let place = self.position[to as usize];
        let reaches = own.iter().all(|n| self.position[*n as usize].distance(place) <= longest);
        reaches
            && self.around[from as usize].iter().all(|t| {
                let corners = self.triangles[*t as usize];
                corners.contains(&to) || self.keeps_side(corners, from, place)
            })
    }

    /// Whether a triangle neither turns over nor degenerates as one of its corners moves.
    fn keeps_side(&self, corners: [u32; 3], moving: u32, place: DVec3) -> bool {
        let old = corners.map(|v| self.position[v as usize]);
        let new: [DVec3; 3] = std::array::from_fn(|k| if corners[k] == moving { place } else { old[k] });
        let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let (before, after) = (normal(old), normal(new));
        let longest = (0..3).map(|k| new[k].distance_squared(new[(k + 1) % 3])).fold(0.0, f64::max);
        after.length() > FLATTEST * longest && before.dot(after) > TURNED * before.length() * after.length()
    }

    fn collapse(&mut self, from: u32, to: u32) {
        for t in std::mem::take(&mut self.around[from as usize]) {
            let corners = self.triangles[t as usize];
            if corners.contains(&to) {
                self.alive[t as usize] = false;
                for v in corners.into_iter().filter(|v| *v != from) {
                    self.around[v as usize].retain(|other| *other != t);
                }
            } else {
                self.triangles[t as usize] = corners.map(|v| if v == from { to } else { v });
                self.around[to as usize].push(t);
            }
        }
        let gathered = self.quadric[from as usize];
        self.quadric[to as usize].add(&gathered);
        self.count -= 1;
    }

    fn finish(self) -> TriMesh {
        let mut number = vec![u32::MAX; self.position.len()];
        let mut mesh = TriMesh::default();
        for corners in self.triangles.iter().zip(&self.alive).filter(|(_, alive)| **alive).map(|(t, _)| t) {
            mesh.triangles.push(corners.map(|v| {
                let number = &mut number[v as usize];
                if *number == u32::MAX {
                    *number = mesh.vertices.len() as u32;
                    mesh.vertices.push(self.position[v as usize]);
                }
                *number
            }));
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::geometry::mass_properties::MassProperties;
    use clangor_core::geometry::refine::refine_to_edge;
    use clangor_core::geometry::topology::Topology;
    use clangor_core::shape::Shape;

    use super::*;

    #[test]
    fn a_thin_ring_keeps_its_form_on_few_vertices() {
        let ring = Shape::parse("torus:0.03x0.001@0.0002").expect("a ring").mesh();
        let coarse = decimate(&ring, 0.004, 1e-4);
        Topology::try_new(&coarse).expect("closed");
        let volume = |mesh: &TriMesh| MassProperties::of(mesh).expect("a solid").volume;
        let (left, loss) = (coarse.vertices.len(), volume(&coarse) / volume(&ring) - 1.0);
        println!("{left} of {} vertices, volume off by {loss:.3}", ring.vertices.len());
        assert!(20 * left < ring.vertices.len() && loss.abs() < 0.1, "{left} {loss}");
    }

    #[test]
    fn flat_faces_lose_all_that_is_not_needed() {
        let cube = Shape::parse("box:0.1x0.1x0.1").expect("a box").mesh();
        let coarse = decimate(&refine_to_edge(&cube, 0.004), 1.0, 1e-6);
        let mass = MassProperties::of(&coarse).expect("a solid");
        assert!((mass.volume - 1e-3).abs() < 1e-9 && coarse.vertices.len() < 40, "{}", coarse.vertices.len());
    }
}
