//! glTF 2.0, text and binary: the triangles of every mesh in the default scene, through the transforms of its nodes.
//!
//! Read are positions (32-bit floats) and indices of triangle lists, from the binary chunk, data URIs and files beside
//! the `.gltf`. Compressed and sparse geometry is refused; skins, morph targets, materials and animations are ignored.

use std::fs;
use std::path::{Component, Path};

use clangor::geometry::tri_mesh::TriMesh;
use glam::{DMat4, DQuat, DVec3};
use serde::Deserialize;

use super::{Located, MeshFault};

const MAGIC: &[u8; 4] = b"glTF";
const CHUNK_JSON: &[u8; 4] = b"JSON";
const CHUNK_BINARY: &[u8; 4] = b"BIN\0";
/// Numbers that the format gives to the types of components and to triangle lists.
const BYTE: u32 = 5121;
const SHORT: u32 = 5123;
const INT: u32 = 5125;
const FLOAT: u32 = 5126;
const TRIANGLES: u32 = 4;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
struct Document {
    scene: Option<usize>,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<BufferView>,
    buffers: Vec<Buffer>,
}

#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
struct Node {
    #[serde(default)]
    children: Vec<usize>,
    mesh: Option<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    mode: Option<u32>,
}

#[derive(Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    shape: String,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<String>,
}

/// Reads the scene; `folder` holds the buffers that the file names.
pub(crate) fn parse(bytes: &[u8], folder: &Path) -> Result<TriMesh, Located> {
    let (json, binary) = split(bytes)?;
    let document: Document = serde_json::from_slice(json).map_err(|error| {
        let reason = "the JSON is not that of a glTF 2.0 file; export it again";
        Located::at_line(error.line(), MeshFault::Syntax { reason })
    })?;
    let buffers = document
        .buffers
        .iter()
        .enumerate()
        .map(|(i, buffer)| load(buffer, i, binary, folder).map_err(|f| Located::at_element("buffer", i, f)))
        .collect::<Result<Vec<_>, _>>()?;
    let mut mesh = TriMesh::default();
    let mut visited = vec![false; document.nodes.len()];
    let mut pending: Vec<(usize, DMat4)> =
        roots(&document)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((index, parent)) = pending.pop() {
        let node = document.nodes.get(index).ok_or_else(|| missing("node", index))?;
        if std::mem::replace(&mut visited[index], true) {
            let reason = "the nodes form a loop, or share children; export the file again";
            return Err(Located::at_element("node", index, MeshFault::Syntax { reason }));
        }
        let transform = parent * local(node);
        if let Some(index) = node.mesh {
            let source = document.meshes.get(index).ok_or_else(|| missing("mesh", index))?;
            for primitive in &source.primitives {
                append(&document, &buffers, primitive, &transform, &mut mesh)
                    .map_err(|fault| Located::at_element("mesh", index, fault))?;
            }
        }
        pending.extend(node.children.iter().rev().map(|child| (*child, transform)));
    }
    Ok(mesh)
}

fn missing(list: &'static str, index: usize) -> Located {
    Located::at_element(list, index, MeshFault::Syntax { reason: "the file names it, but it does not exist" })
}

/// JSON and binary chunk of a file; the latter is empty for a text file.
fn split(bytes: &[u8]) -> Result<(&[u8], &[u8]), Located> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, &[]));
    }
    let word = |at: usize| {
        let bytes = bytes.get(at..).and_then(|b| b.first_chunk());
        bytes.map(|b| u32::from_le_bytes(*b) as usize).ok_or(Located::at_byte(at, MeshFault::Truncated))
    };
    if word(4)? != 2 {
        return Err(Located::at_byte(4, MeshFault::Syntax { reason: "only version 2 of glTF is read" }));
    }
    let (mut json, mut binary, mut at): (Option<&[u8]>, &[u8], usize) = (None, &[], 12);
    while at < bytes.len() {
        let length = word(at)?;
        let kind = bytes.get(at + 4..at + 8).ok_or(Located::at_byte(at, MeshFault::Truncated))?;
        let end = (at + 8).checked_add(length);
        let content = end.and_then(|end| bytes.get(at + 8..end));
        let content = content.ok_or(Located::at_byte(bytes.len(), MeshFault::Truncated))?;
        if kind == CHUNK_JSON {
            json = Some(content);
        } else if kind == CHUNK_BINARY {
            binary = content;
        }
        at += 8 + length;
    }
    let json = json.ok_or(Located::at_byte(12, MeshFault::Truncated))?;
    Ok((json, binary))
}

