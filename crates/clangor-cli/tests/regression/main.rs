//! Regressions: mistakes that were made once, and bad input, stay handled.

#[path = "../program/mod.rs"]
mod program;

mod bad_input;
mod bake;
mod breaking_runs;
mod hostile_files;
mod import_messages;
mod mesh_mends;
mod modes;
