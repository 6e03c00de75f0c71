//! Report of a rendering: clicks rendered and left out.

use std::collections::BTreeMap;

use crate::body::BodyId;

/// Counts of clicks rendered and left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderReport {
    /// Clicks pushed.
    pub clicks: u64,
    /// Clicks left out at a receiver inside the body, or inside the sphere in its place.
    pub receiver_inside: u64,
    /// The first of them: receiver, body, time of the click \[s\].
    pub first_inside: Option<(usize, BodyId, f64)>,
    /// Clicks left out because the body's centre was below the rigid floor.
    pub below_floor: u64,
    /// Highest frequency \[Hz\] of the field of each body whose field ends below the band rendered in full.
    /// [`OverlapAdd::missing_energies`](super::OverlapAdd::missing_energies) estimates the missing energy
    /// above.
    pub band_ends: BTreeMap<BodyId, f64>,
}
