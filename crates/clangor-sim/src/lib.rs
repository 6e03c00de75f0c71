//! Dynamics: from a [`World`] to every contact impulse and the poses, as a timeline.
//!
//! Two solvers write one log ([`record`]):
//! * [`spheres`]: exact event-driven motion of spheres, planes, springs and hung spheres;
//! * [`rigid`]: time-stepped impulses for bodies of any shape (feature `rigid`).
//!
//! [`live`] advances worlds of spheres without a fixed end and accepts changes in between. [`decompose`]
//! (feature `rigid`) computes convex parts of a mesh. [`fracture`] (feature `fracture`) breaks a body into
//! pieces.
//!
//! [`World`]: clangor_core::body::World

mod body_state;
#[cfg(feature = "rigid")]
pub mod decompose;
mod error;
#[cfg(feature = "fracture")]
pub mod fracture;
pub mod live;
pub mod record;
mod report;
#[cfg(feature = "rigid")]
pub mod rigid;
mod settings;
mod simulate;
mod solver_choice;
pub mod spheres;

pub use error::{FarPush, SimulationError};
pub use report::{BreakingReport, SimulationReport};
pub use settings::SimulationSettings;
#[cfg(feature = "rigid")]
pub use simulate::simulate_breaking;
pub use simulate::{simulate, simulate_with_modes};
pub use solver_choice::{ContactModel, Solver, choose_solver};
