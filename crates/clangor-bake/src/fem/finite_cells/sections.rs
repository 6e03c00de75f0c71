//! How much of their sections with a common face two parts of neighbouring cells share.

use glam::DVec3;

use super::chain::{Cap, Chain, Origin};
use super::division::Division;
use super::parts::{Cell, face_area};

/// Least overlap, in the smaller of two sections.
pub(super) const OVERLAP: f64 = 0.1;
/// Rounding of a section, in the area of a face.
pub(super) const ROUNDING: f64 = 1e-12;

/// The section with a face, in the coordinates of the neighbour across it.
pub(super) fn moved_section(sections: &[Cap], face: u8, to: impl Fn(DVec3) -> DVec3) -> Chain {
    let own = sections.iter().filter(|cap| cap.origin == Origin::Face(face));
    let moved =
        |cap: &Cap| Cap { origin: cap.origin, border: cap.border.iter().map(|side| side.map(&to)).collect() };
    Chain { triangles: Vec::new(), caps: own.map(moved).collect() }
}

/// What each of the distinct parts of a divided neighbour has of such a section, in the area of its face.
pub(super) fn overlaps(section: &Chain, face: u8, neighbour: &Cell, division: &Division) -> Vec<f64> {
    let parts = neighbour.distinct_parts();
    let mut areas = vec![0.0; parts.len()];
    for (wall, chain) in division.parts(section).0.iter().enumerate() {
        if let Some(found) = neighbour.parts[wall].and_then(|part| parts.binary_search(&part).ok()) {
            areas[found] += face_area(&chain.caps, face);
        }
    }
    areas
}
