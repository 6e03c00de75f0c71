//! How fast the forces of springs change, and what the event-driven solver can follow.
//!
//! It follows every oscillation: its work grows with the rate `√(2k/m) + 2c/m` of the fastest spring of an
//! island, for each of its balls, at about 35 µs for each radian. Faster springs are left to the time-stepped
//! solver, which gives their static force and takes their oscillation away.

use clangor_core::body::{Body, BodyId, Link, Motion, World};

/// Fastest spring that is followed \[rad/s\], 16 kHz.
pub(crate) const FASTEST: f64 = 1e5;
/// Most radians in a second of all balls on springs together that a solver is chosen for.
const MOST_RADIANS: f64 = 2.0 * FASTEST;

/// Rate at which the force of a spring on a ball changes \[rad/s\].
pub(crate) fn rate(stiffness: f64, damping: f64, mass: f64) -> f64 {
    (2.0 * stiffness / mass).sqrt() + 2.0 * damping / mass
}

/// Whether the springs of a world are so slow or so few that each oscillation can be followed.
pub(crate) fn can_be_followed(world: &World) -> bool {
    let free = |id: BodyId| world.bodies.get(id.index()).filter(|body: &&Body| body.motion == Motion::Free);
    let (mut fastest, mut on_springs) = (0.0_f64, vec![false; world.bodies.len()]);
    for link in &world.links {
        let Link::Spring { stiffness, damping, .. } = *link else { continue };
        for id in link.bodies() {
            if let Some(body) = free(id) {
                fastest = fastest.max(rate(stiffness, damping, body.mass));
                on_springs[id.index()] = true;
            }
        }
    }
    let balls = on_springs.iter().filter(|on| **on).count() as f64;
    fastest <= FASTEST && fastest * balls <= MOST_RADIANS
}
