//! What a body's field is solved with: a solver, the frequencies it is asked for, and what to say of it.

use crate::radiation::RadiationSolver;

/// A solver with its description.
pub(super) struct Prepared {
    /// The solver.
    pub(super) solver: Box<dyn RadiationSolver>,
    /// Highest wavenumber [1/m] that it solves.
    pub(super) highest: f64,
    /// Spacing in κ of the first solves.
    pub(super) spacing: f64,
    /// Name of the method.
    pub(super) method: &'static str,
    /// Unknowns, or cells.
    pub(super) unknowns: usize,
    /// Warnings for the user.
    pub(super) warnings: Vec<String>,
    /// Wavenumbers [1/m] above it that it knows, ascending: the field goes up to the last.
    pub(super) above: Vec<f64>,
    /// Most solves; as many as the band may need without.
    pub(super) most_solves: Option<usize>,
}
