//! Cross-checks: two independent methods agree.

#[path = "../recorded_boxes/mod.rs"]
mod boxes;

mod audio_draft;
mod compare;
mod glb;
mod live_body;
mod modal_proxy;
mod pan_sound;
mod proxy_mean;
mod recorded_boxes;
