//! Worlds of spheres that run without a fixed end and can be changed while they run: balls are thrown, added
//! and removed, gravity changes.
//!
//! A [`LiveWorld`] advances to a given time, returns the impacts as force pulses, and accepts changes at the
//! instant that it has reached. Two solvers move it:
//! * the exact one ([`spheres`](crate::spheres)), from event to event. After a change it is rebuilt from the
//!   present state, which costs about as much as two events per ball;
//! * a stepped one, where bodies come to rest on each other: as [`choose_solver`](crate::choose_solver)
//!   decides, or once the exact solver has needed more than [`LiveSettings::exact_events`] events per second.
//!   The world then stays with the stepped solver.
//!
//! Worlds with rods or springs are moved by the exact solver alone, whatever it costs.
//!
//! Impacts are merged as in the log of a run ([`record`](crate::record)). An impact is therefore returned up
//! to [`MERGE_WINDOW`](crate::record::MERGE_WINDOW) after its instant, and never later than the first advance
//! after that. The returned impacts do not depend on how time is divided into advances.

mod changes;
mod check;
mod error;
mod impacts;
mod limits;
mod settings;
mod world;

pub use crate::body_state::BodyState;
pub use error::LiveError;
pub use limits::{FASTEST, LONGEST_ADVANCE, MOST_BODIES, RADII};
pub use settings::LiveSettings;
pub use world::LiveWorld;
