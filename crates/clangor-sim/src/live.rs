//! Worlds of spheres that run on and on, and are changed on the way: thrown, added, removed, turned upside
//! down.
//!
//! A [`LiveWorld`] advances as far as it is told, hands out the impacts as force pulses, and takes changes at
//! the instant that it has reached. Two solvers move it:
//! * the exact one ([`spheres`](crate::spheres)), from event to event. It is rebuilt from the present state
//!   after a change, which costs about as much as two events per ball;
//! * a stepped one, where bodies come to lie on each other: as [`choose_solver`] says, or once the exact one
//!   has needed more than [`LiveSettings::exact_events`] events per second. There is no way back.
//!
//! Balls on rods and springs are moved by the exact solver alone, however long it takes.
//!
//! Impacts are merged as in the log of a run ([`record`](crate::record)), and so an impact is handed out up
//! to [`MERGE_WINDOW`](crate::record::MERGE_WINDOW) after its instant, never later than the first advance
//! after that. What is handed out does not depend on how the time is cut into advances.

mod impacts;

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Life, Link, Motion, SpringEnd, Surface, World};
use clangor_core::contact::{ContactError, ImpactPulse};
use clangor_core::material::Material;
use clangor_core::pose::Pose;
use clangor_core::scene::body_description::EDGE_RADIUS_RATIO;
use clangor_core::timeline::ContactRow;
use glam::{DMat3, DVec3};

use crate::spheres::{Engine, Stepped};
use crate::{SimulationError, Solver, choose_solver};
use impacts::Impacts;

/// Most bodies, those that have been removed included.
pub const MOST_BODIES: usize = 20_000;
/// Furthest that one advance goes \[s\].
pub const LONGEST_ADVANCE: f64 = 60.0;
/// Fastest that a ball may be set to move [m/s].
pub const FASTEST: f64 = 200.0;
/// Radii of balls \[m\].
pub const RADII: [f64; 2] = [1e-4, 100.0];
/// Farthest from the origin \[m\].
const FARTHEST: f64 = 1e5;
/// The exact solver's own clock never runs longer than this \[s\], so that its instants stay finer than its
/// lengths.
const LONGEST_CLOCK: f64 = 64.0;
/// Slices of time in which the events of the exact solver are counted \[s\].
const SLICE: f64 = 1.0 / 256.0;
/// Events of the exact solver may run ahead of their rate by those of this time \[s\].
const BURST: f64 = 0.25;
/// Pairs of touching balls beyond which the exact solver, which would solve them all at once, is not asked.
const MOST_TOUCHES: usize = 200;
/// Overlap of a new ball, relative to the smaller radius, that is rounding.
const TOLERATED_OVERLAP: f64 = 1e-6;

/// How a world lives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveSettings {
    /// Which solver moves the world; `Auto` for the exact one where it suits, as long as it suits.
    pub solver: Solver,
    /// Impacts slower than this are not handed out [m/s].
    pub v_min: f64,
    /// Events per second of simulated time that the exact solver may need.
    pub exact_events: f64,
    /// Time step of the stepped solver \[s\].
    pub time_step: f64,
    /// Every impulse of the stepped solver is kept for [`LiveWorld::take_log`].
    pub log: bool,
}

impl Default for LiveSettings {
    fn default() -> Self {
        LiveSettings {
            solver: Solver::Auto,
            v_min: 0.05,
            exact_events: 60_000.0,
            time_step: 1.0 / 512.0,
            log: false,
        }
    }
}

