//! Which triangles share an edge.

use glam::DVec3;

use super::mesh_error::MeshError;
use super::tri_mesh::TriMesh;

/// The neighbours of each triangle of a closed, consistently wound surface.
///
/// `neighbours[t][k]` is the triangle across the edge from corner k to corner k+1 of triangle t.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    /// Neighbours of each triangle.
    pub neighbours: Vec<[u32; 3]>,
}

/// An edge of one triangle: `low`, `high` are its vertices in order of index.
struct Side {
    low: u32,
    high: u32,
    triangle: u32,
    slot: u8,
    ascending: bool,
}

impl Topology {
    /// Pairs the edges of a mesh whose indices are in range.
    ///
    /// # Errors
    /// [`MeshError::Open`], [`MeshError::NonManifold`] or [`MeshError::Winding`] unless every edge belongs to
    /// exactly two triangles that run along it in opposite directions.
    pub fn try_new(mesh: &TriMesh) -> Result<Self, MeshError> {
        let mut sides = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for slot in 0..3 {
                let (a, b) = (triangle[slot], triangle[(slot + 1) % 3]);
                sides.push(Side {
                    low: a.min(b),
                    high: a.max(b),
                    triangle: t as u32,
                    slot: slot as u8,
                    ascending: a < b,
                });
            }
        }
        sides.sort_unstable_by_key(|s| (s.low, s.high, s.triangle, s.slot));
        let mut neighbours = vec![[0; 3]; mesh.triangles.len()];
        let mut defects = Defects::default();
        for edge in sides.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
            let middle =
                || 0.5 * (mesh.vertices[edge[0].low as usize] + mesh.vertices[edge[0].high as usize]);
            match edge {
                [a, b] if a.ascending != b.ascending => {
                    neighbours[a.triangle as usize][a.slot as usize] = b.triangle;
                    neighbours[b.triangle as usize][b.slot as usize] = a.triangle;
                }
                [_, _] => defects.winding.note(middle),
                [_] => defects.open.note(middle),
                _ => defects.shared.note(middle),
            }
        }
        defects.into_result().map(|()| Topology { neighbours })
    }

    /// Number of connected pieces, and the piece of each triangle.
    pub fn components(&self) -> (usize, Vec<u32>) {
        let mut piece = vec![u32::MAX; self.neighbours.len()];
        let mut count = 0;
        let mut front = Vec::new();
        for seed in 0..piece.len() {
            if piece[seed] != u32::MAX {
                continue;
            }
            piece[seed] = count;
            front.push(seed);
            while let Some(t) = front.pop() {
                for n in self.neighbours[t] {
                    if piece[n as usize] == u32::MAX {
                        piece[n as usize] = count;
                        front.push(n as usize);
                    }
                }
            }
            count += 1;
        }
        (count as usize, piece)
    }
}

/// Number of edges with a defect, and the place of the first.
#[derive(Default)]
struct Tally {
    count: usize,
    first: DVec3,
}

impl Tally {
    fn note(&mut self, place: impl FnOnce() -> DVec3) {
        if self.count == 0 {
            self.first = place();
        }
        self.count += 1;
    }
}

#[derive(Default)]
struct Defects {
    open: Tally,
    shared: Tally,
    winding: Tally,
}

impl Defects {
    fn into_result(self) -> Result<(), MeshError> {
        if self.open.count > 0 {
            return Err(MeshError::Open { edges: self.open.count, position: self.open.first });
        }
        if self.shared.count > 0 {
            return Err(MeshError::NonManifold { edges: self.shared.count, position: self.shared.first });
        }
        if self.winding.count > 0 {
            return Err(MeshError::Winding { edges: self.winding.count, position: self.winding.first });
        }
        Ok(())
    }
}

/// Edges with a triangle on one side only, in that triangle's direction, in order of triangle and corner.
pub fn boundary_edges(mesh: &TriMesh) -> Vec<(u32, u32)> {
    let sides = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    let all: std::collections::HashSet<(u32, u32)> = mesh.triangles.iter().flat_map(sides).collect();
    mesh.triangles.iter().flat_map(sides).filter(|(a, b)| !all.contains(&(*b, *a))).collect()
}
