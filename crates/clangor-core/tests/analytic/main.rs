//! Closed forms: what is computed equals them.

#[path = "../bodies/mod.rs"]
mod bodies;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../compliant_bodies/mod.rs"]
mod compliant_bodies;
#[path = "../ringing/mod.rs"]
mod ringing;
#[path = "../bodies/sphere_field.rs"]
mod sphere_field;
#[path = "../bodies/sphere_near_field.rs"]
mod sphere_near_field;

mod compliant;
mod effective_mass;
mod field_sound;
mod fixed_plates;
mod geometry_mass;
mod ground;
mod load_history;
mod modal_sound;
mod pair_restitution;
mod plate;
mod room;
mod sphere;
mod touched_edges;
