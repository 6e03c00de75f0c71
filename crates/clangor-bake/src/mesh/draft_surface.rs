//! A surface on few vertices for drafts of fields.
//!
//! ```text
//! input ─► long sides divided ─► decimated, ever coarser ─► so many vertices ─► faces moved outwards
//! ```
//!
//! Walls that are thinner than the edges of its triangles survive, because vertices stay where they are and
//! no triangle turns over; [`remesh`](super::remesh) would need edges as short as the wall. The work grows
//! with the triangles of the input. Triangles are uneven, and rounded edges become facets. The volume that
//! facets lose comes back as an offset of all faces, so that a wire becomes thicker and its ring no wider.

use std::f64::consts::TAU;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::refine::refine_to_edge;
use clangor_core::geometry::solid::MeshError;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::BVec3;

use super::decimate::decimate;
use super::remesh::volume_fit::{Freedom, offset_to_volume};

/// Longest side in those of equilateral triangles.
const LONGEST: f64 = 1.5;
/// Distance from the planes of the input, in the mean wall and in such sides, and its factor after an attempt
/// that leaves too many vertices.
const FROM_WALL: f64 = 0.1;
const FROM_EDGE: f64 = 0.1;
const COARSER: f64 = 2.0;
const ATTEMPTS: usize = 5;
/// Vertices in those asked for that are not too many.
const MANY: f64 = 1.15;
/// Edges to the shortest wave of a field.
const EDGES_PER_WAVE: f64 = 2.0;
/// Largest share of the volume that an offset makes good. Seen: 0.31 of a wire of 60 × 1 mm.
const VOLUME: f64 = 0.6;

/// A closed surface on about so many vertices, with the volume of the input.
///
/// # Errors
/// [`MeshError`] of an input that bounds no solid.
pub(crate) fn draft_surface(surface: &TriMesh, vertices: f64) -> Result<TriMesh, MeshError> {
    let mass = MassProperties::of(surface)?;
    let area = surface.area();
    let edge = edge_of(area, vertices);
    let mut tolerance = (FROM_WALL * 2.0 * mass.volume / area).min(FROM_EDGE * edge);
    let mut longest = LONGEST * edge;
    let mut coarse = refine_to_edge(surface, longest);
    for _ in 0..ATTEMPTS {
        coarse = decimate(&coarse, longest, tolerance);
        if (coarse.vertices.len() as f64) < MANY * vertices {
            break;
        }
        tolerance *= COARSER;
        longest *= COARSER.sqrt();
    }
    let left = MassProperties::of(&coarse)?;
    if (left.volume / mass.volume - 1.0).abs() > VOLUME {
        return Ok(coarse);
    }
    // The volume, then the centre of mass, which the result has exactly.
    let freedom = vec![Freedom { axes: BVec3::TRUE, sharp: true }; coarse.vertices.len()];
    offset_to_volume(&mut coarse, &freedom, mass.volume);
    let shift = mass.centre_of_mass - MassProperties::of(&coarse)?.centre_of_mass;
    coarse.vertices.iter_mut().for_each(|x| *x += shift);
    Ok(coarse)
}

/// Side of equilateral triangles \[m\], two for each vertex, that cover an area \[m²\].
fn edge_of(area: f64, vertices: f64) -> f64 {
    (2.0 / 3.0_f64.sqrt() * area / vertices).sqrt()
}

/// The highest wavenumber [1/m] that fields on such a surface have.
pub(crate) fn resolved_wavenumber(surface: &TriMesh) -> f64 {
    TAU / (EDGES_PER_WAVE * edge_of(surface.area(), surface.vertices.len().max(1) as f64))
}

#[cfg(test)]
mod tests {
    use clangor_core::geometry::topology::Topology;
    use clangor_core::shape::Shape;

    use super::*;

    #[test]
    fn bodies_of_all_walls_keep_volume_and_topology_on_few_vertices() {
        for shape in ["mug", "key", "box:0.4x0.004x0.4", "torus:0.03x0.0005@0.0005", "rock:3x0.02@0.0005"] {
            let fine = Shape::parse(shape).expect("a shape").mesh();
            let coarse = draft_surface(&fine, 420.0).expect("a solid");
            Topology::try_new(&coarse).expect("closed");
            let euler = |mesh: &TriMesh| mesh.vertices.len() as i64 - mesh.triangles.len() as i64 / 2;
            let ratio = MassProperties::of(&coarse).expect("a solid").volume
                / MassProperties::of(&fine).expect("a solid").volume;
            let left = coarse.vertices.len();
            // The volume is made exact; a torus keeps more vertices than are asked for.
            assert!((ratio - 1.0).abs() < 1e-9, "{shape}: {ratio}");
            assert!(left < 700 && euler(&coarse) == euler(&fine), "{shape}: {left}");
        }
    }
}
