//! PLY, text and binary of either byte order: `x y z` of `vertex`, the corner list of `face`.
//!
//! Other elements and properties are skipped, so colours and normals do no harm.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::polygon::push_polygon;
use super::{Located, MeshFault, excerpt};

/// What a PLY file holds for us.
#[derive(Debug, Default)]
pub(crate) struct PlyMesh {
    pub(crate) mesh: TriMesh,
    /// The extra properties that were asked for, each with one value per vertex; empty if the file has none
    /// of this name.
    pub(crate) extra: Vec<Vec<f64>>,
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }
}

struct Property {
    name: String,
    /// Type of the count, if the property is a list.
    count: Option<Scalar>,
    item: Scalar,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// Reads vertices and faces; `extra` names more properties of the vertices.
pub(crate) fn parse(bytes: &[u8], extra: &[&str]) -> Result<PlyMesh, Located> {
    let (encoding, elements, start) = parse_header(bytes)?;
    let mut values = Values { bytes, at: start, encoding };
    let mut ply = PlyMesh { extra: vec![Vec::new(); extra.len()], ..PlyMesh::default() };
    let mut faces: Vec<Vec<f64>> = Vec::new();
    for element in &elements {
        match element.name.as_str() {
            "vertex" => read_vertices(&mut values, element, extra, &mut ply)?,
            "face" => read_faces(&mut values, element, &mut faces)?,
            _ => skip(&mut values, element)?,
        }
    }
    let vertices = ply.mesh.vertices.len();
    for (face, corners) in faces.iter().enumerate() {
        let corners: Result<Vec<u32>, MeshFault> = corners
            .iter()
            .map(|&index| {
                let valid = index >= 0.0 && index < vertices as f64 && index.fract() == 0.0;
                if valid { Ok(index as u32) } else { Err(MeshFault::Index { index: index as i64, vertices }) }
            })
            .collect();
        corners
            .and_then(|c| push_polygon(&mut ply.mesh, &c))
            .map_err(|fault| Located::at_element("face", face, fault))?;
    }
    Ok(ply)
}

fn read_vertices(
    values: &mut Values<'_>,
    element: &Element,
    extra: &[&str],
    ply: &mut PlyMesh,
) -> Result<(), Located> {
    let axis = |name: &str| element.properties.iter().position(|p| p.name == name && p.count.is_none());
    let (Some(x), Some(y), Some(z)) = (axis("x"), axis("y"), axis("z")) else {
        return Err(Located::whole(MeshFault::Syntax {
            reason: "element vertex lacks the properties x, y and z",
        }));
    };
    let extra: Vec<Option<usize>> = extra.iter().map(|name| axis(name)).collect();
    let mut row = vec![0.0; element.properties.len()];
    for index in 0..element.count {
        let located = |fault| Located::at_element("vertex", index, fault);
        for (property, value) in element.properties.iter().zip(&mut row) {
            *value = values.property(property, |_| ()).map_err(located)?;
        }
        let vertex = DVec3::new(row[x], row[y], row[z]);
        if !vertex.is_finite() {
            return Err(located(MeshFault::NotFinite));
        }
        ply.mesh.vertices.push(vertex);
        for (values, place) in ply.extra.iter_mut().zip(&extra) {
            values.extend(place.map(|place| row[place]));
        }
    }
    Ok(())
}

fn read_faces(values: &mut Values<'_>, element: &Element, faces: &mut Vec<Vec<f64>>) -> Result<(), Located> {
    let is_corners =
        |p: &Property| p.count.is_some() && (p.name == "vertex_indices" || p.name == "vertex_index");
    if !element.properties.iter().any(is_corners) {
        let reason = "element face lacks the list vertex_indices";
        return Err(Located::whole(MeshFault::Syntax { reason }));
    }
    for index in 0..element.count {
        let mut corners = Vec::new();
        for property in &element.properties {
            let wanted = is_corners(property);
            let mut take = |value| {
                if wanted {
                    corners.push(value);
                }
            };
            values
                .property(property, &mut take)
                .map_err(|fault| Located::at_element("face", index, fault))?;
        }
        faces.push(corners);
    }
    Ok(())
}

fn skip(values: &mut Values<'_>, element: &Element) -> Result<(), Located> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for index in 0..element.count {
        for property in &element.properties {
            values
                .property(property, |_| ())
                .map_err(|fault| Located::at_element("element of another kind", index, fault))?;
        }
    }
    Ok(())
}

