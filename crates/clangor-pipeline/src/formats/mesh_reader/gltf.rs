//! glTF 2.0, text and binary: the triangles of every mesh in the default scene, through the transforms of its
//! nodes.
//!
//! Read are positions (32-bit floats) and indices of triangle lists, from the binary chunk, data URIs and
//! files beside the `.gltf`, displaced by the morph targets with the weights of the node or of the mesh.
//! Compressed and sparse geometry is refused; skins, materials and animations are ignored.

pub(crate) mod document;

use std::path::Path;

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DMat4, DQuat, DVec3};

use super::{Located, MeshFault};
use document::{Accessor, BYTE, Document, FLOAT, GltfFile, INT, Mesh, Node, Primitive, SHORT, TRIANGLES};

/// Reads the scene; `folder` holds the buffers that the file names.
pub(crate) fn parse(bytes: &[u8], folder: &Path) -> Result<TriMesh, Located> {
    let file = GltfFile::open(bytes, folder)?;
    let mut mesh = TriMesh::default();
    for placed in placed_nodes(&file.document)? {
        append_node(&file, &placed, &mut mesh)?;
    }
    Ok(mesh)
}

/// A node of the default scene.
pub(crate) struct Placed {
    /// Its index.
    pub(crate) node: usize,
    /// Place in the list of the node that it hangs from.
    pub(crate) parent: Option<usize>,
    /// From its frame to that of the scene.
    pub(crate) transform: DMat4,
}

/// The nodes of the default scene, each after its parent.
pub(crate) fn placed_nodes(document: &Document) -> Result<Vec<Placed>, Located> {
    let mut placed = Vec::new();
    let mut visited = vec![false; document.nodes.len()];
    let root = |node| Placed { node, parent: None, transform: DMat4::IDENTITY };
    let mut pending: Vec<Placed> = roots(document)?.into_iter().rev().map(root).collect();
    while let Some(Placed { node: index, parent, transform }) = pending.pop() {
        let node = document.nodes.get(index).ok_or_else(|| missing("node", index))?;
        if std::mem::replace(&mut visited[index], true) {
            let reason = "the nodes form a loop, or share children; export the file again";
            return Err(Located::at_element("node", index, MeshFault::Syntax { reason }));
        }
        let transform = transform * local(node);
        let here = Some(placed.len());
        let child = |node: &usize| Placed { node: *node, parent: here, transform };
        pending.extend(node.children.iter().rev().map(child));
        placed.push(Placed { node: index, parent, transform });
    }
    Ok(placed)
}

/// Adds the triangles of a node's mesh, if it has one, in the frame of the scene.
pub(crate) fn append_node(file: &GltfFile, placed: &Placed, mesh: &mut TriMesh) -> Result<(), Located> {
    let Some(node) = file.document.nodes.get(placed.node) else { return Ok(()) };
    let Some(index) = node.mesh else { return Ok(()) };
    let source = file.document.meshes.get(index).ok_or_else(|| missing("mesh", index))?;
    let weights = morph_weights(node, source);
    for primitive in &source.primitives {
        append(file, (primitive, weights), &placed.transform, mesh)
            .map_err(|fault| Located::at_element("mesh", index, fault))?;
    }
    Ok(())
}

/// Weights of the morph targets of a node with this mesh.
pub(crate) fn morph_weights<'a>(node: &'a Node, mesh: &'a Mesh) -> &'a [f64] {
    node.weights.as_deref().unwrap_or(&mesh.weights)
}

fn missing(list: &'static str, index: usize) -> Located {
    Located::at_element(list, index, MeshFault::Syntax { reason: "the file names it, but it does not exist" })
}

/// The nodes at the top of the default scene; of the first, or of no scene, if none is named.
fn roots(document: &Document) -> Result<Vec<usize>, Located> {
    let scene = match document.scene {
        Some(index) => Some(document.scenes.get(index).ok_or_else(|| missing("scene", index))?),
        None => document.scenes.first(),
    };
    Ok(scene.map_or_else(
        || {
            let children: std::collections::BTreeSet<usize> =
                document.nodes.iter().flat_map(|n| n.children.iter().copied()).collect();
            (0..document.nodes.len()).filter(|n| !children.contains(n)).collect()
        },
        |scene| scene.nodes.clone(),
    ))
}

