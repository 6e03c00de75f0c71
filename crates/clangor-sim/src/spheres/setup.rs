//! From a [`World`] to balls and planes: what the solver accepts, and in what order it keeps it.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Link, Motion, SpringEnd, Surface, World};
use glam::DVec3;

use super::arc::{Far, Island, Rod, Spring};
use super::ball::{Ball, MotionPhase, Spin, Traits};
use super::grid::{Grid, NONE, NOWHERE};
use super::pairs::Pairs;
use crate::SimulationError;

/// An overlap up to this fraction of the smaller radius is a rounding of the scene's numbers.
const TOLERATED_OVERLAP: f64 = 1e-4;
/// Balls this much wider than the median one are kept out of the grid and compared with every ball.
const WIDE: f64 = 3.0;
/// Balls per cell that the width of the cells aims at.
const BALLS_PER_CELL: f64 = 0.2;

/// A fixed half-space.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    /// Index in the world's bodies.
    pub(super) body: u32,
    /// Outward normal.
    pub(super) normal: DVec3,
    /// n·x of its surface [m].
    pub(super) offset: f64,
    /// Its class of materials.
    pub(super) material: u32,
}

/// Everything at t = 0.
pub(super) struct Start {
    pub(super) balls: Vec<Ball>,
    pub(super) spins: Vec<Spin>,
    pub(super) traits: Vec<Traits>,
    pub(super) planes: Vec<Plane>,
    pub(super) pairs: Pairs,
    pub(super) grid: Grid,
    /// Balls that are in no cell.
    pub(super) wide: Vec<u32>,
    /// Balls on rods and springs, together with those that springs join to them.
    pub(super) islands: Vec<Island>,
    /// Island of each ball and its place there.
    pub(super) seats: Vec<Option<(usize, usize)>>,
}

/// Sorts a world into balls and planes.
pub(super) fn start(world: &World) -> Result<Start, SimulationError> {
    let refuse = |body: &Body, reason| SimulationError::NotASphere { body: body.name.clone(), reason };
    let (pairs, classes) = Pairs::new(world);
    let mut spheres: Vec<(usize, f64)> = Vec::new();
    let mut planes = Vec::new();
    for (index, body) in world.bodies.iter().enumerate().filter(|(_, body)| body.life.holds(0.0)) {
        let finite = body.pose.position.is_finite()
            && body.pose.orientation.is_finite()
            && body.velocity.is_finite()
            && body.angular_velocity.is_finite();
        if !finite {
            return Err(SimulationError::Diverged { body: body.name.clone(), time: 0.0 });
        }
        match (Arc::as_ref(&body.surface), &body.motion) {
            (Surface::Mesh(_), _) => return Err(refuse(body, "it is neither a sphere nor a plane")),
            (_, Motion::Keyframed(track)) if !track.is_fixed() => {
                return Err(refuse(body, "it moves by keyframes, which the exact solver does not follow"));
            }
            (Surface::HalfSpace, Motion::Free) => return Err(refuse(body, "a half-space cannot be free")),
            (Surface::HalfSpace, _) => {
                let normal = body.pose.orientation.normalize() * DVec3::Y;
                let offset = normal.dot(body.pose.position);
                planes.push(Plane { body: index as u32, normal, offset, material: classes[index] });
            }
            (Surface::Sphere { radius }, motion) => {
                let inertia = body.inertia.x_axis.x;
                if !(*radius > 0.0 && radius.is_finite()) {
                    return Err(refuse(body, "its radius is not a positive number"));
                }
                let weighs = |x: f64| x > 0.0 && x.is_finite();
                if *motion == Motion::Free && !(weighs(body.mass) && weighs(inertia)) {
                    return Err(refuse(body, "its mass or inertia is not a positive number"));
                }
                spheres.push((index, *radius));
            }
        }
    }
    let mut start = place(world, spheres, planes, pairs, &classes);
    tie(world, &mut start)?;
    Ok(start)
}