/// Why a live world refuses.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// A number out of its range, or none.
    #[error("{what} = {value} is not possible: it must be {range}")]
    BadNumber {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// A body that is not there.
    #[error("there is no body {body}")]
    UnknownBody {
        /// Its index.
        body: u32,
    },
    /// A body that nothing moves.
    #[error("\"{body}\" is not a ball that moves freely")]
    NotFree {
        /// Its name.
        body: String,
    },
    /// A new ball where another body is.
    #[error("the new ball overlaps \"{body}\" by {depth:.3e} m")]
    Overlap {
        /// The body in the way.
        body: String,
        /// By how much \[m\].
        depth: f64,
    },
    /// Too many bodies.
    #[error("there are {MOST_BODIES} bodies; remove some first")]
    Full,
    /// The solver's reason.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// An impact that has no force.
    #[error(transparent)]
    Contact(#[from] ContactError),
}

/// See the module.
pub struct LiveWorld {
    /// The present state while `motion` is to be built, else an earlier one.
    world: World,
    motion: Drive,
    settings: LiveSettings,
    /// When the clock of the solver showed zero \[s\].
    origin: f64,
    impacts: Impacts,
    /// Events that the exact solver may still need.
    credit: f64,
    /// Slices of time that it has behind it.
    slices: u32,
}

/// What moves the world.
enum Drive {
    /// This solver will, once it is built from the present state.
    Changed(Solver),
    Exact(Box<Engine>),
    Stepped(Box<Stepped>),
}

/// State of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Where it is.
    pub pose: Pose,
    /// Velocity of the centre of mass [m/s].
    pub velocity: DVec3,
    /// Angular velocity \[rad/s\], world.
    pub angular_velocity: DVec3,
}

impl LiveWorld {
    /// A world at time 0.
    ///
    /// # Errors
    /// Bodies that are neither spheres nor planes or that overlap, numbers out of range.
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
        Engine::new(world, false)?.check_overlaps(world)?;
        let solver =
            if world.links.is_empty() { choose_solver(world, settings.solver) } else { Solver::Spheres };
        Ok(LiveWorld {
            world: world.clone(),
            motion: Drive::Changed(solver),
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
            Drive::Changed(_) => 0.0,
            Drive::Exact(engine) => engine.now,
            Drive::Stepped(stepped) => stepped.now(),
        }
    }

    /// Which solver moves the world: `Spheres` for the exact one, `Rigid` for the stepped one.
    pub fn solver(&self) -> Solver {
        match &self.motion {
            Drive::Changed(solver) => *solver,
            Drive::Exact(_) => Solver::Spheres,
            Drive::Stepped(_) => Solver::Rigid,
        }
    }

    /// Goes on to a time \[s\], but not much further than `most` events: `false` if there is more to do. The
    /// stepped solver goes up to one step further than asked.
    ///
    /// # Errors
    /// A time that is negative, none, or further than [`LONGEST_ADVANCE`] away; a world that diverges.
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

    /// Whether the exact solver moves the world however long it takes.
    fn is_exact_for_good(&self) -> bool {
        !self.world.links.is_empty() || self.settings.solver == Solver::Spheres
    }

    /// Builds the solver where there is none.
    fn build(&mut self) -> Result<(), LiveError> {
        let Drive::Changed(solver) = self.motion else { return Ok(()) };
        self.slices = 0;
        if solver == Solver::Spheres {
            let mut engine = Engine::new(&self.world, false)?;
            if self.is_exact_for_good() || engine.touching() <= MOST_TOUCHES {
                engine.begin();
                self.motion = Drive::Exact(Box::new(engine));
                return Ok(());
            }
        }
        let LiveSettings { time_step, v_min, .. } = self.settings;
        self.motion = Drive::Stepped(Box::new(Stepped::new(&self.world, time_step, v_min)?));
        Ok(())
    }

    /// Goes on by a slice or a step of time. Returns what it cost in events.
    fn go_on(&mut self, until: f64, most: u64) -> Result<u64, LiveError> {
        let free = self.is_exact_for_good();
        let LiveWorld { world, motion, impacts, .. } = self;
        let engine = match motion {
            Drive::Exact(engine) => engine,
            Drive::Stepped(stepped) => {
                return Ok(impacts.record(|recorder| stepped.step(world, recorder))?);
            }
            Drive::Changed(_) => return Ok(0),
        };
        let allowed = if free { most } else { most.min(self.credit.max(0.0) as u64 + 1) };
        let end = f64::from(self.slices + 1) * SLICE;
        let stop = end.min(until - self.origin);
        let needed = match impacts.record(|recorder| engine.pass(world, stop, allowed, recorder)) {
            Err(SimulationError::Diverged { .. }) if !free => {
                self.hand_over(Solver::Rigid)?;
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
                self.hand_over(Solver::Spheres)?;
            }
        } else if self.credit < 0.0 {
            self.hand_over(Solver::Rigid)?;
        }
        Ok(needed)
    }

