//! The triangles at every edge of a mesh that need be neither closed nor consistently wound.

use std::f64::consts::TAU;

use super::super::tri_mesh::TriMesh;

/// One side of a triangle: its edge has the ends `low` and `high`, in order of index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) low: u32,
    pub(super) high: u32,
    pub(super) triangle: u32,
    /// The corner at which it begins.
    pub(super) slot: u8,
    /// Whether the triangle runs along it from `low` to `high`.
    pub(super) ascending: bool,
}

/// All sides in the order of their edges.
pub(super) struct Sides(Vec<Side>);

impl Sides {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let mut sides = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for slot in 0..3 {
                let (a, b) = (corners[slot], corners[(slot + 1) % 3]);
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
        Sides(sides)
    }

    /// The sides at each edge.
    pub(super) fn edges(&self) -> impl Iterator<Item = &[Side]> {
        self.0.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high))
    }

    /// Sides with no triangle across, in order of triangle and corner.
    pub(super) fn open(&self) -> Vec<Side> {
        let mut open: Vec<Side> = self.edges().filter(|e| e.len() == 1).map(|e| e[0]).collect();
        open.sort_unstable_by_key(|s| (s.triangle, s.slot));
        open
    }

    /// For each side of each triangle the triangle across, and whether both run along the edge in opposite
    /// senses, where exactly two meet.
    pub(super) fn across(&self, triangles: usize) -> Vec<[Option<(u32, bool)>; 3]> {
        let mut across = vec![[None; 3]; triangles];
        for edge in self.edges() {
            let [a, b] = edge else { continue };
            let agree = a.ascending != b.ascending;
            across[a.triangle as usize][usize::from(a.slot)] = Some((b.triangle, agree));
            across[b.triangle as usize][usize::from(b.slot)] = Some((a.triangle, agree));
        }
        across
    }
}

/// Angles of the triangles at an edge around it \[rad\], from the first, 0 to 2π. The front of a triangle
/// that runs along the edge from `low` to `high` is at larger angles.
pub(super) fn angles(mesh: &TriMesh, edge: &[Side]) -> Vec<f64> {
    let [low, high] = [edge[0].low, edge[0].high].map(|v| mesh.vertices[v as usize]);
    let axis = (high - low).normalize_or_zero();
    let away = |side: &Side| {
        let corners = mesh.triangles[side.triangle as usize];
        let third = corners[(usize::from(side.slot) + 2) % 3];
        (mesh.vertices[third as usize] - low).reject_from_normalized(axis)
    };
    let first = away(&edge[0]);
    let across = axis.cross(first);
    let angle = |side: &Side| {
        let away = away(side);
        away.dot(across).atan2(away.dot(first)).rem_euclid(TAU)
    };
    edge.iter().map(angle).collect()
}

/// Number of patches that are connected across edges of two triangles, and the patch of each triangle.
pub(super) fn patches(across: &[[Option<(u32, bool)>; 3]]) -> (usize, Vec<usize>) {
    let mut patch = vec![usize::MAX; across.len()];
    let mut count = 0;
    let mut front = Vec::new();
    for seed in 0..across.len() {
        if patch[seed] != usize::MAX {
            continue;
        }
        patch[seed] = count;
        front.push(seed);
        while let Some(t) = front.pop() {
            for (n, _) in across[t].iter().flatten() {
                if patch[*n as usize] == usize::MAX {
                    patch[*n as usize] = count;
                    front.push(*n as usize);
                }
            }
        }
        count += 1;
    }
    (count, patch)
}
