//! Closed forms: what is computed equals them.

#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../baked_bodies/mod.rs"]
mod baked_bodies;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../../../clangor-core/tests/compliant_bodies/mod.rs"]
mod compliant_bodies;
#[path = "../solids/plates.rs"]
mod plates;

mod axisymmetric;
mod baked_panes;
mod elastic_sphere;
mod elastostatics;
mod fdtd_sphere;
mod finite_cells;
mod fit;
mod modal_sphere;
mod modal_sphere_flat;
mod supports;
mod symmetric_patches;
mod thin_plates;
mod triangles;
