//! Physically based sound of rigid bodies: a scene goes in, the pressure at a listener comes out, in pascals.
//!
//! ```text
//! scene ──► (clangor-sim) ──► timeline ──► contact ──► synthesis ──► pressure [Pa]
//!              dynamics        what happened  forces     clicks at a listener
//! ```
//!
//! Units are SI everywhere: metres, seconds, kilograms, newtons, pascals, radians. Scenes are right-handed
//! with y up. Physics is `f64`, audio is `f32`. Time dependence is e^{+iωt} with outgoing waves hₙ⁽²⁾.
//!
//! This crate owns no files, no threads and no clock: it can run on an audio thread or in a browser. Dynamics
//! is `clangor-sim`; files and stages are `clangor-pipeline`; the program is `clangor-cli`.
//!
//! Sources are named by the short names of ARCHITECTURE.md: \[PAN\], \[PROXY\], \[FRAC\], \[HW\].

pub use glam;

pub mod acoustics;
pub mod body;
pub mod contact;
pub mod geometry;
pub mod material;
pub mod math;
pub mod medium;
pub mod output;
pub mod pose;
pub mod propagation;
pub mod quantity;
pub mod realtime;
pub mod reference;
pub mod scene;
pub mod shape;
pub mod sound_model;
pub mod synthesis;
pub mod timeline;
