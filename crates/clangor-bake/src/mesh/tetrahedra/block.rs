//! Boxes: a grid of cells, each cut into six tetrahedra around a diagonal, and the even division of a
//! tetrahedron.

use glam::DVec3;

use super::{TetMesh, TetMeshError};

/// A box about the origin with full edges \[m\], `cells` along each axis.
///
/// Cells are cut as mirror images of each other about the middle, so that the mesh has the mirror symmetries
/// of the box where the counts are even.
///
/// # Errors
/// [`TetMeshError`] for edges that are not positive and finite, or no cells.
pub fn block(edges: DVec3, cells: [usize; 3]) -> Result<TetMesh, TetMeshError> {
    let (points, tetrahedra) = grid(cells, |at| (at - 0.5) * edges);
    if !edges.is_finite() {
        return Err(TetMeshError::Empty);
    }
    TetMesh::straight(points, &tetrahedra)
}

/// The unit cube as a grid of `cells`, mapped.
pub(super) fn grid(cells: [usize; 3], map: impl Fn(DVec3) -> DVec3) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let [nx, ny, nz] = cells;
    // Grid points.
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                points.push(map(DVec3::new(
                    i as f64 / nx as f64,
                    j as f64 / ny as f64,
                    k as f64 / nz as f64,
                )));
            }
        }
    }
    let at = |[i, j, k]: [usize; 3]| ((k * (ny + 1) + j) * (nx + 1) + i) as u32;
    // Six Kuhn tetrahedra per cell, around the diagonal.
    let mut tetrahedra = Vec::with_capacity(6 * nx * ny * nz);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                // The diagonal runs from the corner nearest the middle to the farthest.
                let low = [i, j, k];
                let near: [usize; 3] =
                    std::array::from_fn(|a| low[a] + usize::from(2 * low[a] + 1 < cells[a]));
                let far: [usize; 3] = std::array::from_fn(|a| 2 * low[a] + 1 - near[a]);
                for [a, b, _] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
                    let mut first = near;
                    first[a] = far[a];
                    let mut second = first;
                    second[b] = far[b];
                    tetrahedra.push([near, first, second, far].map(at));
                }
            }
        }
    }
    (points, tetrahedra)
}

/// A tetrahedron cut into divisions³ of equal volume; `place` gives the point of the barycentric weights.
pub(super) fn divide_tetrahedron(
    divisions: usize,
    place: impl Fn([f64; 4]) -> DVec3,
) -> impl Iterator<Item = [DVec3; 4]> {
    let n = divisions;
    let mut pieces: Vec<[DVec3; 4]> = Vec::new();
    // Kuhn's simplex n ≥ x ≥ y ≥ z ≥ 0 holds exactly the whole Kuhn tetrahedra of the cells inside it.
    let point = |[x, y, z]: [usize; 3]| {
        let weights = [n - x, x - y, y - z, z].map(|w| w as f64 / n as f64);
        place(weights)
    };
    for x in 0..n {
        for y in 0..=x {
            for z in 0..=y {
                for [a, b, c] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
                    let mut path = [[x, y, z]; 4];
                    for (step, axis) in [a, b, c].into_iter().enumerate() {
                        path[step + 1] = path[step];
                        path[step + 1][axis] += 1;
                    }
                    if path.iter().all(|p| p[0] <= n && p[0] >= p[1] && p[1] >= p[2]) {
                        pieces.push(path.map(point));
                    }
                }
            }
        }
    }
    pieces.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_filled_once() {
        let mesh = block(DVec3::new(0.3, 0.2, 0.1), [5, 3, 2]).expect("a box");
        let quality = mesh.quality();
        // Residual seen: 4e-15.
        assert!((quality.volume / 6e-3 - 1.0).abs() < 1e-12);
        assert_eq!(mesh.elements.len(), 180);
        assert_eq!(mesh.surface().len(), 4 * (15 + 10 + 6));
        assert_eq!(mesh.nodes.len(), 11 * 7 * 5);
    }

    #[test]
    fn a_tetrahedron_is_divided_into_equal_parts() {
        for n in [1, 2, 3, 5] {
            let parts: Vec<_> = divide_tetrahedron(n, |w| DVec3::new(w[1], w[2], w[3])).collect();
            assert_eq!(parts.len(), n.pow(3));
            for [a, b, c, d] in parts {
                let volume = (b - a).cross(c - a).dot(d - a).abs();
                assert!((volume * (n as f64).powi(3) - 1.0).abs() < 1e-12, "{volume}");
            }
        }
    }
}
