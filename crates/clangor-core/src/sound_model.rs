//! The sound model of a body: the pressure field of its rigid motion per unit of acceleration, and its modes.

pub mod acceleration;
pub mod files;
pub mod modal;
pub mod rule;
pub mod soundbank;

pub use rule::{AccelerationRule, ModalRule, SoundRule};
