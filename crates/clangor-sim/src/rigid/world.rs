//! A world of bodies of any shape that is advanced in steps of time.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, World};
use clangor_core::contact::GroupSolver;
use clangor_core::material::PairCoefficients;
use clangor_core::timeline::PoseRow;
use glam::DVec3;

use super::broad_phase::{self, Neighbours};
use super::collision_phase::CollisionPhase;
use super::collision_scene::Scene;
use super::compliance::{BodySide, Compliance, ContactModes};
use super::contact_phase::ContactPhase;
use super::linkage::Linkages;
use super::load::Load;
use super::pair::{Pair, PairScratch, Step};
use super::push_limits::{START_OVERLAP, refuse_far_pushes};
use super::shape::Shape;
use super::sleep;
use super::spring::Spring;
use super::state::BodyState;
use super::step_log::StepLog;
use super::stiff_spring;
use crate::SimulationError;

/// Joints that are open by more at the start are refused \[m, or rad\].
const OPEN: f64 = 1e-6;
/// Steps between two searches for islands that may sleep.
const SLEEP_CHECK: u64 = 16;
/// Steps between two bottom-up orderings.
const ORDER_CHECK: u64 = 64;

/// A world of bodies of any shape, advanced in steps of equal length.
pub struct RigidWorld {
    pub(super) names: Vec<String>,
    pub(super) materials: Vec<clangor_core::material::Material>,
    pub(super) bodies: Vec<BodyState>,
    pub(super) shapes: Vec<Shape>,
    pub(super) sides: Vec<BodySide>,
    pub(super) springs: Vec<Spring>,
    pub(super) loads: Vec<Load>,
    pub(super) linkages: Linkages,
    pub(super) restless: Vec<bool>,
    pub(super) gravity: DVec3,
    pub(super) time_step: f64,
    sleep: bool,
    steps: u64,
    sweeps: u64,
    pub(super) pairs: Vec<Pair>,
    /// Number of bodies at the last search for pairs; later bodies are newborn.
    paired: usize,
    pub(super) neighbours: Neighbours,
    collision: CollisionPhase,
    pub(super) compliant: GroupSolver,
    contact: ContactPhase,
    scratch: PairScratch,
}

impl RigidWorld {
    /// The world at t = 0, to be advanced in steps of `time_step` \[s\]. With `sleep`, bodies at rest are put
    /// to sleep.
    ///
    /// # Errors
    /// [`SimulationError::BadBody`] for a body that cannot be simulated, [`SimulationError::Unsupported`] for
    /// a link, [`SimulationError::PushedTooFar`] for a hand, a force or a torque that is too strong for the
    /// step, [`SimulationError::StartOverlap`] where bodies overlap by more than 0.1 mm.
    pub fn try_new(world: &World, time_step: f64, sleep: bool) -> Result<Self, SimulationError> {
        if !(time_step > 0.0 && time_step.is_finite()) {
            return Err(SimulationError::BadSetting { setting: "time_step", value: time_step });
        }
        if !world.gravity.is_finite() {
            return Err(SimulationError::BadSetting { setting: "gravity", value: world.gravity.length() });
        }
        let mut shapes = Vec::new();
        let mut bodies = Vec::new();
        // Copies of a body share a surface, and therefore a shape.
        let mut known: Vec<*const clangor_core::body::Surface> = Vec::new();
        for body in &world.bodies {
            let bad = |reason| SimulationError::BadBody { body: body.name.clone(), reason };
            let surface = Arc::as_ptr(&body.surface);
            let shape = match known.iter().position(|k| std::ptr::eq(*k, surface)) {
                Some(shape) => shape,
                None => {
                    shapes.push(Shape::try_new(&body.surface).map_err(bad)?);
                    known.push(surface);
                    shapes.len() - 1
                }
            };
            let state = BodyState::try_new(body, shape, shapes[shape].radius).map_err(bad)?;
            bodies.push(state);
        }
        refuse_far_pushes(world, time_step)?;
        let mut restless = vec![false; bodies.len()];
        let unknown = |what, id: BodyId| {
            let name = world.bodies.get(id.index()).map_or_else(String::new, |b| b.name.clone());
            SimulationError::Unsupported { what, name }
        };
        let stiff = stiff_spring::of_links(&world.links, &bodies, time_step);
        let linkages = Linkages::try_new(&world.links, &stiff, &bodies)
            .map_err(|body| unknown("links without a body", BodyId(body as u32)))?;
        refuse_open_joints(&linkages, &bodies, world)?;
        (0..bodies.len()).for_each(|body| restless[body] = linkages.of(body).is_some());
        let springs = followed_springs(world, &stiff)?;
        springs.iter().flat_map(Spring::ends).for_each(|body| restless[body] = true);
        let loads: Vec<Load> = world.links.iter().filter_map(Load::of_link).collect();
        loads.iter().for_each(|load| restless[load.body] = true);
        let mut rigid = RigidWorld {
            names: world.bodies.iter().map(|b| b.name.clone()).collect(),
            materials: world.bodies.iter().map(|b: &Body| b.material.clone()).collect(),
            bodies,
            shapes,
            sides: world.bodies.iter().enumerate().map(|(i, b)| BodySide::new(BodyId(i as u32), b)).collect(),
            springs,
            loads,
            linkages,
            restless,
            gravity: world.gravity,
            time_step,
            sleep,
            steps: 0,
            sweeps: 0,
            pairs: Vec::new(),
            paired: 0,
            neighbours: Neighbours::default(),
            collision: CollisionPhase::default(),
            compliant: GroupSolver::default(),
            contact: ContactPhase::default(),
            scratch: PairScratch::default(),
        };
        // Overlaps at the start are errors, not overlaps at birth.
        rigid.paired = rigid.bodies.len();
        rigid.find_pairs();
        rigid.refuse_overlaps(|_| true)?;
        Ok(rigid)
    }