fn local(node: &Node) -> DMat4 {
    node.matrix.map_or_else(
        || {
            DMat4::from_scale_rotation_translation(
                node.scale.map_or(DVec3::ONE, DVec3::from_array),
                node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array),
                node.translation.map_or(DVec3::ZERO, DVec3::from_array),
            )
        },
        |m| DMat4::from_cols_array(&m),
    )
}

/// Adds the triangles of a primitive, displaced by its morph targets with these weights.
fn append(
    file: &GltfFile,
    (primitive, weights): (&Primitive, &[f64]),
    transform: &DMat4,
    mesh: &mut TriMesh,
) -> Result<(), MeshFault> {
    match primitive.mode.unwrap_or(TRIANGLES) {
        TRIANGLES => {}
        0 => return Err(MeshFault::NotTriangles { what: "points" }),
        1..=3 => return Err(MeshFault::NotTriangles { what: "lines" }),
        _ => return Err(MeshFault::NotTriangles { what: "triangle strips and fans" }),
    }
    let positions = primitive.attributes.position.ok_or(MeshFault::Syntax {
        reason: "a primitive has no positions; export it without Draco or meshopt compression",
    })?;
    let first = mesh.vertices.len();
    let positions = accessor(file, positions, "VEC3", &[FLOAT])?;
    file.take(positions.count)?;
    let mut positions: Vec<DVec3> = file.floats::<3>(positions)?.map(DVec3::from_array).collect();
    for (target, weight) in primitive.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        let Some(displacements) = target.position else { continue };
        let displacements = accessor(file, displacements, "VEC3", &[FLOAT])?;
        if displacements.count != positions.len() {
            let reason = "a morph target has not as many positions as its primitive; export it again";
            return Err(MeshFault::Syntax { reason });
        }
        // Targets may share an accessor, so that a small file may stand for much work.
        file.take(displacements.count)?;
        for (position, displacement) in positions.iter_mut().zip(file.floats::<3>(displacements)?) {
            *position += *weight * DVec3::from_array(displacement);
        }
    }
    for position in positions {
        let vertex = transform.transform_point3(position);
        if !vertex.is_finite() {
            return Err(MeshFault::NotFinite);
        }
        mesh.vertices.push(vertex);
    }
    let vertices = mesh.vertices.len() - first;
    let too_large = MeshFault::TooLarge { vertices: mesh.vertices.len() };
    u32::try_from(mesh.vertices.len()).map_err(|_| too_large)?;
    let offset = first as u32;
    let corners: Vec<u32> = match primitive.indices {
        None => (0..vertices as u32).collect(),
        Some(indices) => {
            let indices = accessor(file, indices, "SCALAR", &[BYTE, SHORT, INT])?;
            file.take(indices.count / 3)?;
            file.integers(indices)?.collect()
        }
    };
    if !corners.len().is_multiple_of(3) {
        return Err(MeshFault::FewCorners { corners: corners.len() % 3 });
    }
    // A mirrored node turns its triangles inside out.
    let mirrored = transform.determinant() < 0.0;
    for triangle in corners.chunks_exact(3) {
        if let Some(bad) = triangle.iter().find(|c| **c as usize >= vertices) {
            return Err(MeshFault::Index { index: i64::from(*bad), vertices });
        }
        let [a, b, c] = [triangle[0] + offset, triangle[1] + offset, triangle[2] + offset];
        mesh.triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
    }
    Ok(())
}

/// An accessor of this shape and of one of these types of components.
fn accessor<'a>(
    file: &'a GltfFile,
    index: usize,
    shape: &str,
    kinds: &[u32],
) -> Result<&'a Accessor, MeshFault> {
    let syntax = |reason| MeshFault::Syntax { reason };
    let accessor = file.document.accessors.get(index);
    let accessor = accessor.ok_or(syntax("a primitive names an accessor that does not exist"))?;
    if accessor.shape != shape || !kinds.contains(&accessor.component_type) {
        return Err(syntax(
            "positions must be VEC3 of 32-bit floats, indices SCALAR of unsigned integers; export it without \
             quantization (KHR_mesh_quantization)",
        ));
    }
    Ok(accessor)
}
