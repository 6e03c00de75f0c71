//! Convex hull of points in space: incremental, quadratic at worst, for the few hundred points of a part.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use robust::{Coord3D, orient3d};

use super::solid::MeshError;
use super::tri_mesh::TriMesh;

/// The convex hull as a closed mesh that holds only the points it uses.
///
/// Points within 1e-12 of the extent of a face's plane count as on it; points on a face or inside vanish.
///
/// # Errors
/// [`MeshError::NotFinite`], or [`MeshError::NoVolume`] for points that lie in one plane.
pub fn convex_hull(points: &[DVec3]) -> Result<TriMesh, MeshError> {
    if let Some(vertex) = points.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NotFinite { vertex });
    }
    let start = first_tetrahedron(points)?;
    let extent = points.iter().map(|p| p.distance(points[start[0]])).fold(0.0, f64::max);
    let margin = 1e-12 * extent;
    let is_outside = |face: &[u32; 3], point: DVec3| height(points, *face, point) > margin;
    // Rounded heights see faces in nearly one plane in patches, and the hull would grow without end.
    let faces = grown(points, start, is_outside, is_outside)
        .or_else(|| grown(points, start, is_outside, |face, point| is_above(points, *face, point)))
        .ok_or(MeshError::NoVolume { volume: 0.0 })?;
    Ok(TriMesh { vertices: points.to_vec(), triangles: faces }.weld(0.0))
}

/// The faces of a hull that grows from four of the points; `None` where those that a point sees are no disc.
fn grown(
    points: &[DVec3],
    start: [usize; 4],
    is_outside: impl Fn(&[u32; 3], DVec3) -> bool,
    is_seen: impl Fn(&[u32; 3], DVec3) -> bool,
) -> Option<Vec<[u32; 3]>> {
    let [a, b, c, d] = start.map(|i| i as u32);
    let mut faces = vec![[a, b, c], [a, c, d], [a, d, b], [b, d, c]];
    if height(points, faces[0], points[d as usize]) > 0.0 {
        faces.iter_mut().for_each(|f| f.swap(1, 2));
    }
    for (i, point) in points.iter().enumerate() {
        if start.contains(&i) || !faces.iter().any(|f| is_outside(f, *point)) {
            continue;
        }
        let (seen, hidden): (Vec<_>, Vec<_>) = faces.iter().partition(|f| is_seen(f, *point));
        // The rim of the seen faces: their directed edges whose opposite is not theirs.
        let sides = |f: &[u32; 3]| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])];
        let edges: HashSet<(u32, u32)> = seen.iter().flat_map(sides).collect();
        let rim: Vec<(u32, u32)> =
            seen.iter().flat_map(sides).filter(|(u, v)| !edges.contains(&(*v, *u))).collect();
        if !is_one_loop(&rim) {
            return None;
        }
        faces = hidden.into_iter().chain(rim.into_iter().map(|(u, v)| [u, v, i as u32])).collect();
    }
    Some(faces)
}

/// Whether directed edges are one closed loop that meets itself nowhere.
fn is_one_loop(edges: &[(u32, u32)]) -> bool {
    let next: HashMap<u32, u32> = edges.iter().copied().collect();
    let Some((first, _)) = edges.first() else { return false };
    let (mut at, mut count) = (*first, 0);
    while let Some(to) = next.get(&at).filter(|_| count < edges.len()) {
        (at, count) = (*to, count + 1);
        if at == *first {
            break;
        }
    }
    at == *first && count == edges.len() && next.len() == count
}

