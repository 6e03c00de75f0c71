//! A triangle mesh as two arrays of a file.

use glam::DVec3;

use crate::geometry::tri_mesh::TriMesh;
use crate::sound_model::files::tensor_file::{TensorFileError, TensorReader, TensorWriter};

/// How far outside the bounding sphere a vertex may be.
const OUTSIDE: f64 = 1.1;

/// Adds a triangle mesh to a file: arrays NAME.vertices \[m\] or \[R\], and NAME.triangles.
pub(crate) fn put_mesh(file: &mut TensorWriter, name: &str, mesh: &TriMesh) {
    file.add(
        &format!("{name}.vertices"),
        &[mesh.vertices.len(), 3],
        mesh.vertices.iter().flat_map(|v| v.to_array()),
    );
    file.add(
        &format!("{name}.triangles"),
        &[mesh.triangles.len(), 3],
        mesh.triangles.iter().flatten().copied(),
    );
}

/// Reads a triangle mesh; `None` where the file has neither of its arrays.
pub(crate) fn take_mesh(file: &TensorReader<'_>, name: &str) -> Result<Option<TriMesh>, TensorFileError> {
    let (vertices, triangles) = (format!("{name}.vertices"), format!("{name}.triangles"));
    if !file.has(&vertices) && !file.has(&triangles) {
        return Ok(None);
    }
    let (_, positions) = file.rows::<f64>(&vertices, &[3])?;
    let (_, corners) = file.rows::<u32>(&triangles, &[3])?;
    Ok(Some(TriMesh {
        vertices: positions.chunks_exact(3).map(DVec3::from_slice).collect(),
        triangles: corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }))
}

/// Rejects a mesh that names vertices that are not there, or that leaves the ball of this radius.
pub(crate) fn check_mesh(name: &str, mesh: &TriMesh, radius: f64) -> Result<(), TensorFileError> {
    let count = mesh.vertices.len();
    if mesh.triangles.is_empty() {
        return Err(TensorFileError::value(format!("the array \"{name}.triangles\""), "is empty"));
    }
    if let Some(at) = mesh.triangles.iter().position(|t| t.iter().any(|i| *i as usize >= count)) {
        return Err(TensorFileError::value(
            format!("row {at} of the array \"{name}.triangles\""),
            format!("names a vertex that is not among the {count}"),
        ));
    }
    // A remeshed or curved surface and the one that gave the radius are not quite the same.
    if let Some(at) = mesh.vertices.iter().position(|v| !v.is_finite() || v.length() > OUTSIDE * radius) {
        return Err(TensorFileError::value(
            format!("row {at} of the array \"{name}.vertices\""),
            "is outside the bounding sphere",
        ));
    }
    Ok(())
}
