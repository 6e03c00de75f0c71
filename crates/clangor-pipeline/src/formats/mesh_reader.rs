//! Triangle surfaces from OBJ, PLY, STL and glTF files.
//!
//! Polygons are cut into triangles, the objects of a file become one mesh, and the transforms of glTF
//! nodes are applied. Coordinates are taken as the file has them: scale and axes are the scene's business,
//! and so is whether the surface is closed. Materials, normals, colours and textures are ignored.
//!
//! The readers are our own because their messages name the line or byte, and because the general crates for
//! these formats either have no place in their errors or panic on damaged input.

pub(crate) mod gltf;
pub(crate) mod obj;
pub(crate) mod ply;
mod polygon;
pub(crate) mod stl;

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use crate::formats::input_file::read_bounded;

/// Why a mesh file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// The operating system refused.
    #[error("cannot read mesh {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The extension names no format that is read.
    #[error(
        "cannot tell the format of mesh {path} from its extension; .obj, .ply, .stl, .gltf and .glb are read"
    )]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// The content is wrong.
    #[error("mesh {path}, {place}: {fault}")]
    Content {
        /// The file.
        path: PathBuf,
        /// Where in the file.
        place: MeshPlace,
        /// What is wrong there.
        fault: MeshFault,
    },
}

/// A place in a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MeshPlace {
    /// A line, from 1.
    Line(usize),
    /// A byte, from 0.
    Byte(usize),
    /// An element of a list, from 0.
    Element(&'static str, usize),
    /// The file as a whole.
    Whole,
}

impl fmt::Display for MeshPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MeshPlace::Line(line) => write!(f, "line {line}"),
            MeshPlace::Byte(byte) => write!(f, "byte {byte}"),
            MeshPlace::Element(list, index) => write!(f, "{list} {index}"),
            MeshPlace::Whole => write!(f, "whole file"),
        }
    }
}

/// What is wrong with the content of a mesh file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// Nothing in it, or no triangle.
    #[error("there are no triangles; export a surface, not only points or lines")]
    Empty,
    /// The file ends too early.
    #[error("the file is truncated; copy or export it again")]
    Truncated,
    /// A number that is none.
    #[error("\"{text}\" is no number")]
    NotANumber {
        /// The text in its place.
        text: String,
    },
    /// A coordinate is NaN, infinite, or missing.
    #[error("a coordinate is not finite; repair the mesh and export it again")]
    NotFinite,
    /// A corner that does not exist.
    #[error("a face names vertex {index}, but there are {vertices}")]
    Index {
        /// The index as the file writes it.
        index: i64,
        /// Vertices there are.
        vertices: usize,
    },
    /// A face of fewer than three corners.
    #[error("a face has {corners} corners; it needs at least 3")]
    FewCorners {
        /// Corners it has.
        corners: usize,
    },
    /// Lines, points or strips where triangles are needed.
    #[error("{what} cannot be read; export plain triangles")]
    NotTriangles {
        /// What is there.
        what: &'static str,
    },
    /// More vertices than 32-bit indices reach.
    #[error("{vertices} vertices are more than the 4 294 967 295 that can be indexed; simplify the mesh")]
    TooLarge {
        /// Vertices there are.
        vertices: usize,
    },
    /// The syntax of the format is broken.
    #[error("{reason}")]
    Syntax {
        /// What was expected.
        reason: &'static str,
    },
    /// A file that this one refers to cannot be read.
    #[error("buffer {uri} cannot be read: {reason}")]
    Buffer {
        /// The reference.
        uri: String,
        /// Why.
        reason: String,
    },
}

/// A fault and its place, before the file's name is known.
#[derive(Debug)]
pub(crate) struct Located {
    pub(crate) place: MeshPlace,
    pub(crate) fault: MeshFault,
}

impl Located {
    pub(crate) fn at_line(line: usize, fault: MeshFault) -> Self {
        Located { place: MeshPlace::Line(line), fault }
    }

    pub(crate) fn at_byte(byte: usize, fault: MeshFault) -> Self {
        Located { place: MeshPlace::Byte(byte), fault }
    }

    pub(crate) fn at_element(list: &'static str, index: usize, fault: MeshFault) -> Self {
        Located { place: MeshPlace::Element(list, index), fault }
    }

    pub(crate) fn whole(fault: MeshFault) -> Self {
        Located { place: MeshPlace::Whole, fault }
    }

    pub(crate) fn in_file(self, path: &Path) -> MeshFileError {
        MeshFileError::Content { path: path.into(), place: self.place, fault: self.fault }
    }
}

/// Largest file of a mesh or of glTF \[bytes\].
pub(crate) const MOST_BYTES: u64 = 1 << 30;

/// Reads the mesh in a file; the extension tells the format.
///
/// # Errors
/// [`MeshFileError`] names the file, the place and what to do.
pub fn read_mesh(path: &Path) -> Result<TriMesh, MeshFileError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    if !["obj", "ply", "stl", "gltf", "glb"].contains(&extension.as_str()) {
        return Err(MeshFileError::Extension { path: path.into() });
    }
    let bytes =
        read_bounded(path, MOST_BYTES).map_err(|source| MeshFileError::Io { path: path.into(), source })?;
    let mesh = match extension.as_str() {
        "obj" => obj::parse(&bytes),
        "ply" => ply::parse(&bytes, &[]).map(|ply| ply.mesh),
        "stl" => stl::parse(&bytes),
        _ => gltf::parse(&bytes, path.parent().unwrap_or(Path::new("."))),
    };
    let mesh = mesh.map_err(|located| located.in_file(path))?;
    let whole = |fault| Located::whole(fault).in_file(path);
    if mesh.triangles.is_empty() {
        return Err(whole(MeshFault::Empty));
    }
    if u32::try_from(mesh.vertices.len()).is_err() {
        return Err(whole(MeshFault::TooLarge { vertices: mesh.vertices.len() }));
    }
    Ok(mesh)
}

/// A finite number in a text.
fn number(text: &str) -> Result<f64, MeshFault> {
    let value: f64 = text.parse().map_err(|_| MeshFault::NotANumber { text: excerpt(text) })?;
    if value.is_finite() { Ok(value) } else { Err(MeshFault::NotFinite) }
}

/// Three finite coordinates.
fn point<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, MeshFault> {
    let mut next =
        || number(words.next().ok_or(MeshFault::Syntax { reason: "three coordinates are expected" })?);
    Ok(DVec3::new(next()?, next()?, next()?))
}

/// As much of a text as fits a message.
fn excerpt(text: &str) -> String {
    text.chars().take(40).collect()
}

/// The lines of a text with their numbers; bytes that are not UTF-8 can only be in comments and names.
fn numbered_lines(bytes: &[u8]) -> impl Iterator<Item = (usize, std::borrow::Cow<'_, str>)> {
    bytes.split(|b| *b == b'\n').enumerate().map(|(i, line)| (i + 1, String::from_utf8_lossy(line)))
}
