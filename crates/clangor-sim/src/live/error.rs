//! Errors of a live world.

use clangor_core::contact::ContactError;

use super::limits::MOST_BODIES;
use crate::error::SimulationError;

/// Why a live world refuses.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// A number out of its range, or none.
    #[error("{what} = {value} is not possible: it must be {range}")]
    BadNumber {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// A body that is not there.
    #[error("there is no body {body}")]
    UnknownBody {
        /// Its index.
        body: u32,
    },
    /// A body that nothing moves.
    #[error("\"{body}\" is not a ball that moves freely")]
    NotFree {
        /// Its name.
        body: String,
    },
    /// A new ball where another body is.
    #[error("the new ball overlaps \"{body}\" by {depth:.3e} m")]
    Overlap {
        /// The body in the way.
        body: String,
        /// By how much \[m\].
        depth: f64,
    },
    /// Too many bodies.
    #[error("there are {MOST_BODIES} bodies; remove some first")]
    Full,
    /// The solver's reason.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// An impact that has no force.
    #[error(transparent)]
    Contact(#[from] ContactError),
}
