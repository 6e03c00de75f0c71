//! From impulses to forces: how long a collision lasts, and how its force runs over that time (\[PAN\] §3).
//!
//! ```text
//! rows of an impact ─► effective mass, local radii, speed ─► duration τ (Hertz)
//!                   ─► force profile ─► pulse per body
//! ```
//!
//! Weaker contact forces form a force stream ([`force_stream`](mod@force_stream)).

pub mod chain_onset;
mod contact_error;
pub mod crack_pulses;
pub mod effective_mass;
pub mod force_profile;
pub mod force_stream;
pub mod hertz;
pub mod impact_pulse;
pub mod local_curvature;
pub mod pose_history;
pub mod pulses;
mod row_checks;

pub use contact_error::ContactError;
pub use crack_pulses::crack_pulses;
pub use force_profile::ForceProfile;
pub use force_stream::{StreamPoint, StreamSettings, StreamedForce, force_stream};
pub use impact_pulse::{BodyPulse, ImpactPulse};
pub use pose_history::PoseHistory;
pub use pulses::{ContactReport, ContactSettings, impact_pulses};
