//! Properties: invariants that hold for any input.

#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../recorded_boxes/mod.rs"]
mod boxes;
#[path = "../imported_motion/mod.rs"]
mod imported_motion;
#[path = "../parquet_columns/mod.rs"]
mod parquet_columns;
#[path = "../timelines/mod.rs"]
mod timelines;

mod audio_rigid_bodies;
mod births;
mod collision_parts;
mod contact_list;
mod damaged_timelines;
mod datasets;
mod doubtful_lists;
mod effective_mass;
mod exact_forms;
mod field_plot;
mod gltf_nodes;
mod implicit_bodies;
mod last_keys;
mod lasting_contacts;
mod long_recordings;
mod long_rests;
mod mesh_file_class;
mod mesh_reader;
mod modal_cache;
mod mode_plot;
mod model_options;
mod motion_input;
mod noisy_motion;
mod quiet_end;
mod recorded_motion;
mod recorded_overlaps;
mod recorded_units;
mod separated_values;
mod soft_contacts;
mod stations;
mod timeline_file;
mod timeline_forces;
mod wav;
mod whole_scene_tables;
