//! Files of Clangor: read, checked and written atomically.

pub mod atomic_file;
pub(crate) mod calendar_times;
pub(crate) mod column_names;
pub mod contact_list;
pub mod glb;
pub mod gltf_motion;
pub mod input_file;
pub(crate) mod labelled_samples;
pub mod mesh_reader;
pub mod modal_soundbank;
pub mod model_cache;
pub mod named_bodies;
pub mod pose_table;
pub mod record_table;
pub mod separated_values;
pub mod soundbank;
pub mod timeline_file;
pub mod wav;
pub mod web_replay;
