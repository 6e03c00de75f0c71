//! The parts of a glTF file: its JSON, its buffers, and the numbers in them.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Deserialize;
use serde_json::Value;

use super::super::{Located, MeshFault};
use crate::formats::input_file::read_bounded;

const MAGIC: &[u8; 4] = b"glTF";
const CHUNK_JSON: &[u8; 4] = b"JSON";
const CHUNK_BINARY: &[u8; 4] = b"BIN\0";
/// Numbers that the format gives to the types of components and to triangle lists.
pub(crate) const BYTE: u32 = 5121;
pub(crate) const SIGNED_BYTE: u32 = 5120;
pub(crate) const SIGNED_SHORT: u32 = 5122;
pub(crate) const SHORT: u32 = 5123;
pub(crate) const INT: u32 = 5125;
pub(crate) const FLOAT: u32 = 5126;
pub(crate) const TRIANGLES: u32 = 4;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
pub(crate) struct Document {
    pub(crate) scene: Option<usize>,
    pub(crate) scenes: Vec<Scene>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) accessors: Vec<Accessor>,
    pub(crate) buffer_views: Vec<BufferView>,
    pub(crate) buffers: Vec<Buffer>,
    pub(crate) extensions_used: Vec<String>,
    pub(crate) extensions: Extensions,
    pub(crate) materials: Vec<Named>,
    pub(crate) animations: Vec<Animation>,
}

/// Something of which only the name is used.
#[derive(Deserialize)]
pub(crate) struct Named {
    pub(crate) name: Option<String>,
}

