//! Properties: invariants that hold for any input.

#[cfg(feature = "fracture")]
#[path = "../brittle/mod.rs"]
mod brittle;
#[path = "../scenes/pieces.rs"]
mod cut;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../scenes/rigid.rs"]
mod scenes;
#[path = "../sphere_worlds/mod.rs"]
mod sphere_worlds;

mod breaking;
mod decompose;
mod fracture_hulls;
mod fracture_pattern;
mod fracture_pieces;
mod hung_spheres;
mod linked_contacts;
mod linked_scenes;
mod live_changes;
mod live_pile;
mod rigid_balance;
mod rigid_births;
mod rigid_limits;
mod rigid_linkages;
mod rigid_rest;
mod spheres_break;
mod spheres_ledger;
mod spheres_order;
mod spheres_robust;
mod spring_nets;
mod thin_impacts;
