//! Holes that go through a body, and how far apart they lie.
//!
//! ```text
//! 2 s − 2 h = V − E + F        s surfaces with h holes in all, of V vertices, E = 3F/2 edges, F faces
//! d = √(A/2h)                  spacing of the holes in a wall of area A/2
//! ```
//!
//! A perforated plate bends as a net of bars. A cell with several holes has polynomials for what is a net,
//! and the next order changes little of it: both are too stiff, and their difference says nothing.
//!
//! What it is not: a place. Holes that lie together in a part of a body are nearer to each other than d.

use std::collections::BTreeSet;

use clangor_core::geometry::topology::Topology;
use clangor_core::geometry::tri_mesh::TriMesh;

/// Fewest holes that are a net.
const FEWEST: usize = 2;

/// Spacing \[m\] of the holes of a closed surface; `None` if there is one at most.
pub(super) fn hole_spacing(surface: &TriMesh) -> Option<f64> {
    let (surfaces, _) = Topology::try_new(surface).ok()?.components();
    let vertices: BTreeSet<u32> = surface.triangles.iter().flatten().copied().collect();
    // V − E + F = V − F/2.
    let twice = (2 * surfaces + surface.triangles.len() / 2).checked_sub(vertices.len())?;
    let holes = twice / 2;
    (holes >= FEWEST).then(|| (0.5 * surface.area() / holes as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use clangor_core::shape::Shape;

    use super::*;

    #[test]
    fn solids_and_rings_have_no_spacing_and_three_rings_in_one_have() {
        for form in ["box:0.1x0.1x0.002", "torus:0.1x0.01", "mug"] {
            assert_eq!(hole_spacing(&Shape::parse(form).expect("a form").mesh()), None, "{form}");
        }
        // Three tori beside each other, joined by swapping two triangles of each for the faces of a prism.
        let torus = Shape::parse("torus:0.1x0.01").expect("a form").mesh();
        let count = torus.vertices.len() as u32;
        let mut joined = TriMesh::default();
        for k in 0..3_u32 {
            joined.vertices.extend(&torus.vertices);
            joined.triangles.extend(torus.triangles.iter().map(|t| t.map(|v| v + k * count)));
        }
        let last = |mesh: &TriMesh, k: usize| mesh.triangles[k * torus.triangles.len()];
        let far = torus.triangles.len() / 2;
        let bridges: Vec<[[u32; 3]; 2]> = (0..2)
            .map(|k| [joined.triangles[k * torus.triangles.len() + far], last(&joined, k + 1)])
            .collect();
        joined.triangles.retain(|t| !bridges.iter().flatten().any(|other| other == t));
        for [[a, b, c], [d, e, f]] in bridges {
            // The second face is seen from the other side.
            for (p, q, r, s) in [(a, b, d, f), (b, c, f, e), (c, a, e, d)] {
                joined.triangles.extend([[p, q, r], [q, s, r]]);
            }
        }
        let spacing = hole_spacing(&joined).expect("three holes");
        assert!((spacing - (joined.area() / 6.0).sqrt()).abs() < 1e-12);
    }
}
