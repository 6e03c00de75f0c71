//! Counts and extreme values of a simulation.

use std::collections::BTreeMap;

/// What a simulation did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulationReport {
    /// Impacts that were kept.
    pub impacts: u64,
    /// Impacts dropped because they were slower than `v_min`.
    pub dropped_impacts: u64,
    /// The same for each body, as far as one of them was dropped.
    pub dropped_by_body: Vec<u64>,
    /// Contact rows written.
    pub rows: u64,
    /// Bodies that broke.
    pub fractures: u64,
    /// Pieces that were born.
    pub births: u64,
    /// What became of the impacts on bodies that may break.
    pub breaking: BreakingReport,
    /// Events of the sphere solver: impacts, cells left, phases ended, searches renewed; 0 where time is
    /// stepped.
    pub events: u64,
    /// Largest overlap seen \[m\].
    pub deepest_overlap: f64,
    /// Time simulated \[s\].
    pub time: f64,
}

/// What became of the impacts on bodies that may break.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BreakingReport {
    /// Impacts too weak for any stress to reach the strength.
    pub screened: u64,
    /// Impacts for which stress was computed.
    pub solved: u64,
    /// Impacts beyond the strength that paid for no crack.
    pub withstood: u64,
    /// Impacts beyond the strength that found as many pieces as are allowed.
    pub capped: u64,
    /// Bodies that should have broken and could not, and why; each once.
    pub refused: BTreeMap<String, String>,
}