/// Encoding, elements, and where the values start.
fn parse_header(bytes: &[u8]) -> Result<(Encoding, Vec<Element>, usize), Located> {
    let (mut encoding, mut elements, mut at) = (None, Vec::<Element>::new(), 0);
    for line in 1.. {
        let syntax = |reason| Located::at_line(line, MeshFault::Syntax { reason });
        let Some(length) = bytes[at..].iter().position(|b| *b == b'\n') else {
            return Err(syntax("the header has no end_header line"));
        };
        let text = String::from_utf8_lossy(&bytes[at..at + length]);
        at += length + 1;
        let words: Vec<&str> = text.split_whitespace().collect();
        if line == 1 && words != ["ply"] {
            return Err(syntax("a PLY file begins with the line ply"));
        }
        match words.as_slice() {
            ["format", name, ..] => {
                encoding = Some(match *name {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(syntax("the format is none of ascii and binary_*_endian")),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| syntax("an element has no valid count"))?;
                elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
            }
            ["property", kind @ .., name] => {
                let element =
                    elements.last_mut().ok_or_else(|| syntax("a property precedes every element"))?;
                let scalar = |name: &str| {
                    Scalar::from_name(name).ok_or_else(|| syntax("a property's type is unknown"))
                };
                let (count, item) = match kind {
                    [item] => (None, scalar(item)?),
                    ["list", count, item] => (Some(scalar(count)?), scalar(item)?),
                    _ => return Err(syntax("a property is neither scalar nor list")),
                };
                element.properties.push(Property { name: (*name).into(), count, item });
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| syntax("the header has no format line"))?;
                return Ok((encoding, elements, at));
            }
            ["ply"] | ["comment" | "obj_info", ..] | [] => {}
            _ => return Err(syntax("format, element, property, comment or end_header is expected")),
        }
    }
    Err(Located::whole(MeshFault::Truncated))
}

/// Takes one value after another.
struct Values<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl Values<'_> {
    /// A scalar, or the items of a list (handed to `take`) and their number.
    fn property(&mut self, property: &Property, mut take: impl FnMut(f64)) -> Result<f64, MeshFault> {
        let Some(count_type) = property.count else { return self.scalar(property.item) };
        let count = self.scalar(count_type)?;
        if !(count >= 0.0 && count.fract() == 0.0) {
            return Err(MeshFault::Syntax { reason: "the length of a list is no natural number" });
        }
        // A wrong length runs into the end of the file before it costs memory.
        for _ in 0..count as u64 {
            take(self.scalar(property.item)?);
        }
        Ok(count)
    }

    fn scalar(&mut self, kind: Scalar) -> Result<f64, MeshFault> {
        if self.encoding == Encoding::Text {
            return self.word();
        }
        let size = kind.size();
        let bytes = self.bytes.get(self.at..self.at + size).ok_or(MeshFault::Truncated)?;
        self.at += size;
        let mut word = [0; 8];
        word[..size].copy_from_slice(bytes);
        if self.encoding == Encoding::BigEndian {
            word[..size].reverse();
        }
        let [a, b, c, d, ..] = word;
        Ok(match kind {
            Scalar::I8 => f64::from(i8::from_le_bytes([a])),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(word),
        })
    }

    fn word(&mut self) -> Result<f64, MeshFault> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or(MeshFault::Truncated)?;
        let length = rest[start..].iter().position(|b| b.is_ascii_whitespace()).unwrap_or(rest.len() - start);
        let text = String::from_utf8_lossy(&rest[start..start + length]);
        self.at += start + length;
        text.parse().map_err(|_| MeshFault::NotANumber { text: excerpt(&text) })
    }
}

/// A binary PLY file of a mesh whose vertices carry more properties: their names, and their values at each
/// vertex.
pub(crate) fn to_bytes<const N: usize>(
    mesh: &TriMesh,
    names: [&str; N],
    extra: &[[f64; N]],
    comment: &str,
) -> Vec<u8> {
    let properties: String = names.iter().map(|name| format!("property double {name}\n")).collect();
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {comment}\n\
         element vertex {}\nproperty double x\nproperty double y\nproperty double z\n{properties}\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for (vertex, extra) in mesh.vertices.iter().zip(extra) {
        for value in vertex.to_array().iter().chain(extra) {
            out.extend_from_slice(&value.to_le_bytes());
        }
    }
    for triangle in &mesh.triangles {
        out.push(3);
        for corner in triangle {
            out.extend_from_slice(&corner.to_le_bytes());
        }
    }
    out
}
