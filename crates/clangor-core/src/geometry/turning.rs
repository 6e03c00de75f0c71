//! Surfaces of revolution about y from rings: neighbouring rings are laced together by angle, whatever their
//! counts.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::tri_mesh::TriMesh;

/// Points of equal radius and height at the given angles \[turns\], from 0 up to below 1.
#[derive(Clone, Debug)]
pub struct Ring {
    /// Radius \[m\].
    pub radius: f64,
    /// Height \[m\].
    pub y: f64,
    /// Angles \[turns\].
    pub turns: Vec<f64>,
}

/// Joins rings into a surface, outward to the right of their order; the first and last are points on the
/// axis, or the last is joined to the first.
pub fn lace(rings: &[Ring], closed: bool) -> TriMesh {
    let mut mesh = TriMesh::default();
    let mut start = Vec::new();
    for ring in rings {
        start.push(mesh.vertices.len() as u32);
        let point = DVec2::new(ring.radius, ring.y);
        mesh.vertices.extend(ring.turns.iter().map(|turn| on_ring(point, TAU * turn)));
    }
    let pairs = if closed { rings.len() } else { rings.len() - 1 };
    for below in 0..pairs {
        let above = (below + 1) % rings.len();
        lace_pair(&mut mesh, (&rings[below].turns, start[below]), (&rings[above].turns, start[above]));
    }
    mesh
}

/// A band of triangles between two rings, each with its first vertex; the next triangle advances the ring
/// whose next edge has the smaller middle angle.
pub fn lace_pair(mesh: &mut TriMesh, (low, low_start): (&[f64], u32), (high, high_start): (&[f64], u32)) {
    let at = |turns: &[f64], k: usize| if k < turns.len() { turns[k] } else { turns[k - turns.len()] + 1.0 };
    let vertex = |turns: &[f64], start: u32, k: usize| start + (k % turns.len()) as u32;
    let (mut i, mut k) = (0, 0);
    loop {
        // A pole does not advance.
        let low_done = low.len() == 1 || i == low.len();
        let high_done = high.len() == 1 || k == high.len();
        if low_done && high_done {
            return;
        }
        let low_middle = at(low, i) + if low_done { 9.0 } else { at(low, i + 1) };
        let high_middle = at(high, k) + if high_done { 9.0 } else { at(high, k + 1) };
        let (a, b) = (vertex(low, low_start, i), vertex(high, high_start, k));
        // The slack settles ties alike in every quadrant.
        if low_middle <= high_middle + 1e-12 {
            mesh.triangles.push([a, vertex(low, low_start, i + 1), b]);
            i += 1;
        } else {
            mesh.triangles.push([a, vertex(high, high_start, k + 1), b]);
            k += 1;
        }
    }
}

/// The point (r, y) of a profile, turned by `angle` \[rad\] about y.
pub fn on_ring(p: DVec2, angle: f64) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    DVec3::new(p.x * cos, p.y, -p.x * sin)
}
