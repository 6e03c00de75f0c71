//! The binary part of a GLB file, and the tables that say what lies where in it.

use std::path::Path;

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;
use serde_json::{Value, json};

use super::GlbError;

/// Types of components and uses of buffers, as the format numbers them.
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const VERTICES: u32 = 34_962;
const INDICES: u32 = 34_963;

/// The binary part and its tables of content.
#[derive(Default)]
pub(crate) struct Container {
    pub(crate) bytes: Vec<u8>,
    pub(crate) views: Vec<Value>,
    pub(crate) accessors: Vec<Value>,
}

impl Container {
    /// A mesh of one primitive; `material` is an index into the materials of the file.
    pub(crate) fn mesh(&mut self, name: &str, mesh: &TriMesh, material: Option<usize>) -> Value {
        let positions = self.positions(&mesh.vertices, Some(VERTICES));
        let indices = self.indices(mesh.triangles.iter().flatten().copied(), Some(INDICES));
        let mut primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
        if let Some(material) = material {
            primitive["material"] = json!(material);
        }
        json!({ "name": name, "primitives": [primitive] })
    }

    /// Points, with the box around them.
    pub(crate) fn positions(&mut self, points: &[DVec3], target: Option<u32>) -> usize {
        let start = self.bytes.len();
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for vertex in points {
            for (axis, x) in vertex.to_array().into_iter().enumerate() {
                let x = x as f32;
                low[axis] = low[axis].min(x);
                high[axis] = high[axis].max(x);
                self.bytes.extend_from_slice(&x.to_le_bytes());
            }
        }
        let accessor = self.accessor(start, FLOAT, points.len(), "VEC3", target);
        self.accessors[accessor]["min"] = json!(low);
        self.accessors[accessor]["max"] = json!(high);
        accessor
    }

    /// Numbers of nodes or vertices.
    pub(crate) fn indices(&mut self, numbers: impl Iterator<Item = u32>, target: Option<u32>) -> usize {
        let start = self.bytes.len();
        let mut count = 0;
        for number in numbers {
            self.bytes.extend_from_slice(&number.to_le_bytes());
            count += 1;
        }
        self.accessor(start, UNSIGNED_INT, count, "SCALAR", target)
    }

    /// Numbers of a shape `SCALAR`, `VEC3` or `VEC4`; of bounded ones, which ascend, the first and the last
    /// are told.
    pub(crate) fn floats(&mut self, values: &[f32], shape: &str, bounded: bool) -> usize {
        let start = self.bytes.len();
        for value in values {
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
        let width = match shape {
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 1,
        };
        let accessor = self.accessor(start, FLOAT, values.len() / width, shape, None);
        if bounded {
            self.accessors[accessor]["min"] = json!([values.first()]);
            self.accessors[accessor]["max"] = json!([values.last()]);
        }
        accessor
    }

    /// A view of the bytes from `start` on, and an accessor of all of it.
    fn accessor(
        &mut self,
        start: usize,
        component: u32,
        count: usize,
        shape: &str,
        target: Option<u32>,
    ) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.accessors.push(json!({
            "bufferView": self.views.len(), "componentType": component, "count": count, "type": shape,
        }));
        self.views.push(view);
        self.accessors.len() - 1
    }
}

/// Header, JSON chunk and binary chunk, each padded to 4 bytes.
pub(crate) fn container_bytes(path: &Path, document: &Value, binary: Vec<u8>) -> Result<Vec<u8>, GlbError> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let binary_chunk = if binary.is_empty() { 0 } else { 8 + binary.len() };
    let total = 12 + 8 + json.len() + binary_chunk;
    let length = |n: usize| {
        u32::try_from(n).map_err(|_| GlbError::TooLarge { path: path.into(), bytes: total as u64 })
    };
    let mut out = b"glTF".to_vec();
    out.extend_from_slice(&2_u32.to_le_bytes());
    out.extend_from_slice(&length(total)?.to_le_bytes());
    out.extend_from_slice(&length(json.len())?.to_le_bytes());
    out.extend_from_slice(b"JSON");
    out.append(&mut json);
    if !binary.is_empty() {
        out.extend_from_slice(&length(binary.len())?.to_le_bytes());
        out.extend_from_slice(b"BIN\0");
        out.extend_from_slice(&binary);
    }
    Ok(out)
}
