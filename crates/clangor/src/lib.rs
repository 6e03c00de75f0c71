//! Physically based sound for rigid bodies: a scene goes in, the pressure at a listener comes out, in
//! pascals.

pub use clangor_core::*;
#[cfg(feature = "offline")]
pub use clangor_pipeline::session::{
    self, Error, Progress, RenderedSound, Session, SessionBuilder, Stage, Strike, StruckBody,
};