/// Convex hull of the vertices that lie farthest in so many directions, spread evenly over the sphere: a
/// little less than the convex hull, for the price of a few points.
///
/// # Errors
/// Those of [`convex_hull`].
pub fn extreme_hull(mesh: &TriMesh, directions: usize) -> Result<TriMesh, MeshError> {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let mut extremes: Vec<usize> = (0..directions)
        .filter_map(|k| {
            let y = 1.0 - (2 * k + 1) as f64 / directions as f64;
            let (sin, cos) = (golden * k as f64).sin_cos();
            let direction = DVec3::new((1.0 - y * y).sqrt() * cos, y, (1.0 - y * y).sqrt() * sin);
            let height = |i: &usize| mesh.vertices[*i].dot(direction);
            (0..mesh.vertices.len()).max_by(|i, j| height(i).total_cmp(&height(j)))
        })
        .collect();
    extremes.sort_unstable();
    extremes.dedup();
    let points: Vec<DVec3> = extremes.into_iter().map(|i| mesh.vertices[i]).collect();
    convex_hull(&points)
}

/// Height of a point above a face \[m\].
fn height(points: &[DVec3], face: [u32; 3], point: DVec3) -> f64 {
    let [a, b, c] = face.map(|i| points[i as usize]);
    (b - a).cross(c - a).normalize_or_zero().dot(point - a)
}

/// Whether a point is above a face.
fn is_above(points: &[DVec3], face: [u32; 3], point: DVec3) -> bool {
    let [a, b, c] = face.map(|i| points[i as usize]);
    let [a, b, c, point] = [a, b, c, point].map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    orient3d(a, b, c, point) < 0.0
}

/// Four points far from one plane.
fn first_tetrahedron(points: &[DVec3]) -> Result<[usize; 4], MeshError> {
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        let best = (0..points.len()).max_by(|i, j| measure(points[*i]).total_cmp(&measure(points[*j])));
        best.map(|i| (i, measure(points[i])))
    };
    let flat = MeshError::NoVolume { volume: 0.0 };
    let (i, _) = farthest(&|p| -p.x).ok_or(flat.clone())?;
    let a = points[i];
    let (j, span) = farthest(&|p| p.distance(a)).ok_or(flat.clone())?;
    let along = (points[j] - a).normalize_or_zero();
    let (k, width) = farthest(&|p| (p - a).reject_from_normalized(along).length()).ok_or(flat.clone())?;
    let normal = along.cross(points[k] - a).normalize_or_zero();
    let (l, depth) = farthest(&|p| (p - a).dot(normal).abs()).ok_or(flat.clone())?;
    if span > 0.0 && width > 1e-12 * span && depth > 1e-12 * span { Ok([i, j, k, l]) } else { Err(flat) }
}

/// Largest height of a vertex above a face of its own surface \[m\]: 0 for a convex mesh, up to rounding.
///
/// Only neighbours across an edge are compared: a closed connected surface that is convex there is convex.
pub fn concavity(mesh: &TriMesh) -> Result<f64, MeshError> {
    let topology = super::topology::Topology::try_new(mesh)?;
    let mut worst = 0.0_f64;
    for (t, neighbours) in topology.neighbours.iter().enumerate() {
        let normal = mesh.area_vector(t).normalize_or_zero();
        let base = mesh.corners(t)[0];
        for n in neighbours {
            for corner in mesh.corners(*n as usize) {
                worst = worst.max((corner - base).dot(normal));
            }
        }
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// Clusters of points around the corners of a box, far closer to each other than it is wide.
    #[test]
    fn a_box_with_tiny_roundings_has_a_hull() {
        let mut random = SplitMix::new(1);
        for size in [1e-5, 1e-7, 1e-9, 1e-11] {
            let cluster = |k: usize| {
                let side = |axis: usize| if k >> axis & 1 == 0 { -0.1 } else { 0.1 };
                DVec3::new(side(0), side(1), side(2))
            };
            let points: Vec<DVec3> =
                (0..8 * 150).map(|n| cluster(n % 8) + size * random.direction()).collect();
            let hull = convex_hull(&points).unwrap();
            let (concave, larger) = (concavity(&hull).unwrap(), hull.area() / 0.24 - 1.0);
            // Seen: 1.2e-21 m, and an area that is larger by 15 sizes.
            assert!(concave < 1e-12 && larger.abs() < 40.0 * size + 1e-9, "{size}: {concave:e} {larger:e}");
        }
    }
}
