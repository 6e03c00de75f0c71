//! STL, binary and text. Corners with the same bits become one vertex: the format repeats them in every
//! facet.

use std::collections::HashMap;

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;

use super::{Located, MeshFault, numbered_lines, point};

const HEADER: usize = 84;
const FACET: usize = 50;

/// Reads the facets of all solids as one mesh.
pub(crate) fn parse(bytes: &[u8]) -> Result<TriMesh, Located> {
    // Some binary files begin with "solid" too: the length decides first.
    let facets = bytes.get(80..HEADER).and_then(|b| b.first_chunk()).map(|b| u32::from_le_bytes(*b) as usize);
    let is_binary = facets.is_some_and(|n| n.checked_mul(FACET).is_some_and(|b| bytes.len() == HEADER + b));
    if is_binary || !looks_like_text(bytes) {
        parse_binary(bytes, facets.unwrap_or(0))
    } else {
        parse_text(bytes)
    }
}

fn looks_like_text(bytes: &[u8]) -> bool {
    let start = bytes.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(bytes.len());
    let head = &bytes[start..bytes.len().min(start + 512)];
    head.get(..5).is_some_and(|h| h.eq_ignore_ascii_case(b"solid")) && !head.contains(&0)
}

fn parse_binary(bytes: &[u8], facets: usize) -> Result<TriMesh, Located> {
    if bytes.len() < HEADER {
        return Err(Located::at_byte(bytes.len(), MeshFault::Truncated));
    }
    let mut welded = Welder::default();
    for facet in 0..facets {
        let at = HEADER + facet * FACET;
        let Some(record) = bytes.get(at..at + FACET) else {
            return Err(Located::at_element("facet", facet, MeshFault::Truncated));
        };
        let coordinate = |i: usize| {
            let [a, b, c, d] = [12, 13, 14, 15].map(|k| record[4 * i + k]);
            f64::from(f32::from_le_bytes([a, b, c, d]))
        };
        let corners = [0, 3, 6].map(|i| DVec3::new(coordinate(i), coordinate(i + 1), coordinate(i + 2)));
        if !corners.iter().all(|c| c.is_finite()) {
            return Err(Located::at_element("facet", facet, MeshFault::NotFinite));
        }
        welded.push(corners);
    }
    Ok(welded.mesh)
}

fn parse_text(bytes: &[u8]) -> Result<TriMesh, Located> {
    let mut welded = Welder::default();
    let mut corners = Vec::new();
    let mut depth = 0;
    let mut last = 1;
    for (line, text) in numbered_lines(bytes) {
        last = line;
        let mut words = text.split_whitespace();
        let Some(keyword) = words.next() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "solid" => depth += 1,
            "endsolid" => depth -= 1,
            "vertex" => corners.push(point(words).map_err(|fault| Located::at_line(line, fault))?),
            "endloop" => {
                let Ok(facet) = <[DVec3; 3]>::try_from(corners.as_slice()) else {
                    let reason = "a facet needs exactly 3 vertices";
                    return Err(Located::at_line(line, MeshFault::Syntax { reason }));
                };
                welded.push(facet);
                corners.clear();
            }
            "facet" | "outer" | "endfacet" => {}
            _ => {
                let reason = "solid, facet, outer loop, vertex, endloop, endfacet or endsolid is expected";
                return Err(Located::at_line(line, MeshFault::Syntax { reason }));
            }
        }
    }
    if depth > 0 || !corners.is_empty() {
        return Err(Located::at_line(last, MeshFault::Truncated));
    }
    Ok(welded.mesh)
}

/// Gives corners with equal coordinates one vertex.
#[derive(Default)]
struct Welder {
    mesh: TriMesh,
    /// Only looked up, never walked: its order is of no consequence.
    known: HashMap<[u64; 3], u32>,
}

impl Welder {
    fn push(&mut self, corners: [DVec3; 3]) {
        let triangle = corners.map(|corner| {
            // Adding zero turns −0 into +0.
            let key = (corner + DVec3::ZERO).to_array().map(f64::to_bits);
            *self.known.entry(key).or_insert_with(|| {
                self.mesh.vertices.push(corner);
                // At most three vertices for each of less than 2³² facets of 50 bytes: a file of 70 GB.
                (self.mesh.vertices.len() - 1) as u32
            })
        });
        self.mesh.triangles.push(triangle);
    }
}