#[derive(Deserialize)]
pub(crate) struct Animation {
    pub(crate) name: Option<String>,
    pub(crate) channels: Vec<Channel>,
    pub(crate) samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
pub(crate) struct Channel {
    pub(crate) sampler: usize,
    pub(crate) target: Target,
}

#[derive(Deserialize)]
pub(crate) struct Target {
    pub(crate) node: Option<usize>,
    pub(crate) path: String,
}

#[derive(Deserialize)]
pub(crate) struct Sampler {
    pub(crate) input: usize,
    pub(crate) output: usize,
    pub(crate) interpolation: Option<String>,
}

/// What extensions add, as far as anything is made of it; what is wrong in it is no fault of the mesh.
#[derive(Deserialize, Default)]
#[serde(default)]
pub(crate) struct Extensions {
    #[serde(rename = "KHR_audio_rigid_bodies")]
    pub(crate) audio: Option<Value>,
    #[serde(rename = "KHR_physics_rigid_bodies")]
    pub(crate) physics: Option<Value>,
    #[serde(rename = "KHR_implicit_shapes")]
    pub(crate) shapes: Option<Value>,
    #[serde(rename = "KHR_node_visibility")]
    pub(crate) visibility: Option<Value>,
}

#[derive(Deserialize)]
pub(crate) struct Scene {
    #[serde(default)]
    pub(crate) nodes: Vec<usize>,
}

#[derive(Deserialize)]
pub(crate) struct Node {
    pub(crate) name: Option<String>,
    #[serde(default)]
    pub(crate) extensions: Extensions,
    /// Whatever a person or another program adds.
    #[serde(default)]
    pub(crate) extras: Value,
    #[serde(default)]
    pub(crate) children: Vec<usize>,
    pub(crate) mesh: Option<usize>,
    pub(crate) matrix: Option<[f64; 16]>,
    pub(crate) translation: Option<[f64; 3]>,
    pub(crate) rotation: Option<[f64; 4]>,
    pub(crate) scale: Option<[f64; 3]>,
    pub(crate) skin: Option<usize>,
    /// Of morph targets, instead of those of the mesh.
    pub(crate) weights: Option<Vec<f64>>,
}

#[derive(Deserialize)]
pub(crate) struct Mesh {
    pub(crate) primitives: Vec<Primitive>,
    /// Of morph targets.
    #[serde(default)]
    pub(crate) weights: Vec<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Primitive {
    pub(crate) attributes: Attributes,
    pub(crate) indices: Option<usize>,
    pub(crate) mode: Option<u32>,
    pub(crate) material: Option<usize>,
    /// Displacements of the vertices.
    #[serde(default)]
    pub(crate) targets: Vec<Attributes>,
    #[serde(default)]
    pub(crate) extensions: std::collections::BTreeMap<String, serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
pub(crate) struct Attributes {
    #[serde(rename = "POSITION")]
    pub(crate) position: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub(crate) buffer_view: Option<usize>,
    #[serde(default)]
    pub(crate) byte_offset: usize,
    pub(crate) component_type: u32,
    pub(crate) count: usize,
    #[serde(default)]
    pub(crate) normalized: bool,
    #[serde(rename = "type")]
    pub(crate) shape: String,
    pub(crate) sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct BufferView {
    pub(crate) buffer: usize,
    #[serde(default)]
    pub(crate) byte_offset: usize,
    pub(crate) byte_length: usize,
    pub(crate) byte_stride: Option<usize>,
}

#[derive(Deserialize)]
pub(crate) struct Buffer {
    pub(crate) uri: Option<String>,
}

/// A glTF file with its buffers.
pub(crate) struct GltfFile {
    pub(crate) document: Document,
    buffers: Vec<Arc<Vec<u8>>>,
    /// Vertices and triangles that meshes may still have, all nodes together.
    left: AtomicUsize,
}

/// Vertices and triangles of all nodes together. Nodes may share a mesh, and primitives an accessor, so
/// that a small file may stand for more than fits into memory.
const MOST_ELEMENTS: usize = 20_000_000;
/// Bytes of all buffers together.
const MOST_BYTES: usize = 1 << 30;

impl GltfFile {
    /// Reads a file; `folder` holds the buffers that it names.
    pub(crate) fn open(bytes: &[u8], folder: &Path) -> Result<Self, Located> {
        let (json, binary) = split(bytes)?;
        let document: Document = serde_json::from_slice(json).map_err(|error| {
            let reason = "the JSON is not that of a glTF 2.0 file; export it again";
            Located::at_line(error.line(), MeshFault::Syntax { reason })
        })?;
        let mut loader = BufferLoader { folder, binary, files: BTreeMap::new(), bytes: 0 };
        let buffers = document
            .buffers
            .iter()
            .enumerate()
            .map(|(i, buffer)| loader.load(buffer, i).map_err(|f| Located::at_element("buffer", i, f)))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(GltfFile { document, buffers, left: AtomicUsize::new(MOST_ELEMENTS) })
    }

    /// Takes vertices or triangles from those that the file may have.
    pub(crate) fn take(&self, elements: usize) -> Result<(), MeshFault> {
        let taken =
            self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(elements));
        taken.map(|_| ()).map_err(|_| MeshFault::Syntax {
            reason: "its nodes have more than 20 million vertices and triangles together; export fewer \
                     copies, or coarser meshes",
        })
    }

    /// The bytes of the elements of an accessor, one after another.
    pub(crate) fn records(&self, accessor: &Accessor) -> Result<impl Iterator<Item = &[u8]>, MeshFault> {
        let syntax = |reason| MeshFault::Syntax { reason };
        if accessor.sparse.is_some() {
            return Err(syntax("sparse accessors are not read; export the file without them"));
        }
        let view = accessor.buffer_view.and_then(|v| self.document.buffer_views.get(v));
        let view = view.ok_or(syntax("an accessor has no buffer view; export without compression"))?;
        let size = component_size(accessor.component_type) * components(&accessor.shape);
        let stride = view.byte_stride.unwrap_or(size);
        let count = accessor.count;
        if stride < size {
            return Err(syntax("the stride of a buffer view is smaller than its elements"));
        }
        let slice = || {
            let buffer = self.buffers.get(view.buffer)?;
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
        Ok(bytes.chunks(stride).map(move |chunk| &chunk[..size]))
    }

    /// The numbers of a vector of 32-bit floats.
    pub(crate) fn floats<const N: usize>(
        &self,
        accessor: &Accessor,
    ) -> Result<impl Iterator<Item = [f64; N]>, MeshFault> {
        let number = |record: &[u8], k: usize| {
            let bytes = record.get(4 * k..).and_then(|b| b.first_chunk());
            bytes.map_or(f64::NAN, |b| f64::from(f32::from_le_bytes(*b)))
        };
        Ok(self.records(accessor)?.map(move |record| std::array::from_fn(|k| number(record, k))))
    }

    /// The numbers of a vector of floats, or of integers that stand for −1 to 1 or 0 to 1.
    pub(crate) fn numbers<const N: usize>(
        &self,
        accessor: &Accessor,
    ) -> Result<impl Iterator<Item = [f64; N]>, MeshFault> {
        let kind = accessor.component_type;
        let is_known =
            kind == FLOAT || accessor.normalized && [SIGNED_BYTE, BYTE, SIGNED_SHORT, SHORT].contains(&kind);
        if !is_known || components(&accessor.shape) != N {
            return Err(MeshFault::Syntax {
                reason: "an animation needs 32-bit floats or normalized integers, three of a translation \
                 or scale and four of a rotation",
            });
        }
        let size = component_size(kind);
        let number = move |record: &[u8], k: usize| {
            let bytes = record.get(size * k..).unwrap_or_default();
            match (kind, bytes) {
                (FLOAT, [a, b, c, d, ..]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
                (SIGNED_BYTE, [a, ..]) => (f64::from(a.cast_signed()) / 127.0).max(-1.0),
                (BYTE, [a, ..]) => f64::from(*a) / 255.0,
                (SIGNED_SHORT, [a, b, ..]) => (f64::from(i16::from_le_bytes([*a, *b])) / 32767.0).max(-1.0),
                (SHORT, [a, b, ..]) => f64::from(u16::from_le_bytes([*a, *b])) / 65535.0,
                _ => f64::NAN,
            }
        };
        Ok(self.records(accessor)?.map(move |record| std::array::from_fn(|k| number(record, k))))
    }

    /// The unsigned integers of an accessor.
    pub(crate) fn integers(&self, accessor: &Accessor) -> Result<impl Iterator<Item = u32>, MeshFault> {
        let size = component_size(accessor.component_type);
        Ok(self.records(accessor)?.map(move |record| {
            let mut word = [0; 4];
            word[..size].copy_from_slice(record);
            u32::from_le_bytes(word)
        }))
    }
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

/// Reads buffers, each file once.
struct BufferLoader<'a> {
    folder: &'a Path,
    binary: &'a [u8],
    files: BTreeMap<PathBuf, Arc<Vec<u8>>>,
    /// Read so far.
    bytes: usize,
}

impl BufferLoader<'_> {
    /// The bytes of a buffer.
    fn load(&mut self, buffer: &Buffer, index: usize) -> Result<Arc<Vec<u8>>, MeshFault> {
        let Some(uri) = &buffer.uri else {
            // Only the first may be the binary chunk.
            return if index == 0 { Ok(Arc::new(self.binary.to_vec())) } else { Err(MeshFault::Truncated) };
        };
        let name = if uri.starts_with("data:") { None } else { Some(relative_path(uri)?) };
        if let Some(known) = name.as_ref().and_then(|name| self.files.get(name)) {
            return Ok(Arc::clone(known));
        }
        let bytes = match &name {
            Some(name) => read_bounded(&self.folder.join(name), MOST_BYTES as u64)
                .map_err(|e| buffer_fault(uri, e.to_string()))?,
            None => inline(uri)?,
        };
        self.bytes = self.bytes.saturating_add(bytes.len());
        if self.bytes > MOST_BYTES {
            return Err(buffer_fault(uri, format!("the buffers have more than {MOST_BYTES} bytes together")));
        }
        let bytes = Arc::new(bytes);
        if let Some(name) = name {
            self.files.insert(name, Arc::clone(&bytes));
        }
        Ok(bytes)
    }
}

fn buffer_fault(uri: &str, reason: String) -> MeshFault {
    MeshFault::Buffer { uri: uri.chars().take(60).collect(), reason }
}

/// The bytes that a URI holds itself.
fn inline(uri: &str) -> Result<Vec<u8>, MeshFault> {
    let (_, text) =
        uri.split_once(";base64,").ok_or_else(|| buffer_fault(uri, "only base64 data are read".into()))?;
    base64(text).ok_or_else(|| buffer_fault(uri, "the base64 data are broken".into()))
}

/// The path of a file in the folder of the mesh: a mesh from a stranger must not reach outside it.
fn relative_path(uri: &str) -> Result<PathBuf, MeshFault> {
    let path = percent_decoded(uri);
    let components = Path::new(&path).components();
    let is_inside = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
    if uri.contains("://") || !components.clone().all(is_inside) {
        return Err(buffer_fault(uri, "only files in the folder of the mesh are read".into()));
    }
    Ok(components.filter(|c| matches!(c, Component::Normal(_))).collect())
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

/// Numbers of an element; those of a matrix are never read.
fn components(shape: &str) -> usize {
    match shape {
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 1,
    }
}

fn component_size(kind: u32) -> usize {
    match kind {
        BYTE | SIGNED_BYTE => 1,
        SHORT | SIGNED_SHORT => 2,
        _ => 4,
    }
}
