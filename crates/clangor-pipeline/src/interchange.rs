//! Exchange with other tools: `KHR_audio_rigid_bodies`, contact lists, animated glTF.

pub mod audio_rigid_bodies;
pub mod body_files;
