//! The stages with their files: scene and meshes in, timeline and WAV out.

pub mod atomic_file;
pub mod levels;
pub mod mesh_reader;
pub mod timeline_file;
pub mod wav;
