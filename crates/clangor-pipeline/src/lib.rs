//! The stages with their files: scene and meshes in, timeline and WAV out.
