//! A triangle divided by lines in it, by a constrained Delaunay triangulation of its plane.

use std::collections::HashSet;

use glam::DVec3;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::lines::Within;
use super::{Degenerate, sorted};

/// A vertex in the plane.
struct Corner {
    at: Point2<f64>,
    vertex: u32,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Adds the parts of a triangle, and the edges of parts along lines.
///
/// # Errors
/// [`Degenerate`] if points coincide or lines cross after rounding.
pub(super) fn divide(
    vertices: &[DVec3],
    within: &Within,
    parts: &mut Vec<[u32; 3]>,
    cuts: &mut HashSet<[u32; 2]>,
) -> Result<(), Degenerate> {
    let plane = Plane::of(within.area, vertices[within.border[0] as usize]);
    let mut mesh = ConstrainedDelaunayTriangulation::<Corner>::new();
    let mut handles: Vec<(u32, FixedVertexHandle)> = Vec::new();
    for vertex in within.border.iter().chain(&within.inside) {
        let corner = Corner { at: plane.at(vertices[*vertex as usize]), vertex: *vertex };
        handles.push((*vertex, mesh.insert(corner).map_err(|_| Degenerate)?));
        if mesh.num_vertices() < handles.len() {
            return Err(Degenerate);
        }
    }
    let handle = |vertex: u32| handles.iter().find(|(v, _)| *v == vertex).map(|(_, handle)| *handle);
    let count = within.border.len();
    let border: Vec<[u32; 2]> =
        (0..count).map(|k| [within.border[k], within.border[(k + 1) % count]]).collect();
    for [a, b] in border.iter().chain(&within.segments) {
        let (Some(a), Some(b)) = (handle(*a), handle(*b)) else { return Err(Degenerate) };
        if !mesh.can_add_constraint(a, b) {
            return Err(Degenerate);
        }
        mesh.add_constraint(a, b);
    }
    let border: HashSet<[u32; 2]> = border.into_iter().map(|[a, b]| sorted(a, b)).collect();
    let mut faces = Vec::new();
    for face in mesh.inner_faces() {
        let edges = face.adjacent_edges().map(|edge| {
            let ends = edge.vertices().map(|vertex| vertex.data().vertex);
            let is_cut = mesh.is_constraint_edge(edge.as_undirected().fix());
            (sorted(ends[0], ends[1]), is_cut, edge.rev().is_outer_edge())
        });
        faces.push((face.vertices().map(|vertex| vertex.data().vertex), edges));
    }
    // Rounding bends the border: slivers between it and the hull of the points are no parts.
    let mut beyond: HashSet<[u32; 2]> = HashSet::new();
    while let Some(sliver) = faces.iter().position(|(_, edges)| {
        edges.iter().any(|(ends, _, is_hull)| (*is_hull || beyond.contains(ends)) && !border.contains(ends))
    }) {
        let (_, edges) = faces.swap_remove(sliver);
        beyond.extend(edges.map(|(ends, ..)| ends));
    }
    for (corners, edges) in faces {
        cuts.extend(edges.iter().filter(|(ends, is_cut, _)| *is_cut && !border.contains(ends)).map(|e| e.0));
        let [a, b, c] = corners;
        parts.push(if plane.is_turned { [a, c, b] } else { [a, b, c] });
    }
    Ok(())
}

/// The plane of coordinates that a triangle faces most.
struct Plane {
    axes: [usize; 2],
    origin: DVec3,
    /// Whether the triangle faces against the third axis.
    is_turned: bool,
}

impl Plane {
    fn of(area: DVec3, origin: DVec3) -> Self {
        let size = area.abs().to_array();
        let third = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        Plane { axes: [(third + 1) % 3, (third + 2) % 3], origin, is_turned: area[third] < 0.0 }
    }

    fn at(&self, x: DVec3) -> Point2<f64> {
        let [u, v] = self.axes.map(|axis| x[axis] - self.origin[axis]);
        Point2::new(u, v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_divides_a_triangle_into_parts_that_face_as_it_does() {
        let vertices =
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.3, 0.0], [0.2, 0.3], [0.5, 0.5]].map(|[x, y]| [x, y]);
        for turned in [false, true] {
            let at = |[x, y]: [f64; 2]| if turned { DVec3::new(y, x, 0.0) } else { DVec3::new(x, y, 0.0) };
            let vertices: Vec<DVec3> = vertices.into_iter().map(at).collect();
            let area = if turned { -0.5 * DVec3::Z } else { 0.5 * DVec3::Z };
            let within =
                Within { border: vec![0, 3, 1, 5, 2], area, inside: vec![4], segments: vec![[3, 4], [4, 5]] };
            let (mut parts, mut cuts) = (Vec::new(), HashSet::new());
            assert_eq!(divide(&vertices, &within, &mut parts, &mut cuts), Ok(()));
            assert_eq!(cuts, HashSet::from([[3, 4], [4, 5]]));
            let areas = parts.iter().map(|part| {
                let [a, b, c] = part.map(|v| vertices[v as usize]);
                0.5 * (b - a).cross(c - a)
            });
            let areas: Vec<DVec3> = areas.collect();
            assert!(areas.iter().all(|own| own.dot(area) > 0.0), "{areas:?}");
            // Seen: 5.6e-17.
            assert!(areas.into_iter().sum::<DVec3>().distance(area) < 1e-15);
        }
    }

    #[test]
    fn lines_that_cross_and_points_that_coincide_are_refused() {
        let vertices = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.3, 0.0], [0.2, 0.3], [0.1, 0.1], [0.3, 0.1]];
        let mut vertices: Vec<DVec3> = vertices.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let of = |inside: Vec<u32>, segments: Vec<[u32; 2]>| Within {
            border: vec![0, 3, 1, 2],
            area: 0.5 * DVec3::Z,
            inside,
            segments,
        };
        let crossing = of(vec![4, 5, 6], vec![[3, 4], [5, 6]]);
        assert_eq!(divide(&vertices, &crossing, &mut Vec::new(), &mut HashSet::new()), Err(Degenerate));
        vertices[5] = vertices[4];
        let double = of(vec![4, 5], vec![[3, 4]]);
        assert_eq!(divide(&vertices, &double, &mut Vec::new(), &mut HashSet::new()), Err(Degenerate));
    }
}
