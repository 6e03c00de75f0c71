//! From impulses to forces: how long a collision lasts, and how its force runs over that time (\[PAN\] §3).
//!
//! ```text
//! rows of an impact ─► two sides, points, normal, speed ─► contact_forces ─► pulse
//! ```
//!
//! [`contact_forces`](mod@contact_forces) is the one place where an impact becomes forces, on the motion, the
//! modes and the ground, whatever calls it. [`pulses`] and [`mod@crack_pulses`] give it the rows of a
//! timeline.
//!
//! Dynamics that lets the force of the contact move the bodies asks
//! [`group_impact`](mod@group_impact): all bodies and contacts of one instant, impulses out, and on request
//! what each body feels over time ([`load_history`](mod@load_history)).
//!
//! Weaker contact forces form a force stream ([`force_stream`](mod@force_stream)).

pub mod chain_onset;
pub mod compliant;
mod contact_error;
pub mod contact_forces;
mod contact_points;
mod contact_scale;
pub mod contact_side;
mod corner_form;
pub mod crack_pulses;
pub mod force_history;
pub mod force_profile;
pub mod force_shape;
pub mod force_stream;
pub mod group_impact;
pub mod hertz;
pub mod hertz_ellipse;
pub mod hertz_pulse;
pub mod impact;
pub mod impact_pulse;
pub mod impact_solver;
pub mod load_history;
pub mod modal_energy;
pub mod pose_history;
pub mod pulses;
pub mod recorded_forces;
pub mod relative_curvature;
mod relative_motion;
mod row_checks;
mod slow_rest;
mod touched_form;
pub mod touching;
mod vibrating_member;

pub use contact_error::ContactError;
pub use contact_forces::{ForceSettings, ImpactModel, contact_forces};
pub use contact_side::ContactSide;
pub use crack_pulses::crack_pulses;
pub use force_history::ForceHistory;
pub use force_profile::ForceProfile;
pub use force_shape::ForceShape;
pub use force_stream::{StreamPoint, StreamSettings, StreamedForce, force_stream};
pub use group_impact::{GroupContact, GroupImpact, GroupMember, GroupSolver};
pub use hertz::HertzRange;
pub use impact::{ContactPoint, Impact};
pub use impact_pulse::{BodyPulse, ImpactPulse};
pub use impact_solver::{ImpactSolver, SolveReport};
pub use load_history::LoadHistory;
pub use modal_energy::{ModesAtContact, no_modes};
pub use pose_history::PoseHistory;
pub use pulses::{ContactReport, ContactSettings, StruckBodies, impact_pulses, impact_pulses_on};
pub use recorded_forces::force_rows;
pub use touching::{Spread, Touch, touching};
