//! How much a timeline holds.

/// What a finished timeline holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimelineSummary {
    /// Contact rows.
    pub contacts: u64,
    /// Pose rows.
    pub poses: u64,
    /// Bodies that broke.
    pub fractures: u64,
    /// Bodies that were born of it.
    pub births: u64,
    /// Rows of forces; 0 for a timeline without.
    pub forces: u64,
}
