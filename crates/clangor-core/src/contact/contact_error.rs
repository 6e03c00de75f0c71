//! Errors in converting the contacts of a timeline into forces.

use crate::quantity::EFFECTIVE_MASS;
use crate::timeline::ForceProblem;

/// Error in a timeline whose contacts cannot be converted into forces.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// A row names an unknown body.
    #[error("the {what} at t = {time} s names body {body}, but there are {bodies}")]
    UnknownBody {
        /// Kind of row: contact or pose.
        what: &'static str,
        /// Index of the body in the row.
        body: u32,
        /// Number of bodies.
        bodies: usize,
        /// Time of the row \[s\].
        time: f64,
    },
    /// A row names a body before its birth or after its death.
    #[error("the {what} at t = {time} s names body {body}, which lives from {birth} s to {death} s")]
    NotAlive {
        /// Kind of row: contact or pose.
        what: &'static str,
        /// Index of the body in the row.
        body: u32,
        /// Time of the row \[s\].
        time: f64,
        /// First instant of the body \[s\].
        birth: f64,
        /// Last instant of the body \[s\].
        death: f64,
    },
    /// A number that is not finite.
    #[error("the {what} of body {body} at t = {time} s holds a number that is not finite")]
    NotFinite {
        /// Kind of row: contact or pose.
        what: &'static str,
        /// First body of the row.
        body: u32,
        /// Time of the row \[s\].
        time: f64,
    },
    /// An effective mass that cannot be one.
    #[error(
        "the contact of body {body} at t = {time} s has the effective mass {mass}; it must be {}",
        EFFECTIVE_MASS.expected()
    )]
    EffectiveMass {
        /// First body of the row.
        body: u32,
        /// Time of the row \[s\].
        time: f64,
        /// The number given \[kg\].
        mass: f64,
    },
    /// Hertz's formula gives no positive, finite duration.
    #[error(
        "the impact of body {body} at t = {time} s lasts {duration} s; are mass, inertia and stiffness of \
        both bodies positive?"
    )]
    NoDuration {
        /// First body of the row.
        body: u32,
        /// Time of the impact \[s\].
        time: f64,
        /// Duration found \[s\].
        duration: f64,
    },
    /// A recorded force that cannot be one.
    #[error("the recorded force of impact {impact_id} at t = {time} s {problem}")]
    Force {
        /// The impact.
        impact_id: u64,
        /// Its time \[s\].
        time: f64,
        /// What is wrong with the force.
        problem: ForceProblem,
    },
}
