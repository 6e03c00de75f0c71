//! Properties: invariants that hold for any input.

#[path = "../program/mod.rs"]
mod program;
#[path = "../sound_file/mod.rs"]
mod sound_file;

mod commands;
mod datasets;
mod licences;
mod runs;
mod serve;
