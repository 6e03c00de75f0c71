//! Scenes: the scene file as typed data, with all errors reported at once.
//!
//! ```text
//! text ──► Scene::from_toml ──► Scene ──► instantiate(loader) ──► World
//!            all errors, each               files read, copies placed,
//!            with line and remedy           links resolved
//! ```
//!
//! The format is documented in `docs/format/scene.md`. This module reads no files: meshes come from a loader
//! that the caller supplies.

pub mod body_description;
pub mod breaking;
mod decode;
pub mod diagnostic;
pub mod instantiate;
pub mod link_description;
pub mod listener;
mod placement;
pub mod render_description;
pub mod scene_description;
pub mod simulation_description;
pub mod strike_recipe;
pub mod suggest;
pub mod support_description;
pub mod support_problem;
mod syntax_remedy;

pub use instantiate::instantiate;
pub use scene_description::{MAX_BODIES, STANDARD_GRAVITY, Scene, VERSION};
