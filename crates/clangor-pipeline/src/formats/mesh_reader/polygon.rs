//! Triangles of a polygon.
//!
//! A convex polygon is a fan from its first corner. The fan of a concave one would cross itself: it is cut by
//! ears, in the plane across its area vector ½ Σ xᵢ × xᵢ₊₁. All corners stay in use, as the faces beside it
//! share its edges.

use clangor_core::geometry::tri_mesh::TriMesh;
use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::DVec3;

use super::MeshFault;

/// Share of the area of a polygon by which a triangle may be turned over: rounding, and faces that are not
/// flat.
const TURNED: f64 = 1e-6;
/// Most corners from which a fan is tried.
const MOST_TRIED: usize = 64;
/// Most corners of a polygon that is cut by ears: the time grows with their square, or cube where it crosses
/// itself.
const MOST_CORNERS: usize = 1000;

/// Adds the triangles of a polygon whose corners are vertices of the mesh.
pub(super) fn push_polygon(mesh: &mut TriMesh, corners: &[u32]) -> Result<(), MeshFault> {
    if corners.len() < 3 {
        return Err(MeshFault::FewCorners { corners: corners.len() });
    }
    let places: Vec<DVec3> = corners.iter().map(|corner| mesh.vertices[*corner as usize]).collect();
    let normal = area_vector(&places);
    let is_cut = |triangles: &Vec<[usize; 3]>| {
        let least = -TURNED * normal.length_squared();
        let along = |t: &[usize; 3]| area_vector(&t.map(|k| places[k])).dot(normal);
        triangles.len() == corners.len() - 2 && triangles.iter().all(|t| along(t) >= least)
    };
    // Where nothing cuts it well, the fan from its first corner: the checks of the surface tell what is
    // wrong.
    let found = Some(fan(corners.len(), 0))
        .filter(is_cut)
        .or_else(|| Some(ears(&places, normal)).filter(is_cut))
        .or_else(|| (1..corners.len().min(MOST_TRIED)).map(|first| fan(corners.len(), first)).find(is_cut))
        .unwrap_or_else(|| fan(corners.len(), 0));
    mesh.triangles.extend(found.into_iter().map(|triangle| triangle.map(|k| corners[k])));
    Ok(())
}

/// The fan of a polygon from one of its corners.
fn fan(count: usize, first: usize) -> Vec<[usize; 3]> {
    (1..count - 1).map(|k| [first, (first + k) % count, (first + k + 1) % count]).collect()
}

/// The ears of a polygon, turned like its area vector; none where it has no plane or too many corners.
fn ears(places: &[DVec3], normal: DVec3) -> Vec<[usize; 3]> {
    let points: Vec<[f64; 3]> = places.iter().map(DVec3::to_array).collect();
    let (mut flat, mut corners) = (Vec::new(), Vec::<usize>::new());
    if points.len() > MOST_CORNERS || !project3d_to_2d(&points, points.len(), &mut flat) {
        return Vec::new();
    }
    Earcut::new().earcut(flat, &[], &mut corners);
    let turned = |[a, b, c]: [usize; 3]| match area_vector(&[a, b, c].map(|k| places[k])).dot(normal) < 0.0 {
        true => [a, c, b],
        false => [a, b, c],
    };
    corners.chunks_exact(3).map(|t| turned([t[0], t[1], t[2]])).collect()
}

fn area_vector(places: &[DVec3]) -> DVec3 {
    let from = places[0];
    places.windows(2).map(|pair| (pair[0] - from).cross(pair[1] - from)).sum::<DVec3>() * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of a polygon in a tilted plane, and the sum of their areas over its own.
    fn cut(outline: &[[f64; 2]]) -> (Vec<[u32; 3]>, f64) {
        let (u, v) = (DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.0, 0.3, 1.0));
        let vertices: Vec<DVec3> = outline.iter().map(|[x, y]| *x * u + *y * v + 0.1 * DVec3::ONE).collect();
        let whole = area_vector(&vertices).length();
        let mut mesh = TriMesh { vertices, triangles: Vec::new() };
        let corners: Vec<u32> = (0..outline.len() as u32).collect();
        push_polygon(&mut mesh, &corners).expect("a polygon");
        let sum: f64 = (0..mesh.triangles.len()).map(|t| mesh.area_vector(t).length()).sum();
        (mesh.triangles, sum / whole)
    }

    #[test]
    fn polygons_are_cut_from_any_first_corner() {
        let corner = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 2.0],
            [4.0, 2.0],
            [4.0, 1.0],
            [3.0, 1.0],
            [3.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        for outline in [&corner[..], &comb, &square] {
            for first in 0..outline.len() {
                let mut turned = outline.to_vec();
                turned.rotate_left(first);
                for reversed in [false, true] {
                    if reversed {
                        turned.reverse();
                    }
                    let (triangles, area) = cut(&turned);
                    assert_eq!(triangles.len(), outline.len() - 2, "{turned:?}");
                    // Seen: 4e-16. A fan that crosses itself has more.
                    assert!((area - 1.0).abs() < 1e-12, "{turned:?}: {area}");
                }
            }
        }
        let (triangles, _) = cut(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
    }
}
