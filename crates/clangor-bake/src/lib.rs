//! Offline numerics: how a body of any shape radiates when it is accelerated.
//!
//! ```text
//! shape ─► RadiationSolver ─► multipoles at some frequencies ─► rational fit ─► AccelerationField
//!          helmholtz, wave     radiation                        rational
//! ```
//!
//! Everything here may be slow, threaded and heavy. What it makes is `clangor::model::acceleration_field`, which the
//! runtime library plays.

pub mod acceleration_noise;
pub mod comparison;
pub mod elasticity;
pub mod elastostatics;
pub mod gpu;
pub mod helmholtz;
pub mod meridian_fit;
pub mod mirror_symmetry;
pub mod modal;
pub mod modal_bank;
pub mod modal_radiation;
pub mod modes;
pub mod multipole_projection;
pub mod published;
pub mod quadrature;
pub mod radiation;
pub mod rational;
pub mod remesh;
pub mod soundbank;
pub mod tetrahedra;
mod turned_body;
pub mod vibration;
pub mod wave;
