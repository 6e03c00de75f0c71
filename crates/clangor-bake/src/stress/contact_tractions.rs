//! Conversion of surface forces to nodal forces.
//!
//! ```text
//! f_n = ∫ t N_n dS,    N_n the shape functions of the six nodes of a face
//! ```
//!
//! A point force causes an infinite stress, which on a mesh grows as elements shrink. A contact has a finite
//! area: its force is distributed as a pressure ∝ 1 − d²/r² within the distance r along the surface. r is the
//! radius of the contact, at least the longest edge at the vertex, below which the mesh does not resolve it.
//! Each vertex of the surface has such a patch. A force inside a face is shared by the patches of its three
//! corners by barycentric coordinates, so that the load varies continuously with the point.
//!
//! The force is exact. Its torque has an error of the force times the distance of the patch's centroid from
//! the point, at edges of the body up to a third of r; the reaction balances the applied load.
//!
//! Differs from \[FRAC\], which does not specify how contacts load the mesh. Forces on single nodes would
//! break a body of a fine mesh by the tension beside them, however weak they are.

use std::cell::OnceCell;

use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DMat3, DVec3};

use crate::mesh::tetrahedra::TetMesh;
use crate::quadrature::TRIANGLE_FIFTH_DEGREE;

/// The surface of a body with its contact patches.
pub(super) struct ContactTractions {
    surface: TriMesh,
    tree: SurfaceTree,
    /// The six nodes of each triangle.
    faces: Vec<[u32; 6]>,
    /// Start of each vertex in `triangles`, and the end.
    starts: Vec<u32>,
    triangles: Vec<u32>,
    /// Least radius of a patch \[m\].
    radius: f64,
    /// Shares of the nodes in a force on each patch; filled when the first is needed.
    patches: OnceCell<Vec<Vec<(u32, f64)>>>,
}

