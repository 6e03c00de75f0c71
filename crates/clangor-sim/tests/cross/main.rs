//! Cross-checks: two independent methods agree.

#[path = "../sphere_worlds/mod.rs"]
mod sphere_worlds;

mod fracture_elasticity;
mod pair_restitution;
