//! What the air around a body touches: its outer surface.
//!
//! Outside, the field of a motion is that of the normal acceleration of the outer surface alone. Air that a
//! cavity encloses never comes out. A solver that took the walls of the cavity too would meet its resonances,
//! which nothing damps, with many more unknowns. Masses and modes are still those of the hollow body.
//!
//! Not here: the stiffness of enclosed air, which raises modes of very thin walls.

use std::borrow::Cow;

use clangor_core::geometry::components::outer_triangles;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::surface::ModalSurface;

use super::bake_geometry::BakeGeometry;

impl BakeGeometry {
    /// The geometry of the outer surface, about the centre of mass of the body: itself unless it has closed
    /// cavities.
    pub fn outside(&self) -> Cow<'_, BakeGeometry> {
        let BakeGeometry::Mesh(mesh) = self else { return Cow::Borrowed(self) };
        match outer_triangles(mesh) {
            Some(outer) => Cow::Owned(BakeGeometry::of_mesh(&part(mesh, &outer))),
            None => Cow::Borrowed(self),
        }
    }

    /// Whether it has closed cavities.
    pub fn encloses_air(&self) -> bool {
        matches!(self, BakeGeometry::Mesh(mesh) if outer_triangles(mesh).is_some())
    }
}

/// Some triangles of a mesh, with the vertices that they use.
fn part(mesh: &TriMesh, kept: &[bool]) -> TriMesh {
    let mut number = vec![u32::MAX; mesh.vertices.len()];
    let mut part = TriMesh::default();
    for (triangle, _) in mesh.triangles.iter().zip(kept).filter(|(_, kept)| **kept) {
        part.triangles.push(triangle.map(|n| {
            let own = &mut number[n as usize];
            if *own == u32::MAX {
                *own = part.vertices.len() as u32;
                part.vertices.push(mesh.vertices[n as usize]);
            }
            *own
        }));
    }
    part
}

/// The triangles between the six nodes of those of a surface, without nodes that none uses: mirror planes
/// would have to mirror these too.
pub(crate) fn used_quarters(surface: &ModalSurface) -> TriMesh {
    let quarters = surface.quarters();
    let used = part(&quarters, &vec![true; quarters.triangles.len()]);
    // The order of the nodes stays where all are used.
    if used.vertices.len() < quarters.vertices.len() { used } else { quarters }
}

/// The outer surface of a vibrating body, on the same nodes; all of it if it is not closed.
pub(crate) fn outer_surface(surface: &ModalSurface) -> Cow<'_, ModalSurface> {
    let corners = surface.triangles.iter().map(|[a, b, c, ..]| [*a, *b, *c]).collect();
    let mesh = TriMesh { vertices: surface.nodes.clone(), triangles: corners };
    let Some(outer) = outer_triangles(&mesh) else { return Cow::Borrowed(surface) };
    let kept = surface.triangles.iter().zip(&outer).filter(|(_, outer)| **outer).map(|(t, _)| *t);
    Cow::Owned(ModalSurface { nodes: surface.nodes.clone(), triangles: kept.collect() })
}
