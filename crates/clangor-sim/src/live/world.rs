//! A live world: state, advance and queries.

use clangor_core::body::{Body, BodyId, Link, LinkEnd, Motion, Surface, World};
use clangor_core::contact::ImpactPulse;
use clangor_core::timeline::ContactRow;
use glam::DVec3;

use super::check::{check, check_gravity, check_placed};
use super::error::LiveError;
use super::impacts::Impacts;
use super::limits::{FASTEST, LONGEST_ADVANCE, MOST_BODIES, RADII};
use super::settings::LiveSettings;
use crate::body_state::BodyState;
use crate::error::SimulationError;
use crate::solver_choice::{Solver, choose_solver};
use crate::spheres::{Engine, Stepped};

/// The exact solver is rebuilt when its clock has run this long \[s\], so that times keep a finer resolution
/// than lengths.
const LONGEST_CLOCK: f64 = 64.0;
/// Time slice in which the events of the exact solver are counted \[s\].
const SLICE: f64 = 1.0 / 256.0;
/// Burst allowance: the exact solver may use the events of this time in advance \[s\].
const BURST: f64 = 0.25;
/// Number of touching pairs beyond which the exact solver is not used, because it solves them all
/// simultaneously.
const MOST_TOUCHES: usize = 200;
/// A world of spheres that runs without a fixed end and accepts changes.
pub struct LiveWorld {
    /// The present state while `motion` has no solver, else an earlier one.
    pub(super) world: World,
    pub(super) motion: ActiveSolver,
    pub(super) settings: LiveSettings,
    /// Time at which the solver's clock started \[s\].
    pub(super) origin: f64,
    pub(super) impacts: Impacts,
    /// Events that the exact solver may still use.
    credit: f64,
    /// Completed time slices of the exact solver.
    slices: u32,
}

/// The solver that moves the world.
pub(super) enum ActiveSolver {
    /// No solver yet; this one will be built from the present state.
    ToBuild(Solver),
    Exact(Box<Engine>),
    Stepped(Box<Stepped>),
}

impl LiveWorld {
    /// A world at time 0.
    ///
    /// # Errors
    /// [`LiveError`] for bodies that are neither spheres nor planes, overlapping bodies, or numbers out of
    /// range.
    pub fn new(world: &World, settings: LiveSettings) -> Result<Self, LiveError> {
        check("v_min", settings.v_min, [0.0, f64::MAX], "0 m/s or more")?;
        check("exact_events", settings.exact_events, [0.0, f64::MAX], "0 or more")?;
        check("time_step", settings.time_step, [1e-5, 1e-2], "from 1e-5 s to 1e-2 s")?;
        if world.bodies.len() > MOST_BODIES {
            return Err(LiveError::Full);
        }
        check_gravity(world.gravity)?;
        for body in &world.bodies {
            check_placed(body.pose.position, body.velocity)?;
            if let Surface::Sphere { radius } = *body.surface {
                check("the radius", radius, RADII, "from 1e-4 m to 100 m")?;
                let rim = body.angular_velocity.length() * radius;
                check("the speed of a spinning rim", rim, [0.0, FASTEST], "at most 200 m/s")?;
            }
        }
        Engine::new(world, false, None)?.check_overlaps(world)?;
        let solver =
            if world.links.is_empty() { choose_solver(world, settings.solver) } else { Solver::Spheres };
        Ok(LiveWorld {
            world: world.clone(),
            motion: ActiveSolver::ToBuild(solver),
            settings,
            origin: 0.0,
            impacts: Impacts::new(settings.v_min, settings.log),
            credit: BURST * settings.exact_events,
            slices: 0,
        })
    }

    /// The present time \[s\].
    pub fn time(&self) -> f64 {
        self.origin + self.clock()
    }

    /// Time on the clock of the solver \[s\].
    fn clock(&self) -> f64 {
        match &self.motion {
            ActiveSolver::ToBuild(_) => 0.0,
            ActiveSolver::Exact(engine) => engine.now,
            ActiveSolver::Stepped(stepped) => stepped.now(),
        }
    }

    /// Which solver moves the world: `Spheres` for the exact one, `Rigid` for the stepped one.
    pub fn solver(&self) -> Solver {
        match &self.motion {
            ActiveSolver::ToBuild(solver) => *solver,
            ActiveSolver::Exact(_) => Solver::Spheres,
            ActiveSolver::Stepped(_) => Solver::Rigid,
        }
    }

    /// Advances to the time `until` \[s\], with about `most` events at most; `false` if the time was not
    /// reached. The stepped solver may overshoot by up to one step.
    ///
    /// # Errors
    /// [`LiveError`] for a time that is negative, NaN, or more than [`LONGEST_ADVANCE`] ahead, and for a
    /// world that diverges.
    pub fn advance(&mut self, until: f64, most: u64) -> Result<bool, LiveError> {
        let furthest = self.time() + LONGEST_ADVANCE;
        check("the time", until, [0.0, furthest], "not negative, and at most 60 s from now")?;
        let mut left = most.max(1);
        while left > 0 && self.clock() < until - self.origin {
            self.build()?;
            left = left.saturating_sub(self.go_on(until, left)?);
        }
        self.impacts.close(&self.world.bodies, self.clock(), self.origin)?;
        Ok(self.clock() >= until - self.origin)
    }

    /// Whether the world stays with the exact solver at any cost.
    fn is_exact_for_good(&self) -> bool {
        !self.world.links.is_empty() || self.settings.solver == Solver::Spheres
    }