impl ContactTractions {
    pub(super) fn new(mesh: &TetMesh, radius: f64) -> Self {
        let faces = mesh.surface();
        let mut vertices: Vec<u32> = faces.iter().flat_map(|f| [f[0], f[1], f[2]]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let number = |n: u32| vertices.partition_point(|v| *v < n) as u32;
        let corners: Vec<[u32; 3]> = faces.iter().map(|f| [f[0], f[1], f[2]].map(number)).collect();
        let mut incidences: Vec<(u32, u32)> =
            corners.iter().enumerate().flat_map(|(t, c)| c.map(|v| (v, t as u32))).collect();
        incidences.sort_unstable();
        let starts = (0..=vertices.len() as u32)
            .map(|v| incidences.partition_point(|(vertex, _)| *vertex < v) as u32)
            .collect();
        let surface = TriMesh {
            vertices: vertices.iter().map(|n| mesh.nodes[*n as usize]).collect(),
            triangles: corners,
        };
        ContactTractions {
            tree: SurfaceTree::new(&surface),
            surface,
            faces,
            starts,
            triangles: incidences.into_iter().map(|(_, t)| t).collect(),
            radius,
            patches: OnceCell::new(),
        }
    }

    /// Number of vertices.
    pub(super) fn vertex_count(&self) -> usize {
        self.surface.vertices.len()
    }

    /// The vertices whose patches carry a force at a point, with their shares; empty for a point that is not
    /// finite.
    pub(super) fn shares(&self, point: DVec3) -> Option<[(usize, f64); 3]> {
        let nearest = self.tree.nearest(&self.surface, point)?;
        let corners = self.surface.triangles[nearest.triangle];
        Some(std::array::from_fn(|k| (corners[k] as usize, nearest.weights[k])))
    }

    /// Shares of the nodes in a force on the patch of a vertex; they sum to 1.
    pub(super) fn patch(&self, vertex: usize) -> &[(u32, f64)] {
        &self.patches()[vertex]
    }

    /// Displacement of every patch, averaged as its force is distributed.
    pub(super) fn patch_means(&self, displacement: &[DVec3]) -> Vec<DVec3> {
        let mean = |patch: &Vec<(u32, f64)>| {
            patch.iter().map(|(node, share)| displacement[*node as usize] * *share).sum()
        };
        self.patches().iter().map(mean).collect()
    }

    fn patches(&self) -> &[Vec<(u32, f64)>] {
        self.patches.get_or_init(|| (0..self.vertex_count()).map(|vertex| self.patch_of(vertex)).collect())
    }

    fn patch_of(&self, vertex: usize) -> Vec<(u32, f64)> {
        let centre = self.surface.vertices[vertex];
        let reach = self.triangles_of(vertex).flat_map(|t| self.surface.triangles[t]);
        let longest = reach.map(|v| self.surface.vertices[v as usize].distance(centre)).fold(0.0, f64::max);
        let radius = self.radius.max(longest);
        let mut shares: Vec<(u32, f64)> = Vec::new();
        for triangle in self.triangles_within(vertex, radius) {
            let corners = self.surface.corners(triangle);
            let area = self.surface.area_vector(triangle).length();
            for (at, weight) in TRIANGLE_FIFTH_DEGREE {
                let place = corners[0] * at[0] + corners[1] * at[1] + corners[2] * at[2];
                let pressure = 1.0 - place.distance_squared(centre) / (radius * radius);
                if pressure > 0.0 {
                    let share = |k: usize, n: f64| (self.faces[triangle][k], weight * area * pressure * n);
                    shares.extend(shapes(at).into_iter().enumerate().map(|(k, n)| share(k, n)));
                }
            }
        }
        shares.sort_by_key(|(node, _)| *node);
        let mut patch: Vec<(u32, f64)> = Vec::new();
        for (node, share) in shares {
            match patch.last_mut() {
                Some(last) if last.0 == node => last.1 += share,
                _ => patch.push((node, share)),
            }
        }
        let sum: f64 = patch.iter().map(|(_, share)| share).sum();
        patch.iter_mut().for_each(|(_, share)| *share /= sum);
        patch
    }

    /// A rotation whose first column is the inward normal at a vertex.
    pub(super) fn frame(&self, vertex: usize) -> DMat3 {
        let inward = -self.triangles_of(vertex).map(|t| self.surface.area_vector(t)).sum::<DVec3>();
        let inward = inward.try_normalize().unwrap_or(DVec3::X);
        let along = inward.any_orthonormal_vector();
        DMat3::from_cols(inward, along, inward.cross(along))
    }

    /// Adds the forces of a traction \[Pa\], given by position and outward normal, to those on the nodes
    /// \[N\].
    pub(super) fn add_traction(&self, traction: impl Fn(DVec3, DVec3) -> DVec3, forces: &mut [DVec3]) {
        for (triangle, nodes) in self.faces.iter().enumerate() {
            let corners = self.surface.corners(triangle);
            let area = self.surface.area_vector(triangle);
            let normal = area.normalize_or_zero();
            for (at, weight) in TRIANGLE_FIFTH_DEGREE {
                let place = corners[0] * at[0] + corners[1] * at[1] + corners[2] * at[2];
                let force = traction(place, normal) * (weight * area.length());
                for (node, n) in nodes.iter().zip(shapes(at)) {
                    forces[*node as usize] += force * n;
                }
            }
        }
    }

    fn triangles_of(&self, vertex: usize) -> impl Iterator<Item = usize> {
        self.triangles[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
            .iter()
            .map(|t| *t as usize)
    }

    /// Triangles connected to a vertex through vertices closer than a radius, itself included.
    fn triangles_within(&self, vertex: usize, radius: f64) -> Vec<usize> {
        let centre = self.surface.vertices[vertex];
        let mut reached = vec![vertex];
        let mut triangles: Vec<usize> = Vec::new();
        let mut next = 0;
        while next < reached.len() {
            for t in self.triangles_of(reached[next]) {
                if triangles.contains(&t) {
                    continue;
                }
                triangles.push(t);
                for v in self.surface.triangles[t].map(|v| v as usize) {
                    if self.surface.vertices[v].distance(centre) < radius && !reached.contains(&v) {
                        reached.push(v);
                    }
                }
            }
            next += 1;
        }
        triangles
    }
}

/// Shape functions of the nodes of a face: corners, then the middles of the edges from the first to the
/// second and so on.
fn shapes([a, b, c]: [f64; 3]) -> [f64; 6] {
    [a * (2.0 * a - 1.0), b * (2.0 * b - 1.0), c * (2.0 * c - 1.0), 4.0 * a * b, 4.0 * b * c, 4.0 * c * a]
}
