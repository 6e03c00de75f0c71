//! The exact solver's records of a world at t = 0.

use clangor_core::body::{Motion, World};
use glam::DVec3;

use super::ball::{Ball, MotionPhase, Spin, Traits};
use super::grid::{Grid, NONE, NOWHERE};
use super::island::Island;
use super::links::link_islands;
use crate::SimulationError;
use crate::spheres::bodies::{Bodies, Plane};
use crate::spheres::cells::{Cells, cell_of};
use crate::spheres::pair_coefficients::PairTable;

/// Everything at t = 0.
pub(super) struct Start {
    pub(super) balls: Vec<Ball>,
    pub(super) spins: Vec<Spin>,
    pub(super) traits: Vec<Traits>,
    /// Contact compliance of each ball [1/Pa].
    pub(super) compliances: Vec<f64>,
    pub(super) planes: Vec<Plane>,
    pub(super) pairs: PairTable,
    pub(super) grid: Grid,
    /// Balls that are in no cell.
    pub(super) wide: Vec<u32>,
    /// Balls on rods and springs, together with those that springs join to them.
    pub(super) islands: Vec<Island>,
    /// Island of each ball and its place there.
    pub(super) island_places: Vec<Option<(usize, usize)>>,
}

impl Start {
    /// Records of a world's balls, in Z-order of their cells, and its planes, rods and springs.
    ///
    /// # Errors
    /// Those of [`Bodies::from_world`]; [`SimulationError::NotASphere`] for a link that cannot be simulated.
    pub(super) fn from_world(world: &World) -> Result<Self, SimulationError> {
        let mut bodies = Bodies::from_world(world)?;
        let cells = Cells::sort(world, &mut bodies.spheres);
        let mut start = records(world, bodies, &cells);
        (start.islands, start.island_places) = link_islands(world, &start.traits)?;
        Ok(start)
    }
}

/// Records of balls without links.
fn records(world: &World, bodies: Bodies, cells: &Cells) -> Start {
    let Bodies { spheres, planes, pairs, classes } = bodies;
    let mut grid = Grid::new(cells.edge, cells.low, cells.high, spheres.len());
    let (mut balls, mut spins, mut traits, mut wide) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut compliances = Vec::new();
    for sphere in &spheres {
        let body = &world.bodies[sphere.body];
        let free = body.motion == Motion::Free;
        let moving = |v: DVec3| if free { v } else { DVec3::ZERO };
        balls.push(Ball {
            position: body.pose.position,
            velocity: moving(body.velocity),
            time: 0.0,
            radius: sphere.radius,
            acceleration: moving(world.gravity),
            generation: 0,
            next: NONE,
            previous: NONE,
            bucket: NOWHERE,
            cell: cell_of(body.pose.position, cells.edge),
            exit: 0,
            motion_phase: if free { MotionPhase::Ballistic } else { MotionPhase::Steady },
        });
        spins.push(Spin {
            orientation: body.pose.orientation.normalize(),
            omega: moving(body.angular_velocity),
            alpha: DVec3::ZERO,
        });
        compliances.push(body.material.contact_compliance());
        traits.push(Traits {
            body: sphere.body as u32,
            material: classes[sphere.body],
            free,
            mass: body.mass,
            inverse_mass: if free { 1.0 / body.mass } else { 0.0 },
            inverse_inertia: if free { 1.0 / body.inertia.x_axis.x } else { 0.0 },
            last_hit: f64::NEG_INFINITY,
            quick_hits: 0,
            member: NONE,
        });
    }
    for ball in 0..balls.len() {
        if balls[ball].radius <= cells.widest {
            grid.insert(&mut balls, ball);
        } else {
            wide.push(ball as u32);
        }
    }
    let island_places = vec![None; balls.len()];
    Start { balls, spins, traits, compliances, planes, pairs, grid, wide, islands: Vec::new(), island_places }
}
