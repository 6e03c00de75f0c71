//! Closed forms: what is computed equals them.

#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../scenes/rigid.rs"]
mod scenes;
#[path = "../sphere_worlds/mod.rs"]
mod sphere_worlds;

mod compliant_clusters;
mod fracture_impulse;
mod given_mass;
mod rigid_disk;
mod rigid_impacts;
mod rigid_joints;
mod spheres_impact;
mod spheres_links;
mod spheres_rolling;
mod stiff_springs;
