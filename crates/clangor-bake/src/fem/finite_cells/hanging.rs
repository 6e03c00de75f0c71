//! Nodes on the faces between cells of different size: they follow the displacement of the larger cell.
//!
//! ```text
//! u(x_n) = Σ_k N_k(x_n) U_k,    x_n: a node of the smaller cell, k: nodes of the larger on the common face
//! ```
//!
//! so that displacements are continuous across the face. A part of the smaller cell follows that part of the
//! larger one whose section overlaps most with its own. Where it overlaps with several, these are joined
//! there.

use glam::DVec3;

use super::basis::Basis;
use super::chain::{Cap, Origin, plane_across};
use super::levels::Level;
use super::parts::{Cell, face_area};
use super::sections::{OVERLAP, ROUNDING, moved_section, overlaps};

/// Rounding of a weight.
const NO_WEIGHT: f64 = 1e-14;

/// A face of a smaller cell on that of a larger one.
pub(super) struct HangingFace {
    /// The part of the smaller cell, of all parts.
    pub(super) part: usize,
    /// The part of the larger cell, of all parts.
    pub(super) larger: usize,
    /// Others of that cell that it overlaps with.
    pub(super) also: Vec<usize>,
    /// Twice the axis, plus 1 for the upper face of the smaller cell.
    pub(super) face: u8,
    /// Place of what lies beyond the face in the larger cell, in halves of it.
    half: [usize; 3],
}

impl HangingFace {
    /// The nodes of the larger cell that a node of the smaller one on this face follows, and their weights.
    pub(super) fn followed(&self, k: usize, basis: &Basis) -> impl Iterator<Item = (usize, f64)> + use<> {
        let weights = basis.at_point(self.in_larger(basis.node(k)));
        weights.into_iter().enumerate().filter(|(_, weight)| weight.abs() > NO_WEIGHT)
    }

    /// The nodes of the smaller cell on this face.
    pub(super) fn nodes(&self, basis: &Basis) -> impl Iterator<Item = usize> {
        basis.on_face(usize::from(self.face / 2), !self.face.is_multiple_of(2))
    }

    /// A point of the smaller cell on this face, in that of the larger cell.
    pub(super) fn in_larger(&self, mut at: DVec3) -> DVec3 {
        let axis = usize::from(self.face / 2);
        at[axis] = if self.face.is_multiple_of(2) { 1.0 } else { 0.0 };
        0.5 * (at + DVec3::from_array(self.half.map(|n| n as f64)))
    }
}

/// All such faces, those of larger cells first, and those of parts that do not meet the larger cell, once for
/// each of its parts.
pub(super) fn hanging_faces(levels: &[Level]) -> (Vec<HangingFace>, Vec<HangingFace>) {
    let (mut all, mut apart) = (Vec::new(), Vec::new());
    for (larger, level) in levels.iter().zip(&levels[1..]) {
        for cell in &level.body.cells {
            for face in 0..6_u8 {
                let (axis, step) = (usize::from(face / 2), usize::from(face % 2));
                let mut beyond = cell.place;
                let Some(there) = (beyond[axis] + 2 * step).checked_sub(1) else { continue };
                beyond[axis] = there;
                let Some(other) = larger.body.cell(beyond.map(|n| n / 2)) else { continue };
                let half = beyond.map(|n| n % 2);
                for part in cell.distinct_parts() {
                    let of = |larger: usize, also: Vec<usize>| HangingFace {
                        part: level.first + part,
                        larger,
                        also,
                        face,
                        half,
                    };
                    let found = overlapping((level, cell, part), (larger, other), &of(0, Vec::new()));
                    let mut found = found.into_iter().map(|part| larger.first + part);
                    match found.next() {
                        Some(first) => all.push(of(first, found.collect())),
                        None => {
                            let parts = other.distinct_parts().into_iter();
                            apart.extend(parts.map(|part| of(larger.first + part, Vec::new())));
                        }
                    }
                }
            }
        }
    }
    (all, apart)
}

/// The parts of a larger cell whose sections overlap with that of a part of a smaller one, the largest
/// overlap first.
fn overlapping(
    (level, cell, part): (&Level, &Cell, usize),
    (larger, other): (&Level, &Cell),
    at: &HangingFace,
) -> Vec<usize> {
    if cell.section(&level.body.parts[part], at.face) <= ROUNDING {
        return Vec::new();
    }
    let Some(division) = &other.division else { return other.distinct_parts() };
    let parts = other.distinct_parts();
    // Sections of the larger cell behind the face, as that numbers it, and overlaps with them.
    let quarter = |part: &usize| within(&larger.body.parts[*part].sections, at, at.face ^ 1);
    let quarters: Vec<f64> = parts.iter().map(quarter).collect();
    let shared = match cell.division {
        Some(_) => {
            let section = moved_section(&level.body.parts[part].sections, at.face, |x| at.in_larger(x));
            overlaps(&section, at.face, other, division)
        }
        None => quarters.clone(),
    };
    let largest = shared.iter().copied().fold(0.0, f64::max);
    let own: f64 = shared.iter().sum();
    let counts = |k: &usize| {
        let enough = shared[*k] > OVERLAP * own.min(quarters[*k]);
        shared[*k] > ROUNDING && (enough || shared[*k] == largest)
    };
    let mut found: Vec<usize> = (0..parts.len()).filter(counts).collect();
    found.sort_by(|a, b| shared[*b].total_cmp(&shared[*a]));
    found.into_iter().map(|k| parts[k]).collect()
}

/// Area of the section of a part of the larger cell in the quarter of its face that the smaller one has.
fn within(sections: &[Cap], at: &HangingFace, face: u8) -> f64 {
    let mut section = moved_section(sections, face, |x| x);
    for axis in (0..3).filter(|axis| *axis != usize::from(face / 2)) {
        let above = at.half[axis] == 1;
        section = section.cut(&plane_across(axis, 0.5), above, Origin::Inner);
    }
    face_area(&section.caps, face)
}
