//! Properties: invariants that hold for any input.

#[path = "../../../clangor-core/examples/messy_meshes/messy_mesh.rs"]
mod messy_mesh;
#[path = "../solids/mod.rs"]
mod solids;

mod axisymmetric;
mod elastostatics;
mod geometry_class;
mod messy_sections;
mod modal_axisymmetric;
mod modal_bem;
mod modes;
mod noisy_mirrors;
mod remesh;
mod statistical;
mod threads;
mod triangles;