    /// Simulated time \[s\].
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.time_step
    }

    /// Present state of a body, or its last state if it has broken.
    pub fn pose(&self, body: BodyId) -> PoseRow {
        let state = &self.bodies[body.index()];
        PoseRow {
            time: self.time(),
            body,
            position: state.position,
            orientation: state.orientation,
            velocity: state.velocity,
            angular_velocity: state.start_angular_velocity(),
        }
    }

    /// Momentum \[N s\] and angular momentum about the centre of mass \[N m s\] of a free body now, world
    /// frame.
    pub fn momentum(&self, body: BodyId) -> (DVec3, DVec3) {
        let state = &self.bodies[body.index()];
        (state.velocity * state.mass, state.momentum)
    }

    /// Kinetic energy of all free bodies \[J\].
    pub fn kinetic_energy(&self) -> f64 {
        self.bodies.iter().map(BodyState::kinetic_energy).sum()
    }

    /// Kinetic and potential energy of all free bodies \[J\], without springs.
    pub fn energy(&self) -> f64 {
        let free = self.bodies.iter().filter(|b| b.is_free());
        self.kinetic_energy() - free.map(|b| b.mass * self.gravity.dot(b.position)).sum::<f64>()
    }

    /// Energy of all springs \[J\]: of stiff ones where the law of the last step holds, at the middle of the
    /// next step; of the others `½ k e e⁺`, with their extensions e at the middles of the last step and of
    /// the next one. Together with [`Self::energy`] it is what the solver keeps.
    pub fn spring_energy(&self) -> f64 {
        let next = |body: usize| {
            let state = &self.bodies[body];
            if self.steps == 0 {
                return state.start_pose();
            }
            state.next_middle(&state.mover(), self.time() - self.time_step, self.time_step)
        };
        let stiff = (0..self.linkages.count()).map(|linkage| self.linkages.stored(linkage, &next));
        stiff.sum::<f64>() + self.springs.iter().map(|spring| spring.stored(next)).sum::<f64>()
    }

    /// Bound on the speed of any point of a body \[m/s\].
    pub fn surface_speed(&self, body: BodyId) -> f64 {
        let state = &self.bodies[body.index()];
        state.velocity.length() + state.start_angular_velocity().length() * state.radius
    }

    /// Whether a body exists and has not broken.
    pub fn is_alive(&self, body: BodyId) -> bool {
        self.bodies.get(body.index()).is_some_and(|state| !state.is_gone())
    }

    /// Number of bodies so far, including broken ones; the next new body gets this id.
    pub fn count(&self) -> usize {
        self.bodies.len()
    }

    /// Whether a body sleeps.
    pub fn is_asleep(&self, body: BodyId) -> bool {
        self.bodies[body.index()].asleep
    }

    /// Deepest overlap of any two bodies in the last step \[m\], beyond their overlap at birth; 0 if none.
    pub fn deepest_overlap(&self) -> f64 {
        let points = self.pairs.iter().filter(|p| p.live && p.hits == 0).flat_map(|p| &p.points);
        points.map(|p| -p.gap).fold(0.0, f64::max)
    }

    /// Sweeps of the contact phase so far, a measure of the work.
    pub fn sweeps(&self) -> u64 {
        self.sweeps
    }

    /// Energy of the vibration that solved impacts left in the bodies, of each at the end of its last one
    /// \[J\].
    pub fn modal_energy(&self) -> f64 {
        self.compliant.modal_energy()
    }

    /// Numbers of impacts whose contacts were solved with the modes of the bodies, and of those that could
    /// not be.
    pub fn solved_impacts(&self) -> (u64, u64) {
        (self.compliant.solved(), self.compliant.fallen_back())
    }

    /// Advances rigid bodies by one step and writes its impulses into `log`.
    ///
    /// # Errors
    /// [`SimulationError::Diverged`] if the state is no longer finite.
    pub fn step(&mut self, log: &mut StepLog) -> Result<(), SimulationError> {
        self.step_with(log, None)
    }

    /// Advances by one step and writes its impulses into `log`. Bodies of which `modes` has modes give way.
    ///
    /// # Errors
    /// [`SimulationError::Diverged`] if the state is no longer finite.
    pub fn step_with(
        &mut self,
        log: &mut StepLog,
        modes: Option<ContactModes<'_>>,
    ) -> Result<(), SimulationError> {
        let step = Step { time: self.time(), length: self.time_step, gravity: self.gravity };
        log.clear();
        self.begin_step(&step)?;
        for pair in &mut self.pairs {
            pair.begin_step(&self.bodies, &self.shapes, &step, &mut self.scratch);
        }
        if self.sleep {
            sleep::wake_touched(&mut self.bodies, &mut self.pairs, &self.neighbours, &step);
        }
        // Collision phase: impacts with restitution.
        self.collision.run(&mut Scene {
            bodies: &mut self.bodies,
            pairs: &mut self.pairs,
            neighbours: &self.neighbours,
            shapes: &self.shapes,
            linkages: &self.linkages,
            step,
            scratch: &mut self.scratch,
            log,
            balance: &mut self.contact.balance,
            compliance: modes.map(|modes| Compliance {
                modes,
                sides: &self.sides,
                materials: &self.materials,
                solver: &mut self.compliant,
            }),
        });
        // Gravity, springs and loads.
        self.contact.balance.begin(&self.bodies, &self.linkages);
        let mut placed: Vec<_> = self.springs.iter_mut().map(|spring| spring.place(&self.bodies)).collect();
        for body in self.bodies.iter_mut().filter(|b| b.is_awake()) {
            body.unforced = [body.velocity, body.angular_velocity];
            body.pushed = Default::default();
            body.velocity += self.gravity * step.length;
        }
        for (spring, placed) in self.springs.iter().zip(&mut placed) {
            if let Some(placed) = placed {
                spring.pull(placed, &mut self.bodies, &step, log);
            }
        }
        for load in &self.loads {
            load.act(&mut self.bodies, &step, log);
        }
        // Contact phase: resting, sliding and rolling contact.
        let sweeps = self
            .contact
            .run(&mut self.bodies, &mut self.pairs, &self.linkages, &step, log)
            .map_err(|(joint, gap)| self.loose(joint, gap))?;
        self.sweeps += u64::from(sweeps);
        for (spring, placed) in self.springs.iter_mut().zip(&placed) {
            placed.iter().for_each(|placed| spring.end(placed, &self.bodies));
        }
        // Fly to the end of the step; sleep.
        self.steps += 1;
        let end = self.time();
        for body in &mut self.bodies {
            body.end_step(end, step.length);
        }
        if self.sleep {
            sleep::update_quiet(&mut self.bodies, step.length);
            if self.steps.is_multiple_of(SLEEP_CHECK) {
                let next = Step { time: end, ..step };
                sleep::fall_asleep(&mut self.bodies, &self.pairs, &self.restless, &next, log);
            }
        }
        if self.steps.is_multiple_of(ORDER_CHECK) {
            self.contact.sort(&self.bodies, &self.pairs, self.gravity);
        }
        self.check_finite()
    }

    /// Flies to the middle of the step, lets bodies go whose time has come, and finds the pairs there.
    fn begin_step(&mut self, step: &Step) -> Result<(), SimulationError> {
        let mut rebuild = self.paired < self.bodies.len();
        let mut released = Vec::new();
        for (index, body) in self.bodies.iter_mut().enumerate() {
            if body.release(step.time, step.length) {
                released.push(index);
                rebuild = true;
            }
            body.begin_step(step.time, step.length);
            rebuild |= body.moved > 0.5 * body.margin;
        }
        self.check_finite()?;
        if rebuild {
            self.find_pairs();
        }
        if !released.is_empty() {
            self.refuse_overlaps(|pair| pair.ends().iter().any(|end| released.contains(end)))?;
        }
        Ok(())
    }

    fn loose(&self, joint: usize, gap: f64) -> SimulationError {
        let near = self.linkages.joints[joint].ends[0].body;
        let body = near.map_or_else(String::new, |body| self.names[body].clone());
        let time = self.time();
        match self.linkages.joints[joint].spring {
            Some(_) => SimulationError::StrainedSpring { body, gap, time },
            None => SimulationError::LooseJoint { body, gap, time },
        }
    }

    fn check_finite(&self) -> Result<(), SimulationError> {
        match self.bodies.iter().position(|b| !b.is_finite()) {
            Some(i) => Err(SimulationError::Diverged { body: self.names[i].clone(), time: self.time() }),
            None => Ok(()),
        }
    }

    fn find_pairs(&mut self) {
        let mut keys = broad_phase::pairs(&mut self.bodies, &self.shapes, self.time_step);
        keys.retain(|key| !self.linkages.keep_apart(key.a as usize, key.b as usize));
        self.neighbours = Neighbours::new(&keys, &self.bodies);
        let mut old = std::mem::take(&mut self.pairs).into_iter().peekable();
        for key in keys {
            while old.peek().is_some_and(|p| p.key < key) {
                old.next();
            }
            let (a, b) = (key.a as usize, key.b as usize);
            self.pairs.push(match old.next_if(|p| p.key == key) {
                Some(pair) => pair,
                None => {
                    let coefficients = PairCoefficients::of(&self.materials[a], &self.materials[b]);
                    let newborn = a.max(b) >= self.paired;
                    Pair::new(key, coefficients, (&self.bodies[a], &self.bodies[b]), &self.shapes, newborn)
                }
            });
        }
        self.paired = self.bodies.len();
        self.contact.sort(&self.bodies, &self.pairs, self.gravity);
    }

    /// Refuses overlaps of bodies that begin to move: at the start, or where they are let go.
    fn refuse_overlaps(&mut self, begins: impl Fn(&Pair) -> bool) -> Result<(), SimulationError> {
        let still = Step { time: self.time(), length: 0.0, gravity: DVec3::ZERO };
        let mut deepest = (START_OVERLAP, None);
        for pair in self.pairs.iter_mut().filter(|pair| begins(pair)) {
            pair.find_exactly(&self.bodies, &self.shapes, &still, 0.0, &mut self.scratch);
            let depth = pair.exact.points.iter().map(|p| -p.gap).fold(0.0, f64::max);
            if depth > deepest.0 {
                deepest = (depth, Some(pair.key));
            }
        }
        match deepest {
            (depth, Some(key)) => Err(SimulationError::StartOverlap {
                a: self.names[key.a as usize].clone(),
                b: self.names[key.b as usize].clone(),
                depth,
                // Without the rounding of the sum of steps.
                time: (self.time() * 1e9).round() / 1e9,
            }),
            _ => Ok(()),
        }
    }
}

/// The springs that steps follow; `stiff` has the laws of the others.
fn followed_springs(
    world: &World,
    stiff: &[Option<stiff_spring::StiffSpring>],
) -> Result<Vec<Spring>, SimulationError> {
    let mut springs = Vec::new();
    for (link, stiff) in world.links.iter().zip(stiff) {
        let spring = Spring::of_link(link).map_err(|id| {
            let (body, reason) = (world.bodies[id.index()].name.clone(), "has a spring without numbers");
            SimulationError::BadBody { body, reason }
        })?;
        springs.extend(spring.filter(|_| stiff.is_none()));
    }
    Ok(springs)
}

/// Refuses joints whose ends do not meet at the start.
fn refuse_open_joints(
    linkages: &Linkages,
    bodies: &[BodyState],
    world: &World,
) -> Result<(), SimulationError> {
    for joint in &linkages.joints {
        let gap = joint.gap(&|body| bodies[body].start_pose());
        let near = joint.ends[0].body.and_then(|body| world.bodies.get(body));
        if let Some(body) = near.filter(|_| gap > OPEN || gap.is_nan()) {
            return Err(SimulationError::OpenJoint { body: body.name.clone(), gap });
        }
    }
    Ok(())
}
