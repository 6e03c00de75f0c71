//! From impulses to forces: how long a collision lasts, and how its force runs over that time (\[PAN\] §3).
//!
//! ```text
//! rows of an impact ─► effective mass, local radii, speed ─► duration τ (Hertz) ─► force profile ─► pulse per body
//! ```
//!
//! What is too gentle for that is a stream of forces ([`force_stream`](mod@force_stream)).

pub mod chain_onset;
pub mod crack_pulses;
pub mod effective_mass;
pub mod force_profile;
pub mod force_stream;
pub mod hertz;
pub mod local_curvature;
pub mod pose_history;
pub mod pulses;

pub use crack_pulses::crack_pulses;
pub use force_profile::ForceProfile;
pub use force_stream::{StreamPoint, StreamSettings, StreamedForce, force_stream};
pub use pose_history::PoseHistory;
pub use pulses::{BodyPulse, ContactReport, ContactSettings, ImpactPulse, impact_pulses};

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
        "the impact of body {body} at t = {time} s lasts {duration} s; are mass, inertia and stiffness of both bodies \
         positive?"
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
