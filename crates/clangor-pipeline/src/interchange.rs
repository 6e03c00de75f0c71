//! Exchange with other tools: `KHR_audio_rigid_bodies`, contact lists, recorded motion, animated glTF.

pub mod audio_rigid_bodies;
pub mod body_files;
pub mod file_frame;
mod gltf_bodies;
mod imported_header;
mod listed_flights;
pub mod motion_import;
