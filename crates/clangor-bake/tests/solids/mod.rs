//! Bodies of the shape library about their centres of mass, and their surfaces as input of the modal solvers.

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::surface::ModalSurface;

/// A named shape about its centre of mass.
pub(crate) fn shape(text: &str) -> TriMesh {
    let mesh = Shape::parse(text).expect("a shape").mesh();
    let centre = MassProperties::of(&mesh).expect("a solid").centre_of_mass;
    mesh.relative_to(centre)
}

/// Its triangles as faces with straight edges.
pub(crate) fn faces(mesh: &TriMesh) -> ModalSurface {
    let mut nodes = mesh.vertices.clone();
    let mut triangles = Vec::new();
    for t in &mesh.triangles {
        let first = nodes.len() as u32;
        for k in 0..3 {
            nodes.push(0.5 * (nodes[t[k] as usize] + nodes[t[(k + 1) % 3] as usize]));
        }
        triangles.push([t[0], t[1], t[2], first, first + 1, first + 2]);
    }
    ModalSurface { nodes, triangles }
}
