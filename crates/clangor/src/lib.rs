//! Physically based sound for rigid bodies: a scene goes in, the pressure at a listener comes out, in
//! pascals.

pub use clangor_core::*;
