//! Brittle fracture: where a body breaks, into which pieces, and with which impulses.
//!
//! ```text
//! strain energy ──► pattern ──► split ──► pieces ──► crack_impulse ──► velocities
//!                   regions     cells                 stress released
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`pattern`] | as many regions as the strain energy pays for |
//! | [`split`] | closed pieces that fit together, and the crack between them |
//! | [`piece`] | a body of tetrahedra that knows its old surface from its cracks |
//! | [`motion`] | how pieces move when they come off |
//! | [`crack_impulse`] | how the released stress drives them apart |
//! | [`hulls`] | what pieces collide with |
//!
//! Stresses and energies are computed by `clangor_bake::stress`; the time-stepped solver moves the pieces
//! afterwards.
//!
//! Source: \[FRAC\] §3.2 and §3.3.

pub mod breaking;
mod breaking_instant;
mod cells;
mod coarsen;
mod contact_loads;
pub mod crack_impulse;
mod error;
mod family;
mod fragments;
pub mod hulls;
pub mod motion;
mod pair_history;
pub mod pattern;
pub mod piece;
mod shatter;
mod spent_energy;
pub mod split;
mod star;
mod tetrahedron;
mod tetrahedron_parts;

pub use breaking::{Breakable, BreakingBodies};
pub use error::FractureError;
pub use shatter::{Shatter, shatter, shatter_along};
