//! A triangle mesh of the whole body, and the pressure at its vertices.

use std::collections::BTreeMap;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;

use super::chart::Patch;
use super::discretisation::Discretisation;
use super::symmetry::{IMAGES, mirror, sign_of};

/// Mesh of the body, in metres.
pub(super) struct Surface {
    pub(super) mesh: TriMesh,
    /// Source of the pressure at each vertex.
    origins: Vec<Origin>,
}

/// A vertex: an image of a point of a patch.
#[derive(Clone, Copy, Debug)]
struct Origin {
    image: usize,
    patch: usize,
    /// Position in the unit square of the patch.
    local: [f64; 2],
}

impl Surface {
    /// A mesh of the patches (in units of `radius`) and their images, with `STEPS` cells along each side of a
    /// patch.
    pub(super) fn new(patches: &[Patch], radius: f64) -> Self {
        let mut octant: Vec<(DVec3, usize, [f64; 2])> = Vec::new();
        let mut cells: Vec<[usize; 4]> = Vec::new();
        // Grid of points on each patch of the octant; shared points are merged.
        for (index, patch) in patches.iter().enumerate() {
            let steps = patch.nodes.map(|n| n.div_ceil(2).max(2));
            let mut grid = Vec::new();
            for j in 0..=steps[1] {
                for i in 0..=steps[0] {
                    let local = [i as f64 / steps[0] as f64, j as f64 / steps[1] as f64];
                    let u = patch.u[0] + local[0] * (patch.u[1] - patch.u[0]);
                    let v = patch.v[0] + local[1] * (patch.v[1] - patch.v[0]);
                    let x = snapped(patch.chart.position(u, v));
                    // Patches share border points. There are a few hundred points, so a linear search is
                    // cheap.
                    let known = octant.iter().position(|p| p.0.distance_squared(x) < 1e-18);
                    grid.push(known.unwrap_or_else(|| {
                        octant.push((x, index, local));
                        octant.len() - 1
                    }));
                }
            }
            for j in 0..steps[1] {
                for i in 0..steps[0] {
                    let at = |i: usize, j: usize| grid[j * (steps[0] + 1) + i];
                    cells.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
        let mut it =
            Surface { mesh: TriMesh { vertices: Vec::new(), triangles: Vec::new() }, origins: Vec::new() };
        let mut numbers: BTreeMap<(usize, usize), u32> = BTreeMap::new();
        // Images of the octant in the eight octants.
        for image in 0..IMAGES {
            for cell in &cells {
                let corners = cell.map(|point| {
                    let (x, patch, local) = octant[point];
                    // A point on a plane of symmetry is its own image.
                    let on = [x.x, x.y, x.z].map(|c| c == 0.0);
                    let image = (0..3)
                        .filter(|&bit| image >> bit & 1 == 1 && !on[bit])
                        .fold(0, |m, bit| m | 1 << bit);
                    *numbers.entry((point, image)).or_insert_with(|| {
                        it.mesh.vertices.push(radius * mirror(image, x));
                        it.origins.push(Origin { image, patch, local });
                        it.origins.len() as u32 - 1
                    })
                });
                // An odd number of reflections reverses the orientation.
                let odd = image.count_ones() % 2 == 1;
                for mut triangle in
                    [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
                {
                    if odd {
                        triangle.swap(1, 2);
                    }
                    it.mesh.triangles.push(triangle);
                }
            }
        }
        it
    }

    /// Pressure of the six motions at the vertices, from that at the nodes.
    pub(super) fn pressure(
        &self,
        body: &Discretisation,
        nodes: &[[Complex64; RIGID_DOFS]],
    ) -> Vec<[Complex64; RIGID_DOFS]> {
        self.origins
            .iter()
            .map(|origin| {
                let patch = &body.patches[origin.patch];
                let basis: [Vec<f64>; 2] = std::array::from_fn(|axis| {
                    let mut values = vec![0.0; patch.nodes[axis]];
                    body.rules.gauss(patch.nodes[axis]).basis(origin.local[axis], &mut values);
                    values
                });
                let mut sum = [Complex64::ZERO; RIGID_DOFS];
                let first = body.first_node[origin.patch];
                for (j, v) in basis[1].iter().enumerate() {
                    for (i, u) in basis[0].iter().enumerate() {
                        for (sum, p) in sum.iter_mut().zip(&nodes[first + j * patch.nodes[0] + i]) {
                            *sum += u * v * p;
                        }
                    }
                }
                std::array::from_fn(|degree| sign_of(origin.image, degree) * sum[degree])
            })
            .collect()
    }
}

/// The point with coordinates set to zero where they are zero up to rounding.
fn snapped(x: DVec3) -> DVec3 {
    x.map(|c| if c.abs() < 1e-12 { 0.0 } else { c })
}