    /// Builds the solver if there is none.
    fn build(&mut self) -> Result<(), LiveError> {
        let ActiveSolver::ToBuild(solver) = self.motion else { return Ok(()) };
        self.slices = 0;
        if solver == Solver::Spheres {
            let mut engine = Engine::new(&self.world, false, None)?;
            if self.is_exact_for_good() || engine.touching() <= MOST_TOUCHES {
                engine.begin();
                self.motion = ActiveSolver::Exact(Box::new(engine));
                return Ok(());
            }
        }
        let LiveSettings { time_step, v_min, .. } = self.settings;
        self.motion = ActiveSolver::Stepped(Box::new(Stepped::new(&self.world, time_step, v_min)?));
        Ok(())
    }

    /// Advances by a time slice or a step. Returns its cost in events.
    fn go_on(&mut self, until: f64, most: u64) -> Result<u64, LiveError> {
        let free = self.is_exact_for_good();
        let LiveWorld { world, motion, impacts, .. } = self;
        let engine = match motion {
            ActiveSolver::Exact(engine) => engine,
            ActiveSolver::Stepped(stepped) => {
                return Ok(impacts.record(|recorder| stepped.step(world, recorder))?);
            }
            ActiveSolver::ToBuild(_) => return Ok(0),
        };
        let allowed = if free { most } else { most.min(self.credit.max(0.0) as u64 + 1) };
        let end = f64::from(self.slices + 1) * SLICE;
        let stop = end.min(until - self.origin);
        let needed = match impacts.record(|recorder| engine.advance(world, stop, allowed, recorder)) {
            Err(SimulationError::Diverged { .. }) if !free => {
                self.release_state(Solver::Rigid)?;
                return Ok(1);
            }
            needed => needed?,
        };
        if !free {
            self.credit -= needed as f64;
        }
        if engine.now >= end {
            engine.renumber_if_mixed();
            self.slices += 1;
            self.credit =
                (self.credit + SLICE * self.settings.exact_events).min(BURST * self.settings.exact_events);
            if engine.now >= LONGEST_CLOCK {
                self.release_state(Solver::Spheres)?;
            }
        } else if self.credit < 0.0 {
            self.release_state(Solver::Rigid)?;
        }
        Ok(needed)
    }

    /// Copies the present state from the solver into `world` and drops the solver; `solver` will be built
    /// from that state.
    pub(super) fn release_state(&mut self, solver: Solver) -> Result<(), LiveError> {
        if let ActiveSolver::ToBuild(next) = &mut self.motion {
            *next = solver;
            return Ok(());
        }
        let (clock, states) = (self.clock(), self.states());
        for (body, state) in self.world.bodies.iter_mut().zip(states) {
            (body.pose, body.velocity, body.angular_velocity) =
                (state.pose, state.velocity, state.angular_velocity);
        }
        self.impacts.close(&self.world.bodies, f64::INFINITY, self.origin)?;
        self.origin += clock;
        self.motion = ActiveSolver::ToBuild(solver);
        Ok(())
    }

    /// The impacts since the last [`clear`](LiveWorld::clear), in order of time.
    pub fn impacts(&self) -> &[ImpactPulse] {
        self.impacts.ready()
    }

    /// Discards the impacts so far.
    pub fn clear(&mut self) {
        self.impacts.clear();
    }

    /// Every impulse since the last call, including lasting contacts; empty unless [`LiveSettings::log`] is
    /// set.
    pub fn take_log(&mut self) -> Vec<ContactRow> {
        self.impacts.take_log()
    }

    /// Number of bodies, including removed ones, whose indices are reused by later balls.
    pub fn count(&self) -> usize {
        self.world.bodies.len()
    }

    /// Description of a body, with an earlier state; `None` for a removed body.
    pub fn body(&self, body: BodyId) -> Option<&Body> {
        self.world.bodies.get(body.index()).filter(|body| is_there(body))
    }

    /// Present states of all bodies; removed bodies keep their last state.
    pub fn states(&self) -> Vec<BodyState> {
        let mut states: Vec<BodyState> = self.world.bodies.iter().map(state_of).collect();
        match &self.motion {
            ActiveSolver::ToBuild(_) => {}
            ActiveSolver::Exact(engine) => {
                engine.states().for_each(|(body, state)| states[body as usize] = state)
            }
            ActiveSolver::Stepped(stepped) => {
                stepped.states().for_each(|(body, state)| states[body as usize] = state)
            }
        }
        states
    }

    /// Kinetic and potential energy of the balls and springs \[J\]; the potential of gravity is zero at the
    /// origin.
    pub fn energy(&self) -> f64 {
        let states = self.states();
        let mut energy = 0.0;
        let moves = |body: &Body| is_there(body) && body.motion == Motion::Free;
        for (body, state) in self.world.bodies.iter().zip(&states).filter(|(body, _)| moves(body)) {
            let spin = state.angular_velocity;
            energy += 0.5 * body.mass * state.velocity.length_squared() + 0.5 * spin.dot(body.inertia * spin)
                - body.mass * self.world.gravity.dot(state.pose.position);
        }
        for link in &self.world.links {
            if let Link::Spring { body, to, rest_length, stiffness, .. } = *link {
                let far = match to {
                    LinkEnd::Point(point) => point,
                    LinkEnd::Body { body: other, .. } => states[other.index()].pose.position,
                };
                let stretch = far.distance(states[body.index()].pose.position) - rest_length;
                energy += 0.5 * stiffness * stretch * stretch;
            }
        }
        energy
    }

    /// Gravity \[m/s²\].
    pub fn gravity(&self) -> DVec3 {
        self.world.gravity
    }

    /// The links.
    pub fn links(&self) -> &[Link] {
        &self.world.links
    }
}

fn state_of(body: &Body) -> BodyState {
    BodyState { pose: body.pose, velocity: body.velocity, angular_velocity: body.angular_velocity }
}

/// Whether a body has not been removed.
pub(super) fn is_there(body: &Body) -> bool {
    body.life.holds(0.0)
}
