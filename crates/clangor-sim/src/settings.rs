//! Settings of a simulation.

use crate::record::RecordSettings;
use crate::solver_choice::{ContactModel, Solver};

/// Solver, duration, time step and log of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationSettings {
    /// Which solver.
    pub solver: Solver,
    /// How an impact becomes impulses.
    pub contact: ContactModel,
    /// Simulated time \[s\].
    pub duration: f64,
    /// Step of the time-stepped solver \[s\]. The sphere solver uses it only to sample lasting contacts for
    /// the log.
    pub time_step: f64,
    /// Which rows and poses are logged.
    pub record: RecordSettings,
    /// Whether bodies at rest may sleep (time-stepped solver).
    pub sleep: bool,
}
