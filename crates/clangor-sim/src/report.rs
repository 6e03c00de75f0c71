//! Counts and extreme values of a simulation.

use std::collections::BTreeMap;

/// Counts and extreme values of a simulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulationReport {
    /// Impacts in the log.
    pub impacts: u64,
    /// Impacts dropped because they were slower than `v_min`.
    pub dropped_impacts: u64,
    /// Dropped impacts of each body, up to the last body that has any.
    pub dropped_by_body: Vec<u64>,
    /// Contact rows written.
    pub rows: u64,
    /// Bodies that broke.
    pub fractures: u64,
    /// Pieces of broken bodies.
    pub births: u64,
    /// Outcomes of the impacts on bodies that may break.
    pub breaking: BreakingReport,
    /// Events of the event-driven solver: impacts, cell crossings, ends of phases, renewed searches; 0 for
    /// the time-stepped solver.
    pub events: u64,
    /// Impacts whose contacts were solved: bodies give way.
    pub solved: u64,
    /// Impacts that should have been solved but could not be, and follow the law of rigid bodies.
    pub fallen_back: u64,
    /// Largest overlap seen \[m\].
    pub deepest_overlap: f64,
    /// Time simulated \[s\].
    pub time: f64,
}

/// Outcomes of the impacts on bodies that may break.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BreakingReport {
    /// Impacts too weak for any stress to reach the strength; nothing was solved.
    pub screened: u64,
    /// Impacts for which stress was computed.
    pub solved: u64,
    /// Impacts whose force over time could not be solved: the peak of a half-sine loads the body.
    pub unsolved: u64,
    /// Impacts beyond the strength whose energy was too small for any crack.
    pub withstood: u64,
    /// Impacts beyond the strength on bodies that already have the largest number of pieces.
    pub capped: u64,
    /// Bodies that should have broken but could not, with the first reason.
    pub refused: BTreeMap<String, String>,
}
