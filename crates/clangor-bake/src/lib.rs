//! Offline numerics: how a body of any shape radiates when it is accelerated.
//!
//! ```text
//! shape ─► RadiationSolver ─► multipoles at some frequencies ─► rational fit ─► AccelerationField
//!          helmholtz, wave     radiation                        rational
//! ```
//!
//! Everything here may be slow, threaded and heavy. What it makes is
//! `clangor_core::sound_model::acceleration::field`, which the runtime library plays.

pub mod acceleration;
pub mod bem;
pub mod fdtd;
pub mod fem;
pub mod fitting;
pub mod geometry_class;
pub mod gpu;
pub mod mesh;
pub mod modal;
pub mod modal_analysis;
pub mod modal_radiation;
pub mod quadrature;
pub mod radiation;
pub mod reference;
pub mod soundbank;
pub mod stress;