/// The bytes of a buffer.
fn load(buffer: &Buffer, index: usize, binary: &[u8], folder: &Path) -> Result<Vec<u8>, MeshFault> {
    let Some(uri) = &buffer.uri else {
        // Only the first may be the binary chunk.
        return if index == 0 { Ok(binary.to_vec()) } else { Err(MeshFault::Truncated) };
    };
    let fault = |reason: String| MeshFault::Buffer { uri: uri.chars().take(60).collect(), reason };
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) =
            data.split_once(";base64,").ok_or_else(|| fault("only base64 data are read".into()))?;
        return base64(text).ok_or_else(|| fault("the base64 data are broken".into()));
    }
    let path = percent_decoded(uri);
    let relative = Path::new(&path);
    // A mesh from a stranger must not reach outside its folder.
    if uri.contains("://")
        || relative.components().any(|c| !matches!(c, Component::Normal(_) | Component::CurDir))
    {
        return Err(fault("only files in the folder of the mesh are read".into()));
    }
    fs::read(folder.join(relative)).map_err(|e| fault(e.to_string()))
}

fn base64(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut word, mut bits) = (0_u32, 0);
    for c in text.trim_end_matches('=').bytes() {
        let six = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        word = (word << 6 | u32::from(six)) & 0xFFFF;
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            out.push((word >> bits) as u8);
        }
    }
    Some(out)
}

/// A URI's path with `%20` and the like resolved; what is no code stays.
fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut out = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let code = uri.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                out.push(byte);
                at += 3;
            }
            None => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
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

/// Adds the triangles of a primitive.
fn append(
    document: &Document,
    buffers: &[Vec<u8>],
    primitive: &Primitive,
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
    for record in records(document, buffers, positions, "VEC3", &[FLOAT])?.1 {
        let coordinate = |k: usize| {
            let bytes = record.get(4 * k..).and_then(|b| b.first_chunk());
            bytes.map_or(f64::NAN, |b| f64::from(f32::from_le_bytes(*b)))
        };
        let vertex = transform.transform_point3(DVec3::new(coordinate(0), coordinate(1), coordinate(2)));
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
            let (kind, records) = records(document, buffers, indices, "SCALAR", &[BYTE, SHORT, INT])?;
            let size = component_size(kind);
            records
                .map(|record| {
                    let mut word = [0; 4];
                    word[..size].copy_from_slice(record);
                    u32::from_le_bytes(word)
                })
                .collect()
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

fn component_size(kind: u32) -> usize {
    match kind {
        BYTE => 1,
        SHORT => 2,
        _ => 4,
    }
}

/// The type of an accessor's components, and the bytes of its elements one after another.
fn records<'a>(
    document: &Document,
    buffers: &'a [Vec<u8>],
    index: usize,
    shape: &str,
    kinds: &[u32],
) -> Result<(u32, impl Iterator<Item = &'a [u8]> + use<'a>), MeshFault> {
    let syntax = |reason| MeshFault::Syntax { reason };
    let accessor =
        document.accessors.get(index).ok_or(syntax("a primitive names an accessor that does not exist"))?;
    if accessor.sparse.is_some() {
        return Err(syntax("sparse accessors are not read; export the mesh without them"));
    }
    if accessor.shape != shape || !kinds.contains(&accessor.component_type) {
        return Err(syntax("positions must be VEC3 of 32-bit floats, indices SCALAR of unsigned integers"));
    }
    let view = accessor.buffer_view.and_then(|v| document.buffer_views.get(v));
    let view = view.ok_or(syntax("an accessor has no buffer view; export without compression"))?;
    let size = component_size(accessor.component_type) * if shape == "VEC3" { 3 } else { 1 };
    let stride = view.byte_stride.unwrap_or(size);
    let count = accessor.count;
    if stride < size {
        return Err(syntax("the stride of a buffer view is smaller than its elements"));
    }
    let slice = || {
        let buffer = buffers.get(view.buffer)?;
        let view_end = view.byte_offset.checked_add(view.byte_length)?;
        let bytes = buffer.get(view.byte_offset..view_end)?.get(accessor.byte_offset..)?;
        let needed = match count {
            0 => 0,
            _ => (count - 1).checked_mul(stride)?.checked_add(size)?,
        };
        bytes.get(..needed)
    };
    let bytes = slice().ok_or(MeshFault::Truncated)?;
    // The last element may be shorter than the stride.
    Ok((accessor.component_type, bytes.chunks(stride).map(move |chunk| &chunk[..size])))
}
