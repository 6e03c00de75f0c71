//! Which of the two solvers simulates a world.

use clangor_core::body::{Body, Link, Motion, Surface, World};
use clangor_core::glam::DVec3;
pub use clangor_core::scene::simulation_description::{ContactModel, SolverChoice as Solver};

use crate::spheres::spring_pace;

/// Largest number of freely falling inelastic balls that is left to the sphere solver; more may pile up,
/// which it computes only slowly.
const FEW_FALLING: usize = 8;

/// Resolves `Auto` for a world: `Spheres` if all bodies are spheres and planes without prescribed motion,
/// links hold their centres only, springs are so slow that each oscillation can be followed, and at most
/// eight inelastic balls fall, or some hang; else `Rigid`.
pub fn choose_solver(world: &World, solver: Solver) -> Solver {
    let suits_spheres = |b: &Body| {
        let prescribed = match &b.motion {
            Motion::Keyframed(track) => !track.is_fixed(),
            Motion::Guided(_) => true,
            Motion::Free | Motion::Fixed => false,
        };
        !matches!(*b.surface, Surface::Mesh(_)) && !prescribed
    };
    let suited = world.bodies.iter().all(suits_spheres)
        && world.links.iter().all(Link::joins_centres)
        && spring_pace::can_be_followed(world);
    let hung = world.links.iter().any(|link| matches!(link, Link::Hang { .. }));
    match solver {
        Solver::Auto if suited && (hung || falling(world) <= FEW_FALLING) => Solver::Spheres,
        Solver::Auto => Solver::Rigid,
        chosen => chosen,
    }
}

/// Number of free inelastic balls that start above every plane; 0 without gravity.
fn falling(world: &World) -> usize {
    let planes: Vec<&Body> = world.bodies.iter().filter(|b| b.surface.is_plane()).collect();
    let falls = |b: &&Body| {
        let Surface::Sphere { radius } = *b.surface else { return false };
        let height = |plane: &&Body| plane.pose.body_from_world(b.pose.position).y - radius;
        let in_the_air = planes.iter().all(|plane| height(plane) > 0.1 * radius);
        b.motion == Motion::Free && b.material.restitution < 1.0 && in_the_air
    };
    if world.gravity == DVec3::ZERO { 0 } else { world.bodies.iter().filter(falls).count() }
}