/// Chooses the cells, and keeps the balls in the order of their cells, so that neighbours in space are
/// neighbours in memory.
fn place(
    world: &World,
    mut spheres: Vec<(usize, f64)>,
    planes: Vec<Plane>,
    pairs: Pairs,
    classes: &[u32],
) -> Start {
    let position = |index: usize| world.bodies[index].pose.position;
    let mut radii: Vec<f64> = spheres.iter().map(|s| s.1).collect();
    radii.sort_by(f64::total_cmp);
    let widest = radii.get(radii.len() / 2).map_or(0.0, |median| WIDE * median);
    let (mut low, mut high, mut inside, mut broadest) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0, 0.0_f64);
    for &(index, radius) in spheres.iter().filter(|s| s.1 <= widest) {
        low = low.min(position(index) - radius);
        high = high.max(position(index) + radius);
        inside += 1;
        broadest = broadest.max(radius);
    }
    // A handful is compared all with all.
    let edge = if inside <= 12 {
        f64::INFINITY
    } else {
        let volume: f64 = (high - low).to_array().iter().product();
        let roomy = (volume * BALLS_PER_CELL / f64::from(inside)).cbrt();
        (2.0 * broadest * (1.0 + 1e-9)).max(roomy)
    };
    if inside == 0 {
        (low, high) = (DVec3::ZERO, DVec3::ZERO);
    }
    let mut grid = Grid::new(edge, low, high, spheres.len());
    spheres.sort_by_key(|&(index, _)| (interleave(grid.cell_of(position(index) - low)), index));

    let (mut balls, mut spins, mut traits, mut wide) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for &(index, radius) in &spheres {
        let body = &world.bodies[index];
        let free = body.motion == Motion::Free;
        let moving = |v: DVec3| if free { v } else { DVec3::ZERO };
        balls.push(Ball {
            position: body.pose.position,
            velocity: moving(body.velocity),
            time: 0.0,
            radius,
            acceleration: moving(world.gravity),
            generation: 0,
            next: NONE,
            previous: NONE,
            bucket: NOWHERE,
            cell: grid.cell_of(body.pose.position),
            exit: 0,
            motion_phase: if free { MotionPhase::Ballistic } else { MotionPhase::Steady },
        });
        spins.push(Spin {
            orientation: body.pose.orientation.normalize(),
            omega: moving(body.angular_velocity),
            alpha: DVec3::ZERO,
        });
        traits.push(Traits {
            body: index as u32,
            material: classes[index],
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
        if balls[ball].radius <= widest {
            grid.insert(&mut balls, ball);
        } else {
            wide.push(ball as u32);
        }
    }
    let seats = vec![None; balls.len()];
    Start { balls, spins, traits, planes, pairs, grid, wide, islands: Vec::new(), seats }
}

/// Gathers linked balls into islands.
fn tie(world: &World, start: &mut Start) -> Result<(), SimulationError> {
    let mut ball_of = vec![None; world.bodies.len()];
    for (ball, traits) in start.traits.iter().enumerate().filter(|(_, t)| t.free) {
        ball_of[traits.body as usize] = Some(ball);
    }
    let refuse = |body: BodyId, reason| {
        let name = world.bodies[body.index()].name.clone();
        Err(SimulationError::NotASphere { body: name, reason })
    };
    // Islands are the components of the graph of springs; the lowest ball stands for its island.
    let mut root: Vec<usize> = (0..start.balls.len()).collect();
    let find = |root: &[usize], mut ball: usize| {
        while root[ball] != ball {
            ball = root[ball];
        }
        ball
    };
    let mut linked = vec![false; start.balls.len()];
    for link in &world.links {
        let (body, other) = match *link {
            Link::Hang { body, .. } => (body, None),
            Link::Spring { body, to: SpringEnd::Point(_), .. } => (body, None),
            Link::Spring { body, to: SpringEnd::Body(other), .. } => (body, Some(other)),
        };
        let balls: Vec<usize> =
            [Some(body), other].into_iter().flatten().filter_map(|b| ball_of[b.index()]).collect();
        for &ball in &balls {
            linked[ball] = true;
        }
        if let [one, two] = balls[..] {
            let (one, two) = (find(&root, one), find(&root, two));
            root[one.max(two)] = one.min(two);
        }
    }
    for ball in (0..start.balls.len()).filter(|&b| linked[b]) {
        let first = find(&root, ball);
        let island = match start.seats[first] {
            Some((island, _)) => island,
            None => {
                start.islands.push(Island::new(Vec::new(), Vec::new(), world.gravity));
                start.islands.len() - 1
            }
        };
        let members = &mut start.islands[island];
        start.seats[ball] = Some((island, members.balls.len()));
        members.balls.push(ball);
        members.masses.push(start.traits[ball].mass);
    }
    let seat = |body: BodyId| ball_of[body.index()].and_then(|ball| start.seats[ball]);
    for link in &world.links {
        match *link {
            Link::Hang { body, anchor } => {
                let Some((island, ball)) = seat(body) else {
                    return refuse(body, "it hangs, but it is not a free sphere");
                };
                let length = world.bodies[body.index()].pose.position.distance(anchor);
                let rods = &mut start.islands[island].rods;
                if !(length > 0.0 && length.is_finite()) {
                    return refuse(body, "the rod on which it hangs has no length");
                }
                if rods.iter().filter(|r| r.ball == ball).count() == 2 {
                    return refuse(body, "it hangs on more than two rods");
                }
                rods.push(Rod { ball, anchor, length });
            }
            Link::Spring { body, to, rest_length, stiffness, damping } => {
                if ![rest_length, stiffness, damping].iter().all(|x| *x >= 0.0 && x.is_finite()) {
                    return refuse(body, "its spring has a negative or infinite coefficient");
                }
                let far = match to {
                    SpringEnd::Point(point) => (None, Far::Point(point), BodyId::WORLD),
                    SpringEnd::Body(other) => {
                        (seat(other), Far::Point(world.bodies[other.index()].pose.position), other)
                    }
                };
                let (island, ball, to, far_body) = match (seat(body), far) {
                    (Some((island, ball)), (Some((_, other)), ..)) => {
                        (island, ball, Far::Ball(other), BodyId::WORLD)
                    }
                    (Some((island, ball)), (None, point, far_body)) => (island, ball, point, far_body),
                    // The free ball is at the far end.
                    (None, (Some((island, ball)), ..)) => {
                        (island, ball, Far::Point(world.bodies[body.index()].pose.position), body)
                    }
                    (None, (None, ..)) => continue,
                };
                start.islands[island].springs.push(Spring {
                    ball,
                    to,
                    far_body,
                    rest_length,
                    stiffness,
                    damping,
                });
            }
        }
    }
    Ok(())
}

/// Z-order of a cell: bits of the three coordinates in turn.
pub(super) fn interleave(cell: [i32; 3]) -> u64 {
    const STEPS: [(u32, u64); 5] = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ];
    let spread = |x: i32| {
        let bits = x.clamp(0, (1 << 21) - 1) as u64;
        STEPS.iter().fold(bits, |code, &(by, mask)| (code | code << by) & mask)
    };
    spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2
}

/// Refuses an overlap that is more than rounding.
pub(super) fn check_overlap(
    world: &World,
    a: u32,
    b: u32,
    depth: f64,
    smaller: f64,
) -> Result<(), SimulationError> {
    if depth <= TOLERATED_OVERLAP * smaller {
        return Ok(());
    }
    let name = |body: u32| world.bodies[body as usize].name.clone();
    Err(SimulationError::StartOverlap { a: name(a.min(b)), b: name(a.max(b)), depth })
}
