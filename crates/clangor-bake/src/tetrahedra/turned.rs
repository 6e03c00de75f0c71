//! Bodies of revolution about y: the triangles of a section, turned from sector to sector.
//!
//! Each triangle sweeps a prism, cut into three tetrahedra along the order of its corners' numbers, so that neighbours
//! agree; at the axis prisms are less, and so are their tetrahedra.

use std::f64::consts::TAU;

use clangor::geometry::turning::on_ring;
use glam::{DVec2, DVec3};

use super::{TetMesh, TetMeshError};

/// Points of the section closer to the axis than this part of the widest are on it.
const ON_AXIS: f64 = 1e-9;

/// Triangles (r, y) \[m\], turned all around in `sectors` steps; edges are straight.
///
/// # Errors
/// [`TetMeshError`] for no triangles or fewer than three sectors.
pub fn turned(points: &[DVec2], triangles: &[[u32; 3]], sectors: usize) -> Result<TetMesh, TetMeshError> {
    if sectors < 3 {
        return Err(TetMeshError::Empty);
    }
    let widest = points.iter().fold(0.0_f64, |widest, p| widest.max(p.x));
    let mut nodes: Vec<DVec3> = Vec::new();
    // The first node of each point, and how many it has.
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
    for triangle in triangles {
        let mut sorted = *triangle;
        sorted.sort_unstable();
        for s in 0..sectors {
            let here = sorted.map(|p| at(p, s));
            let there = sorted.map(|p| at(p, s + 1));
            // What was on the prism's edge k lies on the axis if both ends are one node.
            for k in (0..3).filter(|k| here[*k] != there[*k]) {
                tetrahedra.push(std::array::from_fn(|n| if n <= k { here[n] } else { there[n - 1] }));
            }
        }
    }
    TetMesh::straight(nodes, &tetrahedra)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_square_is_a_prism() {
        let points = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|p| DVec2::new(p.x, p.y - 0.5));
        for sectors in [3, 8] {
            let mesh = turned(&points, &[[0, 1, 2], [0, 2, 3]], sectors).expect("a prism");
            let n = sectors as f64;
            let exact = 0.5 * n * (TAU / n).sin();
            // Residual seen: 2e-16.
            assert!((mesh.quality().volume / exact - 1.0).abs() < 1e-13);
            assert_eq!(mesh.surface().len(), 4 * sectors);
            assert_eq!(mesh.parts(), 1);
        }
        // A ring: no point on the axis.
        let ring = points.map(|p| p + 2.0 * DVec2::X);
        let mesh = turned(&ring, &[[0, 1, 2], [0, 2, 3]], 5).expect("a ring");
        assert_eq!((mesh.surface().len(), mesh.elements.len()), (40, 30));
    }
}
