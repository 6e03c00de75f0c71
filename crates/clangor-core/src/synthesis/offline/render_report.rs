//! What a rendering took, and what it could not render.

use std::collections::BTreeMap;

use crate::body::BodyId;

/// Counts of clicks rendered and left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderReport {
    /// Clicks taken.
    pub clicks: u64,
    /// Clicks left out at a receiver because it was inside the body, or the sphere that stands for it.
    pub receiver_inside: u64,
    /// The first of them: receiver, body, time of the click \[s\].
    pub first_inside: Option<(usize, BodyId, f64)>,
    /// Clicks left out because the body's centre was below the rigid floor.
    pub below_floor: u64,
    /// Where the field of a body ends \[Hz\], of those that end below the highest frequency that is rendered
    /// in full. What is missing above is in
    /// [`OverlapAdd::missing_energies`](super::OverlapAdd::missing_energies).
    pub band_ends: BTreeMap<BodyId, f64>,
}
