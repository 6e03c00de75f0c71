//! Boxes and dice: six grids, sewn together; a die is a cube whose edges and corners a ball has rounded.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

use glam::DVec3;

use crate::geometry::tri_mesh::TriMesh;

/// A box with full edges `edges` \[m\] about the origin, triangles with legs of at most `edge` \[m\].
pub(super) fn box_mesh(edges: DVec3, edge: f64) -> TriMesh {
    let grid = edges.to_array().map(|length| steps(-0.5 * length, 0.5 * length, edge));
    sewn_faces(&grid)
}

/// The corners of a box.
pub(super) fn box_corners(edges: DVec3) -> Vec<DVec3> {
    box_mesh(edges, f64::INFINITY).vertices
}

/// A cube of full edge `size` whose edges and corners have the radius `round` \[m\].
pub(super) fn die_mesh(size: f64, round: f64, edge: f64) -> TriMesh {
    let flat = 0.5 * size - round;
    let bends = ((FRAC_PI_4 * round / edge).ceil() as usize).max(2);
    rounded_cube(flat, round, bends, edge)
}

/// Points whose hull stands for a die in collisions: the eight corner patches, two steps per 45°. The hull
/// lies inside the die, nowhere deeper than 4 % of `round`.
pub(super) fn die_hull(size: f64, round: f64) -> Vec<DVec3> {
    rounded_cube(0.5 * size - round, round, 2, f64::INFINITY).vertices
}

/// A cube of half edge `flat` around which a ball of radius `round` has rolled, `bends` steps per 45° of
/// rounding.
fn rounded_cube(flat: f64, round: f64, bends: usize, edge: f64) -> TriMesh {
    // Equal angles along a rounded edge, up to 45°, where the next face takes over.
    let bend = |k: usize| flat + round * (FRAC_PI_4 * k as f64 / bends as f64).tan();
    let mut line: Vec<f64> = (1..=bends).rev().map(|k| -bend(k)).collect();
    if flat > 1e-9 * round {
        line.extend(steps(-flat, flat, edge));
    } else {
        line.push(0.0);
    }
    line.extend((1..=bends).map(bend));
    let mut mesh = sewn_faces(&[line.clone(), line.clone(), line]);
    for v in &mut mesh.vertices {
        let core = v.clamp(DVec3::splat(-flat), DVec3::splat(flat));
        *v = core + (*v - core).normalize() * round;
    }
    mesh
}

/// Equal steps of at most `step` from `low` to `high`.
fn steps(low: f64, high: f64, step: f64) -> Vec<f64> {
    let count = (((high - low) / step).ceil() as usize).max(1);
    // Both ends come out exactly, and opposite coordinates exactly opposite.
    let at = |k: usize| (low * (count - k) as f64 + high * k as f64) / count as f64;
    (0..=count).map(at).collect()
}

/// The surface of a box, gridded by the coordinates along each axis. Diagonals run from the middle of a face
/// to its corners, which keeps the mirror symmetries.
fn sewn_faces(grid: &[Vec<f64>; 3]) -> TriMesh {
    let mut mesh = TriMesh::default();
    let mut known: HashMap<[usize; 3], u32> = HashMap::new();
    for a in 0..3 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let last = [0, 1, 2].map(|axis| grid[axis].len() - 1);
        for level in [0, last[a]] {
            for j in 0..last[b] {
                for k in 0..last[c] {
                    let mut quad = [(j, k), (j + 1, k), (j + 1, k + 1), (j, k + 1)].map(|(j, k)| {
                        let mut cell = [0; 3];
                        (cell[a], cell[b], cell[c]) = (level, j, k);
                        *known.entry(cell).or_insert_with(|| {
                            mesh.vertices
                                .push(DVec3::from_array([0, 1, 2].map(|axis| grid[axis][cell[axis]])));
                            (mesh.vertices.len() - 1) as u32
                        })
                    });
                    if (2 * j < last[b]) != (2 * k < last[c]) {
                        quad.rotate_left(1);
                    }
                    let [p, q, r, s] = quad;
                    let flip = level == 0;
                    mesh.triangles.extend(
                        [[p, q, r], [p, r, s]].map(|[x, y, z]| if flip { [x, z, y] } else { [x, y, z] }),
                    );
                }
            }
        }
    }
    mesh
}
