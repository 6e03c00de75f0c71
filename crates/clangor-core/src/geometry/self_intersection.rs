//! Whether a closed surface crosses itself.
//!
//! Two triangles that share no edge cross where an edge of one pierces the other. Triangles that share an
//! edge can only fold flat onto each other. Pairs come from a tree of boxes.

use glam::DVec3;

use super::mesh_error::MeshError;
use super::surface_tree::SurfaceTree;
use super::topology::Topology;
use super::tri_mesh::TriMesh;

/// The first crossing, in the order of the triangles.
pub(super) fn first_self_intersection(
    mesh: &TriMesh,
    topology: &Topology,
    tree: &SurfaceTree,
) -> Option<MeshError> {
    let (first, second, position) = crossings(mesh, topology, tree, 1).first().copied()?;
    Some(MeshError::SelfIntersection { first, second, position })
}

/// Up to `most` pairs of triangles that cross, with a place; those that fold onto a neighbour first.
pub(super) fn crossings(
    mesh: &TriMesh,
    topology: &Topology,
    tree: &SurfaceTree,
    most: usize,
) -> Vec<(usize, usize, DVec3)> {
    let mut found = Vec::new();
    // Distances below this are rounding: surfaces that touch do not cross.
    let rounding = 1e-12 * mesh.bounding_radius(DVec3::ZERO);
    for (t, neighbours) in topology.neighbours.iter().enumerate() {
        for n in neighbours.map(|n| n as usize) {
            let cosine = mesh.area_vector(t).normalize().dot(mesh.area_vector(n).normalize());
            if n > t && cosine < -1.0 + 1e-14 {
                found.push((t, n, mesh.centroid(t)));
            }
        }
    }
    if found.len() >= most {
        found.truncate(most);
        return found;
    }
    tree.overlapping_pairs(mesh, 0.0, &mut |first, second| {
        found.extend(crossing(mesh, first, second, rounding).map(|position| (first, second, position)));
        found.len() >= most
    });
    found
}

/// A point where two triangles cross.
fn crossing(mesh: &TriMesh, first: usize, second: usize, rounding: f64) -> Option<DVec3> {
    let shared = mesh.triangles[first].iter().filter(|i| mesh.triangles[second].contains(i)).count();
    if shared > 1 {
        return None;
    }
    let pierced = |a: usize, b: usize| {
        let target = mesh.corners(b);
        let normal = mesh.area_vector(b).normalize();
        (0..3).find_map(|k| {
            let ends = [mesh.triangles[a][k], mesh.triangles[a][(k + 1) % 3]];
            // An edge that ends at the shared vertex touches there and nowhere else, unless the triangles
            // overlap in one plane, where the edge opposite to the vertex tells.
            if ends.iter().any(|i| mesh.triangles[b].contains(i)) {
                return None;
            }
            pierce(ends.map(|i| mesh.vertices[i as usize]), target, normal, rounding)
        })
    };
    pierced(first, second)
        .or_else(|| pierced(second, first))
        .or_else(|| if shared == 0 { overlap_in_plane(mesh, first, second, rounding) } else { None })
}

/// Where a segment passes through a triangle, edges included, from one side of its plane to the other.
fn pierce([p, q]: [DVec3; 2], target: [DVec3; 3], normal: DVec3, rounding: f64) -> Option<DVec3> {
    let (dp, dq) = ((p - target[0]).dot(normal), (q - target[0]).dot(normal));
    if dp.abs() <= rounding || dq.abs() <= rounding || (dp < 0.0) == (dq < 0.0) {
        return None;
    }
    let x = p + (q - p) * (dp / (dp - dq));
    let inside = (0..3).all(|k| {
        let (a, b) = (target[k], target[(k + 1) % 3]);
        (b - a).cross(x - a).dot(normal) >= 0.0
    });
    inside.then_some(x)
}

/// A point where two triangles of one plane overlap by more than their borders.
fn overlap_in_plane(mesh: &TriMesh, first: usize, second: usize, rounding: f64) -> Option<DVec3> {
    let (a, b) = (mesh.corners(first), mesh.corners(second));
    let normal = mesh.area_vector(first).normalize();
    if b.iter().any(|v| (*v - a[0]).dot(normal).abs() > rounding) {
        return None;
    }
    // Separating axes in the plane: the edge normals of both triangles.
    let edges = [a, b].into_iter().flat_map(|t| [t[1] - t[0], t[2] - t[1], t[0] - t[2]]);
    for axis in edges.map(|e| e.cross(normal).normalize()) {
        let range = |t: &[DVec3; 3]| {
            let x = t.map(|v| (v - a[0]).dot(axis));
            (x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2]))
        };
        let ((a0, a1), (b0, b1)) = (range(&a), range(&b));
        if a1 <= b0 + rounding || b1 <= a0 + rounding {
            return None;
        }
    }
    Some(0.5 * (mesh.centroid(first) + mesh.centroid(second)))
}
