//! The neighbourhood of a point of a tetrahedral complex, and the link conditions of an edge contraction.

/// The cells, faces and edges around a point.
#[derive(Default)]
pub(super) struct Star {
    /// Opposite faces of its cells.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Edges of these, ascending.
    pub(super) edges: Vec<[u32; 2]>,
    pub(super) points: Vec<u32>,
    pub(super) outer_edges: Vec<[u32; 2]>,
    pub(super) outer_points: Vec<u32>,
    /// Edges whose triangle with the point separates two regions.
    pub(super) wall_edges: Vec<[u32; 2]>,
    pub(super) wall_points: Vec<u32>,
    /// Points to which a line runs where walls meet.
    pub(super) line_points: Vec<u32>,
}

impl Star {
    pub(super) fn is_end_of_lines(&self) -> bool {
        !self.line_points.is_empty() && self.line_points.len() != 2
    }
}

/// Whether contracting the edge between two points preserves the topology of all regions and of their common
/// walls and lines.
pub(super) fn keeps_regions(a: &Star, b: &Star, to: u32) -> bool {
    let pair = |w: u32| [w.min(to), w.max(to)];
    let triple = |[w, x]: [u32; 2]| {
        let mut key = [w, x, to];
        key.sort_unstable();
        key
    };
    // Link conditions of the complex, of the complex with the outside as a further point, of walls and of
    // lines.
    let whole = common(&a.points, &b.points).all(|w| a.edges.binary_search(&pair(w)).is_ok())
        && common(&a.edges, &b.edges).all(|e| a.triangles.binary_search(&triple(e)).is_ok())
        && common(&a.triangles, &b.triangles).next().is_none();
    let joined =
        |own: &[u32], other: &[u32]| own.is_empty() || other.is_empty() || own.binary_search(&to).is_ok();
    let outside = joined(&a.outer_points, &b.outer_points)
        && common(&a.outer_points, &b.outer_points).all(|w| a.outer_edges.binary_search(&pair(w)).is_ok())
        && common(&a.outer_edges, &b.outer_edges).next().is_none();
    let walls = joined(&a.wall_points, &b.wall_points)
        && common(&a.wall_points, &b.wall_points).all(|w| a.wall_edges.binary_search(&pair(w)).is_ok())
        && common(&a.wall_edges, &b.wall_edges).next().is_none();
    let lines = joined(&a.line_points, &b.line_points)
        && common(&a.line_points, &b.line_points).next().is_none()
        && !(a.is_end_of_lines() && b.is_end_of_lines());
    whole && outside && walls && lines
}

/// Common items of two ascending lists.
fn common<'l, T: Ord + Copy>(a: &'l [T], b: &'l [T]) -> impl Iterator<Item = T> + 'l {
    a.iter().copied().filter(|x| b.binary_search(x).is_ok())
}

pub(super) fn points_of(edges: &[[u32; 2]]) -> Vec<u32> {
    let mut points: Vec<u32> = edges.iter().flatten().copied().collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// The other three corners, ascending.
pub(super) fn others(corners: [u32; 4], point: u32) -> [u32; 3] {
    let mut rest = [0; 3];
    corners.iter().filter(|n| **n != point).zip(&mut rest).for_each(|(n, r)| *r = *n);
    rest.sort_unstable();
    rest
}
