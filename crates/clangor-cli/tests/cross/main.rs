//! Cross-checks: two independent methods agree.

#[path = "../program/mod.rs"]
mod program;
#[path = "../sound_file/mod.rs"]
mod sound_file;

mod fracture_sound;
mod interchange;
mod listed_drop;
mod one_impact;
mod recorded_joints;
mod recorded_motion;
mod ringing;
mod room;
mod shared_models;
mod web_replay;
