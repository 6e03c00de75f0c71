//! Cross-checks: two independent methods agree.

#[path = "../bodies/mod.rs"]
mod bodies;
#[path = "../compliant_bodies/comparison.rs"]
mod comparison;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../compliant_bodies/mod.rs"]
mod compliant_bodies;
#[path = "../compliant_bodies/integrator.rs"]
mod integrator;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../ringing/mod.rs"]
mod ringing;
#[path = "../bodies/sphere_field.rs"]
mod sphere_field;
#[path = "../bodies/sphere_near_field.rs"]
mod sphere_near_field;

mod compliant_integrator;
mod ground;
mod live_engine;
mod live_pulses;
mod modal_newmark;
mod sphere_reference;
