//! Connected components of a closed surface, and in how many of the others each lies: outer surfaces in none,
//! cavities in one, what lies in a cavity in two.

use glam::DVec3;

use super::mesh_error::MeshError;
use super::topology::Topology;
use super::tri_mesh::TriMesh;
use crate::math::disjoint_sets::DisjointSets;

/// A component of a surface.
pub(super) struct Component {
    /// Its triangles, each with vertices of its own.
    pub(super) part: TriMesh,
    /// Enclosed volume \[m³\], negative where it faces inwards.
    pub(super) volume: f64,
    /// Number of other components around it.
    pub(super) depth: usize,
}

/// The components of a mesh, from their number and that of each triangle.
pub(super) fn components_of(mesh: &TriMesh, count: usize, piece: &[u32]) -> Vec<Component> {
    let mut parts = vec![TriMesh::default(); count];
    for (t, k) in piece.iter().enumerate() {
        let part = &mut parts[*k as usize];
        let start = part.vertices.len() as u32;
        part.vertices.extend(mesh.corners(t));
        part.triangles.push([start, start + 1, start + 2]);
    }
    let bounds: Vec<(DVec3, DVec3)> = parts.iter().map(TriMesh::bounds).collect();
    let depth = |k: usize| {
        let position = parts[k].vertices[0];
        let inside = |other: &usize| {
            let (low, high) = bounds[*other];
            *other != k
                && position.cmpge(low).all()
                && position.cmple(high).all()
                && winding_number(&parts[*other], position).abs() > 0.5
        };
        (0..count).filter(inside).count()
    };
    let depths: Vec<usize> = (0..count).map(depth).collect();
    let of = |(part, depth): (TriMesh, usize)| {
        let volume = winding_volume(&part, part.vertices[0]);
        Component { part, volume, depth }
    };
    parts.into_iter().zip(depths).map(of).collect()
}

/// Number of components that face outwards: solids; the others bound cavities.
///
/// # Errors
/// [`MeshError`] of a surface that is not closed.
pub fn solid_count(mesh: &TriMesh) -> Result<usize, MeshError> {
    let (count, piece) = Topology::try_new(mesh)?.components();
    Ok(components_of(mesh, count, &piece).iter().filter(|part| part.volume > 0.0).count())
}

/// Whether each triangle of a closed surface belongs to an outer surface, which lies in no other. `None` if
/// all do: there are no cavities. Also `None` if the surface is not closed.
pub fn outer_triangles(mesh: &TriMesh) -> Option<Vec<bool>> {
    if hangs_together(mesh) {
        return None;
    }
    let (count, piece) = Topology::try_new(mesh).ok()?.components();
    if count < 2 {
        return None;
    }
    let parts = components_of(mesh, count, &piece);
    let outer: Vec<bool> = piece.iter().map(|k| parts[*k as usize].depth == 0).collect();
    (!outer.iter().all(|outer| *outer)).then_some(outer)
}

/// Whether all triangles hang together by their vertices: most meshes do, and are told so in little time.
fn hangs_together(mesh: &TriMesh) -> bool {
    let mut sets = DisjointSets::new(mesh.vertices.len());
    for [a, b, c] in mesh.triangles.iter().map(|corners| corners.map(|n| n as usize)) {
        sets.join(a, b);
        sets.join(a, c);
    }
    let mut corners = mesh.triangles.iter().map(|[a, ..]| *a as usize);
    let first = corners.next().map(|n| sets.root(n));
    corners.all(|n| Some(sets.root(n)) == first)
}

/// Signed volume [m³] from tetrahedra to `reference`.
pub(super) fn winding_volume(mesh: &TriMesh, reference: DVec3) -> f64 {
    let tetrahedron = |t| {
        let [a, b, c] = mesh.corners(t).map(|v| v - reference);
        a.dot(b.cross(c)) / 6.0
    };
    (0..mesh.triangles.len()).map(tetrahedron).sum()
}

/// Winding number of a closed surface around a point: the sum of the solid angles over 4π.
///
/// Source: Van Oosterom and Strackee (1983), "The Solid Angle of a Plane Triangle".
pub(super) fn winding_number(mesh: &TriMesh, point: DVec3) -> f64 {
    let half_angle = |t| {
        let [a, b, c] = mesh.corners(t).map(|v| v - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        a.dot(b.cross(c)).atan2(below)
    };
    (0..mesh.triangles.len()).map(half_angle).sum::<f64>() / (2.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron in a cube of edge 2 `size`, turned inside out if that is negative.
    fn add(size: f64, at: DVec3, mesh: &mut TriMesh) {
        let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let start = mesh.vertices.len() as u32;
        mesh.vertices.extend(corners.map(|v| at + size.abs() * DVec3::from_array(v)));
        let turned = |[a, b, c]: [u32; 3]| if size < 0.0 { [a, c, b] } else { [a, b, c] };
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        mesh.triangles.extend(faces.map(turned).map(|t| t.map(|n| n + start)));
    }

    #[test]
    fn what_lies_in_a_cavity_is_not_outside() {
        let mut mesh = TriMesh::default();
        add(1.0, DVec3::ZERO, &mut mesh);
        assert_eq!(outer_triangles(&mesh), None);
        add(1.0, 3.0 * DVec3::X, &mut mesh);
        assert_eq!(outer_triangles(&mesh), None);
        // A cavity with a pea in it.
        add(-0.7, DVec3::ZERO, &mut mesh);
        add(0.2, 0.05 * DVec3::Y, &mut mesh);
        let outer = outer_triangles(&mesh).expect("a cavity");
        let count = mesh.triangles.len() / 4;
        assert!(outer[..2 * count].iter().all(|outer| *outer));
        assert!(outer[2 * count..].iter().all(|outer| !*outer));
    }
}
