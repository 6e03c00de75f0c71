//! Errors of a live world.

use clangor_core::contact::ContactError;
use clangor_core::quantity::readable_length;

use super::limits::MOST_BODIES;
use crate::error::SimulationError;

/// Why a live world rejects a call.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// A number out of its range, or NaN.
    #[error("{what} = {value} is not possible: it must be {range}")]
    BadNumber {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Allowed range.
        range: &'static str,
    },
    /// A body index without a body.
    #[error("there is no body {body}")]
    UnknownBody {
        /// Its index.
        body: u32,
    },
    /// A body that is not a free ball.
    #[error("\"{body}\" is not a ball that moves freely")]
    NotFree {
        /// Its name.
        body: String,
    },
    /// A new ball that overlaps another body.
    #[error("there is no room for the ball: it would overlap \"{body}\" by {}", readable_length(*depth))]
    Overlap {
        /// The body in the way.
        body: String,
        /// By how much \[m\].
        depth: f64,
    },
    /// Too many bodies.
    #[error("there are {MOST_BODIES} bodies; remove some first")]
    Full,
    /// The solver failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// An impact whose force cannot be computed.
    #[error(transparent)]
    Contact(#[from] ContactError),
}
