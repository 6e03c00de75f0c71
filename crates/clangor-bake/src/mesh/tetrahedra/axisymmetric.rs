//! Bodies that are axisymmetric about y: the triangles of a section, rotated from sector to sector.
//!
//! Each triangle sweeps a prism, which is cut into three tetrahedra along the order of its corners' numbers,
//! so that neighbours match. At the axis prisms degenerate, and have fewer tetrahedra.

use std::f64::consts::TAU;

use clangor_core::geometry::turning::on_ring;
use glam::{DVec2, DVec3};

use super::{TetMesh, TetMeshError};

/// Points of the section closer to the axis than this fraction of the largest radius lie on it.
const ON_AXIS: f64 = 1e-9;

/// Triangles (r, y) \[m\], rotated by a full turn in `sectors` steps; edges are straight.
///
/// # Errors
/// [`TetMeshError`] for no triangles or fewer than three sectors.
pub fn sweep_section(
    points: &[DVec2],
    triangles: &[[u32; 3]],
    sectors: usize,
) -> Result<TetMesh, TetMeshError> {
    if sectors < 3 {
        return Err(TetMeshError::Empty);
    }
    // Nodes: one on the axis, otherwise one per sector.
    let widest = points.iter().fold(0.0_f64, |widest, p| widest.max(p.x));
    let mut nodes: Vec<DVec3> = Vec::new();
    // First node and number of nodes of each point.
    let mut rings: Vec<(usize, usize)> = Vec::with_capacity(points.len());
    for point in points {
        let count = if point.x <= ON_AXIS * widest { 1 } else { sectors };
        rings.push((nodes.len(), count));
        nodes.extend((0..count).map(|s| match count {
            1 => DVec3::new(0.0, point.y, 0.0),
            _ => on_ring(*point, TAU * s as f64 / sectors as f64),
        }));
    }
    let at = |point: u32, sector: usize| {
        let (first, count) = rings[point as usize];
        (first + sector % count) as u32
    };
    let mut tetrahedra = Vec::with_capacity(3 * sectors * triangles.len());
    // Tetrahedra of each swept prism.
    for triangle in triangles {
        let mut sorted = *triangle;
        sorted.sort_unstable();
        for s in 0..sectors {
            let here = sorted.map(|p| at(p, s));
            let there = sorted.map(|p| at(p, s + 1));
            // The prism's edge k degenerates on the axis if both ends are the same node.
            for k in (0..3).filter(|k| here[*k] != there[*k]) {
                tetrahedra.push(std::array::from_fn(|n| if n <= k { here[n] } else { there[n - 1] }));
            }
        }
    }
    TetMesh::straight(nodes, &tetrahedra)
}
