//! Volume meshes of quadratic tetrahedra, whose edges may be curved.
//!
//! An element has four corners and six mid-edge nodes. Inside, positions are
//!
//! ```text
//! x(L) = Σ xᵢ Lᵢ (2 Lᵢ − 1) + Σ x_ij 4 Lᵢ Lⱼ,    L₀ + L₁ + L₂ + L₃ = 1
//! ```
//!
//! A mesh starts with straight edges. The midpoints of the edges on its surface may then move onto the true
//! surface, where the elements stay well shaped.

pub mod axisymmetric;
pub mod ball;
pub mod block;
pub mod cylinder;
pub mod dish;
pub mod isosurface_stuffing;
pub mod quality;
mod shape_mesh;

use glam::DVec3;

use quality::{Quality, shape_of};
pub use shape_mesh::shape_mesh;

/// The corners that each mid-edge node lies between, in the order of the nodes 4 to 9.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// The corners of each face, counter-clockwise seen from outside; face k is opposite corner k.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Elements whose smallest Jacobian falls below this fraction of the straight element's keep their straight
/// edges.
const LEAST_CURVED: f64 = 0.3;

/// Quadratic tetrahedra.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetMesh {
    /// Positions \[m\]: corners first, then the middles of edges.
    pub nodes: Vec<DVec3>,
    /// Number of corners.
    pub corners: usize,
    /// Nodes of each element: four corners, then the middles of [`EDGES`].
    pub elements: Vec<[u32; 10]>,
}

/// Reasons why tetrahedra do not form a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TetMeshError {
    /// No tetrahedra.
    #[error("the mesh has no tetrahedra")]
    Empty,
    /// An element refers to a corner that does not exist.
    #[error("tetrahedron {element} names corner {index}, but there are {corners}")]
    IndexOutOfRange {
        /// The element.
        element: usize,
        /// The index.
        index: u32,
        /// Number of corners.
        corners: usize,
    },
    /// An element has no volume, or is inside out.
    #[error("tetrahedron {element} near {position} has no volume or is inside out")]
    Inverted {
        /// The element.
        element: usize,
        /// Position \[m\].
        position: DVec3,
    },
}

impl TetMesh {
    /// A mesh of tetrahedra with straight edges. Inverted elements are reoriented.
    ///
    /// # Errors
    /// [`TetMeshError`].
    pub fn straight(points: Vec<DVec3>, tetrahedra: &[[u32; 4]]) -> Result<Self, TetMeshError> {
        Self::curved(points, tetrahedra, |middle, _, _| middle)
    }

