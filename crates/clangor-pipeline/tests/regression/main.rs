//! Regressions: mistakes that were made once, and bad input, stay handled.

#[path = "../../benches/timeline/pile.rs"]
mod pile;

mod audio_rigid_bodies;
mod timeline_size;
