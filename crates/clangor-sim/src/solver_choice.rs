//! Which of the two solvers simulates a world.

use clangor_core::body::{Body, Link, Motion, Surface, World};
use clangor_core::glam::DVec3;
pub use clangor_core::scene::simulation_description::SolverChoice as Solver;

/// More inelastic balls than this that fall freely may pile up, which the sphere solver can follow but
/// slowly.
const FEW_FALLING: usize = 8;

/// The solver that `Auto` stands for in a world: `Spheres` where all bodies are spheres and planes that
/// forces alone move, unless so many inelastic balls fall that they may come to lie on each other; else
/// `Rigid`.
pub fn choose_solver(world: &World, solver: Solver) -> Solver {
    let suits_spheres = |b: &Body| {
        let prescribed = matches!(&b.motion, Motion::Keyframed(track) if !track.is_fixed());
        !matches!(*b.surface, Surface::Mesh(_)) && !prescribed
    };
    match solver {
        Solver::Auto if world.links.iter().any(|l| matches!(l, Link::Hang { .. })) => Solver::Spheres,
        Solver::Auto if world.bodies.iter().all(suits_spheres) && falling(world) <= FEW_FALLING => {
            Solver::Spheres
        }
        Solver::Auto => Solver::Rigid,
        chosen => chosen,
    }
}

/// Free inelastic balls that start above every plane, under gravity.
fn falling(world: &World) -> usize {
    let planes: Vec<&Body> =
        world.bodies.iter().filter(|b| matches!(*b.surface, Surface::HalfSpace)).collect();
    let falls = |b: &&Body| {
        let Surface::Sphere { radius } = *b.surface else { return false };
        let height = |plane: &&Body| plane.pose.body_from_world(b.pose.position).y - radius;
        let in_the_air = planes.iter().all(|plane| height(plane) > 0.1 * radius);
        b.motion == Motion::Free && b.material.restitution < 1.0 && in_the_air
    };
    if world.gravity == DVec3::ZERO { 0 } else { world.bodies.iter().filter(falls).count() }
}
