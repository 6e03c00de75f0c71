//! Properties: invariants that hold for any input.

#[path = "../bodies/mod.rs"]
mod bodies;
#[path = "../compliant_bodies/mod.rs"]
mod compliant_bodies;
#[path = "../damage/mod.rs"]
mod damage;
#[path = "../fuzzing/mod.rs"]
mod fuzzing;
#[path = "../../examples/messy_meshes/messy_mesh.rs"]
mod messy_mesh;
#[path = "../ringing/mod.rs"]
mod ringing;

mod bank_file;
mod compliant_energy;
mod compliant_input;
mod compliant_memory;
mod contact;
mod contact_forces;
mod effective_mass;
mod geometry_queries;
mod geometry_solid;
mod given_mass;
mod ground;
mod impact_solver;
mod inner_walls;
mod layering;
mod live_engine;
mod lives;
mod mend;
mod modal_file;
mod modal_state_transfer;
mod modal_stream;
mod model_file;
mod pan_file;
mod planes;
mod relative_curvature;
mod resonator_bank;
mod resonator_paths;
mod room;
mod scene_text;
mod shape_meshes;
mod shape_text;
mod sound_source;
mod strike;
mod synthesis;
mod united_parts;
