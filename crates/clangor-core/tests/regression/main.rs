//! Regressions: mistakes that were made once, and bad input, stay handled.

mod material_presets;
mod scene_errors;
mod scene_files;
mod scene_instantiate;
mod scene_supports;
