//! Time-stepped impulses for bodies of any shape.
//!
//! One step of length Δt:
//! 1. every body flies freely to the middle of the step (`state`, `flight`), where contacts are found or
//!    re-measured (`broad_phase`, `pair`, `manifold`);
//! 2. the *collision phase* takes the impacts of the step in the order of their times, each at the exact
//!    poses of its instant, with restitution and friction (`collision_phase`); bodies
//!    with modes give way meanwhile (`compliant_block`);
//! 3. gravity, springs and loads act;
//! 4. the *contact phase* solves resting, sliding and rolling contact without restitution, and closes the
//!    joints (`contact_phase`, `reactions`);
//! 5. every body flies to the end of the step, and bodies that have been at rest fall asleep (`sleep`).
//!
//! The two phases are those of Guendelman, Bridson and Fedkiw (2003, \[GUE\]), the midpoint geometry
//! Moreau's, the reflections Smith et al.'s (2012, \[REFL\]). Every change of momentum except that by gravity
//! is a row of the [`StepLog`], so that `m Δv = m g Δt + Σ j` and `ΔL = Σ (r × j + c)` hold to rounding for
//! every body that is awake, in every step.
//!
//! Flight and impacts of a ball are exact for any Δt; those of other shapes are as accurate as `flight`.
//!
//! Between two steps, bodies may be replaced by their pieces (`replacement`).
//!
//! Differs: \[GUE\] orders nothing inside a step and uses shock propagation; neither gives a logged balance.

mod broad_phase;
mod clip;
mod closing;
mod collision_block;
mod collision_phase;
mod collision_scene;
mod compliance;
mod compliant_block;
mod contact_phase;
mod contact_row;
mod cut_short;
mod flight;
mod grip;
mod impact_threshold;
mod joined_bodies;
mod joint;
mod joint_row;
mod linkage;
mod load;
mod manifold;
mod mover;
mod pair;
mod prediction;
mod pressed_balls;
mod push_limits;
mod reactions;
mod replacement;

mod run;
mod shape;
mod sleep;
mod spring;
mod spring_balance;
mod state;
mod step_log;
mod stiff_spring;
mod strained_net;
mod world;

pub use compliance::ContactModes;
pub use cut_short::CutShort;
pub use joined_bodies::{JoinedBodies, JoinedContact, JoinedPair};
pub use replacement::{Breaker, CrackImpulse, Replacement};
pub(crate) use run::run;
#[cfg(feature = "fracture")]
pub(crate) use shape::check_surface;
pub use step_log::{Impulse, PairImpulses, SolvedLoad, StepLog};
pub use world::RigidWorld;