    /// A mesh whose surface edges have their midpoints at `middle(straight middle, from, to)`; see
    /// [`straight`](Self::straight).
    ///
    /// An element that this would distort keeps straight edges, and so do its neighbours along them.
    ///
    /// # Errors
    /// [`TetMeshError`].
    pub fn curved(
        points: Vec<DVec3>,
        tetrahedra: &[[u32; 4]],
        middle: impl Fn(DVec3, DVec3, DVec3) -> DVec3,
    ) -> Result<Self, TetMeshError> {
        let corners = points.len();
        let tetrahedra = oriented(&points, tetrahedra)?;
        // Edges, and those on the surface.
        let mut edges: Vec<[u32; 2]> = tetrahedra.iter().flat_map(edges_of).collect();
        edges.sort_unstable();
        edges.dedup();
        let mut on_surface: Vec<[u32; 2]> = surface_faces(&tetrahedra)
            .iter()
            .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]].map(|[p, q]| [*p.min(q), *p.max(q)]))
            .collect();
        on_surface.sort_unstable();
        on_surface.dedup();
        // Midpoints: on the surface by `middle`, inside straight.
        let straight = |[a, b]: [u32; 2]| 0.5 * (points[a as usize] + points[b as usize]);
        let mut nodes = points.clone();
        nodes.extend(edges.iter().map(|edge| match on_surface.binary_search(edge) {
            Ok(_) => middle(straight(*edge), points[edge[0] as usize], points[edge[1] as usize]),
            Err(_) => straight(*edge),
        }));
        let number = |edge: [u32; 2]| (corners + edges.partition_point(|e| *e < edge)) as u32;
        // Number the ten nodes of each element.
        let elements = tetrahedra
            .iter()
            .map(|t| {
                let middles = edges_of(t).map(number);
                std::array::from_fn(|k| if k < 4 { t[k] } else { middles[k - 4] })
            })
            .collect();
        // Straighten distorted elements.
        let mut mesh = TetMesh { nodes, corners, elements };
        mesh.straighten(&edges);
        Ok(mesh)
    }

    /// Straightens the edges of elements that are too distorted.
    fn straighten(&mut self, edges: &[[u32; 2]]) {
        // This terminates: with all edges straight every element is valid.
        loop {
            let bad: Vec<usize> = (0..self.elements.len())
                .filter(|e| {
                    let nodes = self.positions(*e);
                    quality::least_jacobian(&nodes) < LEAST_CURVED * quality::straight_jacobian(&nodes)
                })
                .collect();
            if bad.is_empty() {
                return;
            }
            for e in bad {
                for node in &self.elements[e][4..] {
                    let [a, b] = edges[*node as usize - self.corners];
                    self.nodes[*node as usize] = 0.5 * (self.nodes[a as usize] + self.nodes[b as usize]);
                }
            }
        }
    }

    /// Positions of an element's nodes \[m\].
    pub fn positions(&self, element: usize) -> [DVec3; 10] {
        self.elements[element].map(|n| self.nodes[n as usize])
    }

    /// Faces with an element on one side only: corners counter-clockwise from outside, then the middles of
    /// the edges from the first to the second corner and so on.
    pub fn surface(&self) -> Vec<[u32; 6]> {
        let mut faces: Vec<([u32; 3], [u32; 6])> = Vec::with_capacity(4 * self.elements.len());
        for element in &self.elements {
            for face in FACES {
                let mut key = face.map(|k| element[k]);
                key.sort_unstable();
                let middle = |k: usize| {
                    let (a, b) = (face[k], face[(k + 1) % 3]);
                    let edge = EDGES.iter().position(|e| *e == [a, b] || *e == [b, a]).unwrap_or(0);
                    element[4 + edge]
                };
                let [a, b, c] = face.map(|k| element[k]);
                faces.push((key, [a, b, c, middle(0), middle(1), middle(2)]));
            }
        }
        faces.sort_unstable();
        let single = faces.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
        single.map(|same| same[0].1).collect()
    }

    /// Number of parts that have no node in common.
    pub fn parts(&self) -> usize {
        let mut root: Vec<u32> = (0..self.nodes.len() as u32).collect();
        let find = |root: &mut Vec<u32>, mut n: u32| {
            while root[n as usize] != n {
                root[n as usize] = root[root[n as usize] as usize];
                n = root[n as usize];
            }
            n
        };
        for element in &self.elements {
            let first = find(&mut root, element[0]);
            for node in &element[1..] {
                let other = find(&mut root, *node);
                root[other as usize] = first;
            }
        }
        (0..root.len()).filter(|n| root[*n] == *n as u32).count()
    }

    /// Volume and shape of the elements.
    pub fn quality(&self) -> Quality {
        shape_of(self)
    }
}

fn edges_of(t: &[u32; 4]) -> [[u32; 2]; 6] {
    EDGES.map(|[i, j]| [t[i].min(t[j]), t[i].max(t[j])])
}

/// Faces that belong to one tetrahedron only.
fn surface_faces(tetrahedra: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let sorted = |t: &[u32; 4], face: [usize; 3]| {
        let mut key = face.map(|k| t[k]);
        key.sort_unstable();
        key
    };
    let mut faces: Vec<[u32; 3]> = tetrahedra.iter().flat_map(|t| FACES.map(|f| sorted(t, f))).collect();
    faces.sort_unstable();
    faces.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}

/// The tetrahedra with positive volume.
fn oriented(points: &[DVec3], tetrahedra: &[[u32; 4]]) -> Result<Vec<[u32; 4]>, TetMeshError> {
    if tetrahedra.is_empty() {
        return Err(TetMeshError::Empty);
    }
    let mend = |(element, t): (usize, &[u32; 4])| {
        if let Some(index) = t.iter().copied().find(|i| *i as usize >= points.len()) {
            return Err(TetMeshError::IndexOutOfRange { element, index, corners: points.len() });
        }
        let [a, b, c, d] = t.map(|i| points[i as usize]);
        let volume = (b - a).cross(c - a).dot(d - a);
        let longest =
            [b - a, c - a, d - a, c - b, d - b, d - c].map(DVec3::length).into_iter().fold(0.0, f64::max);
        if volume.is_nan() || volume.abs() <= 1e-9 * longest.powi(3) {
            return Err(TetMeshError::Inverted { element, position: 0.25 * (a + b + c + d) });
        }
        Ok(if volume > 0.0 { *t } else { [t[0], t[2], t[1], t[3]] })
    };
    tetrahedra.iter().enumerate().map(mend).collect()
}