    /// Takes the present state out of the solver, so that it can be changed; `solver` will be built from it.
    fn hand_over(&mut self, solver: Solver) -> Result<(), LiveError> {
        if let Drive::Changed(next) = &mut self.motion {
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
        self.motion = Drive::Changed(solver);
        Ok(())
    }

    /// The impacts since the last [`clear`](LiveWorld::clear), in order of time.
    pub fn impacts(&self) -> &[ImpactPulse] {
        self.impacts.ready()
    }

    /// Forgets the impacts so far.
    pub fn clear(&mut self) {
        self.impacts.clear();
    }

    /// Every impulse so far, of lasting contacts too, if the settings ask for a log; empties it.
    pub fn take_log(&mut self) -> Vec<ContactRow> {
        self.impacts.take_log()
    }

    /// Number of bodies, those that have been removed included: their numbers are given to others later.
    pub fn count(&self) -> usize {
        self.world.bodies.len()
    }

    /// What a body is; the state in it is an earlier one. `None` where one has been removed.
    pub fn body(&self, body: BodyId) -> Option<&Body> {
        self.world.bodies.get(body.index()).filter(|body| is_there(body))
    }

    /// Present states of all bodies; those that have been removed are where they were.
    pub fn states(&self) -> Vec<BodyState> {
        let mut states: Vec<BodyState> = self.world.bodies.iter().map(state_of).collect();
        match &self.motion {
            Drive::Changed(_) => {}
            Drive::Exact(engine) => engine.states().for_each(|(body, state)| states[body as usize] = state),
            Drive::Stepped(stepped) => {
                stepped.states().for_each(|(body, state)| states[body as usize] = state)
            }
        }
        states
    }

    /// Kinetic and potential energy of the balls and springs \[J\]; gravity's is zero at the origin.
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
                    SpringEnd::Point(point) => point,
                    SpringEnd::Body(other) => states[other.index()].pose.position,
                };
                let stretch = far.distance(states[body.index()].pose.position) - rest_length;
                energy += 0.5 * stiffness * stretch * stretch;
            }
        }
        energy
    }

    /// Gravity [m/s²].
    pub fn gravity(&self) -> DVec3 {
        self.world.gravity
    }

    /// The links.
    pub fn links(&self) -> &[Link] {
        &self.world.links
    }

    /// Gives the centre of a ball another velocity [m/s]; its spin stays.
    ///
    /// # Errors
    /// A body that is not a free ball, a velocity that is none or beyond [`FASTEST`].
    pub fn set_velocity(&mut self, body: BodyId, velocity: DVec3) -> Result<(), LiveError> {
        check_placed(DVec3::ZERO, velocity)?;
        let known = self.body(body).ok_or(LiveError::UnknownBody { body: body.0 })?;
        if known.motion != Motion::Free {
            return Err(LiveError::NotFree { body: known.name.clone() });
        }
        if let Drive::Stepped(stepped) = &mut self.motion {
            stepped.set_velocity(body, velocity);
            return Ok(());
        }
        self.hand_over(self.solver())?;
        self.world.bodies[body.index()].velocity = velocity;
        Ok(())
    }

    /// Adds a free ball. Returns its number, which may have been that of one that was removed.
    ///
    /// # Errors
    /// Numbers out of range, a place that is taken, too many bodies.
    pub fn add(
        &mut self,
        material: &Material,
        radius: f64,
        position: DVec3,
        velocity: DVec3,
    ) -> Result<BodyId, LiveError> {
        check("the radius", radius, RADII, "from 1e-4 m to 100 m")?;
        check_placed(position, velocity)?;
        let states = self.states();
        for (other, state) in self.world.bodies.iter().zip(&states).filter(|(other, _)| is_there(other)) {
            let (gap, smaller) = match *other.surface {
                Surface::Sphere { radius: theirs } => {
                    (position.distance(state.pose.position) - radius - theirs, radius.min(theirs))
                }
                Surface::HalfSpace => (state.pose.body_from_world(position).y - radius, radius),
                Surface::Mesh(_) => continue,
            };
            if gap < -TOLERATED_OVERLAP * smaller {
                return Err(LiveError::Overlap { body: other.name.clone(), depth: -gap });
            }
        }
        let place = self.world.bodies.iter().position(|body| !is_there(body));
        let place = place.unwrap_or(self.world.bodies.len());
        if place >= MOST_BODIES {
            return Err(LiveError::Full);
        }
        if !matches!(self.motion, Drive::Stepped(_)) {
            self.hand_over(self.solver())?;
        }
        let mass = material.density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let body = Body {
            name: format!("added-{place}"),
            material: material.clone(),
            surface: Arc::new(Surface::Sphere { radius }),
            mass,
            inertia: DMat3::from_diagonal(DVec3::splat(0.4 * mass * radius * radius)),
            pose: Pose::at(position),
            velocity,
            angular_velocity: DVec3::ZERO,
            motion: Motion::Free,
            edge_radius: EDGE_RADIUS_RATIO * radius,
            life: Life::LASTING,
        };
        match self.world.bodies.get_mut(place) {
            Some(slot) => *slot = body,
            None => self.world.bodies.push(body),
        }
        let id = BodyId(place as u32);
        if let Drive::Stepped(stepped) = &mut self.motion {
            stepped.add(&self.world, id);
        }
        Ok(id)
    }

    /// Removes a ball, and the rods and springs on it.
    ///
    /// # Errors
    /// A body that is not a free ball.
    pub fn remove(&mut self, body: BodyId) -> Result<(), LiveError> {
        let known = self.body(body).ok_or(LiveError::UnknownBody { body: body.0 })?;
        if known.motion != Motion::Free {
            return Err(LiveError::NotFree { body: known.name.clone() });
        }
        match &mut self.motion {
            Drive::Stepped(stepped) => {
                self.impacts.close(&self.world.bodies, f64::INFINITY, self.origin)?;
                stepped.remove(body);
            }
            _ => self.hand_over(self.solver())?,
        }
        self.world.bodies[body.index()].life.death = f64::NEG_INFINITY;
        self.world.links.retain(|link| match *link {
            Link::Hang { body: one, .. } => one != body,
            Link::Spring { body: one, to, .. } => one != body && to != SpringEnd::Body(body),
        });
        Ok(())
    }

    /// Changes gravity [m/s²].
    ///
    /// # Errors
    /// An acceleration that is none, or beyond 1000 m/s².
    pub fn set_gravity(&mut self, gravity: DVec3) -> Result<(), LiveError> {
        check_gravity(gravity)?;
        match &mut self.motion {
            Drive::Stepped(stepped) => stepped.set_gravity(gravity),
            _ => self.hand_over(self.solver())?,
        }
        self.world.gravity = gravity;
        Ok(())
    }
}

fn state_of(body: &Body) -> BodyState {
    BodyState { pose: body.pose, velocity: body.velocity, angular_velocity: body.angular_velocity }
}

/// Whether a body has not been removed.
fn is_there(body: &Body) -> bool {
    body.life.holds(0.0)
}

fn check(what: &'static str, value: f64, within: [f64; 2], range: &'static str) -> Result<(), LiveError> {
    // Written so that NaN is refused too.
    if value >= within[0] && value <= within[1] {
        return Ok(());
    }
    Err(LiveError::BadNumber { what, value, range })
}

fn check_placed(position: DVec3, velocity: DVec3) -> Result<(), LiveError> {
    check("the distance from the origin", position.length(), [0.0, FARTHEST], "at most 1e5 m")?;
    check("the speed", velocity.length(), [0.0, FASTEST], "at most 200 m/s")
}

fn check_gravity(gravity: DVec3) -> Result<(), LiveError> {
    check("gravity", gravity.length(), [0.0, 1000.0], "at most 1000 m/s²")
}
