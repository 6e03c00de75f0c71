//! Why the contacts of a timeline cannot be turned into forces.

/// Why a timeline's contacts cannot be turned into forces.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// A row names a body that is not there.
    #[error("the {what} at t = {time} s names body {body}, but there are {bodies}")]
    UnknownBody {
        /// Contact or pose.
        what: &'static str,
        /// The index it names.
        body: u32,
        /// Number of bodies.
        bodies: usize,
        /// When \[s\].
        time: f64,
    },
    /// A row names a body that is not there yet, or no longer.
    #[error("the {what} at t = {time} s names body {body}, which lives from {birth} s to {death} s")]
    NotAlive {
        /// Contact or pose.
        what: &'static str,
        /// The index it names.
        body: u32,
        /// When \[s\].
        time: f64,
        /// First instant of the body \[s\].
        birth: f64,
        /// Last instant of the body \[s\].
        death: f64,
    },
    /// A number that is not finite.
    #[error("the {what} of body {body} at t = {time} s holds a number that is not finite")]
    NotFinite {
        /// Contact or pose.
        what: &'static str,
        /// First body of the row.
        body: u32,
        /// When \[s\].
        time: f64,
    },
    /// Hertz's formula gives no positive, finite duration.
    #[error(
        "the impact of body {body} at t = {time} s lasts {duration} s; are mass, inertia and stiffness of \
        both bodies positive?"
    )]
    NoDuration {
        /// First body of the row.
        body: u32,
        /// When \[s\].
        time: f64,
        /// Duration found \[s\].
        duration: f64,
    },
}
