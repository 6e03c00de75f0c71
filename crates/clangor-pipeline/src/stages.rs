//! The stages from a scene to its sound: load, simulate, obtain sound models, render.

pub mod bake_costs;
pub mod body_facts;
mod breakables;
pub mod collision_parts;
pub mod event_schedule;
pub mod find_collision_parts;
pub mod find_impact_modes;
pub mod fracture_report;
pub(crate) mod gltf_node;
pub mod impact_modes;
pub mod load;
pub mod render;
mod resting_poses;
pub mod simulate;
pub mod sound_models;
mod start_overlaps;
