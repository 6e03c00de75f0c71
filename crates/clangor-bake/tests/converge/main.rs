//! Convergence: errors shrink with the resolution at the expected slope.

#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../baked_bodies/mod.rs"]
mod baked_bodies;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../../../clangor-core/tests/compliant_bodies/comparison.rs"]
mod comparison;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../../../clangor-core/tests/compliant_bodies/mod.rs"]
mod compliant_bodies;
#[path = "../baked_bodies/random_impact.rs"]
mod random_impact;

mod axisymmetric;
mod baked_impacts;
mod modal_analysis;
mod modal_axisymmetric;
mod modes;
mod narrow_bands;
mod resolution;
mod symmetric_patches;
mod triangles;
