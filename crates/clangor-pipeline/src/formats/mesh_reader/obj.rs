//! Wavefront OBJ: `v` and `f` lines; everything else (normals, groups, materials, lines, points) is skipped.

use clangor_core::geometry::tri_mesh::TriMesh;

use super::polygon::push_polygon;
use super::{Located, MeshFault, excerpt, numbered_lines, point};

/// Reads the faces of all objects in the text as one mesh.
pub(crate) fn parse(bytes: &[u8]) -> Result<TriMesh, Located> {
    let mut mesh = TriMesh::default();
    // A face may name vertices that follow it, so indices are checked at the end.
    let mut faces: Vec<(usize, Vec<i64>)> = Vec::new();
    let mut continued = String::new();
    let mut start = None;
    for (number, line) in numbered_lines(bytes) {
        let line = line.trim_end();
        let first = *start.get_or_insert(number);
        if let Some(head) = line.strip_suffix('\\') {
            continued.push_str(head);
            continued.push(' ');
            continue;
        }
        continued.push_str(line);
        parse_line(&continued, first, &mut mesh, &mut faces)
            .map_err(|fault| Located::at_line(first, fault))?;
        continued.clear();
        start = None;
    }
    let vertices = mesh.vertices.len();
    for (line, corners) in faces {
        let corners: Result<Vec<u32>, MeshFault> = corners
            .into_iter()
            .map(|index| match usize::try_from(index - 1) {
                Ok(i) if i < vertices => u32::try_from(i).map_err(|_| MeshFault::TooLarge { vertices }),
                _ => Err(MeshFault::Index { index, vertices }),
            })
            .collect();
        corners.and_then(|c| push_polygon(&mut mesh, &c)).map_err(|fault| Located::at_line(line, fault))?;
    }
    Ok(mesh)
}

fn parse_line(
    line: &str,
    number: usize,
    mesh: &mut TriMesh,
    faces: &mut Vec<(usize, Vec<i64>)>,
) -> Result<(), MeshFault> {
    let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
    match words.next() {
        Some("v") => mesh.vertices.push(point(words)?),
        Some("f") => {
            let vertices = mesh.vertices.len();
            let corners = words.map(|word| corner(word, vertices)).collect::<Result<_, _>>()?;
            faces.push((number, corners));
        }
        _ => {}
    }
    Ok(())
}

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, from 1; negative ones count back from the last
/// vertex.
fn corner(word: &str, vertices: usize) -> Result<i64, MeshFault> {
    let text = word.split('/').next().unwrap_or_default();
    let index: i64 = text.parse().map_err(|_| MeshFault::NotANumber { text: excerpt(word) })?;
    let count = i64::try_from(vertices).map_err(|_| MeshFault::TooLarge { vertices })?;
    let from_one = if index < 0 { count.checked_add(index).map(|i| i + 1) } else { Some(index) };
    match from_one {
        Some(i) if i >= 1 => Ok(i),
        _ => Err(MeshFault::Index { index, vertices }),
    }
}
