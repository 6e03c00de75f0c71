//! Piles: spheres and planes in steps of time, for worlds whose bodies come to rest on each other.
//!
//! A step of h seconds has three parts.
//! 1. Contacts that touch and hardly approach are solved together (`resting`): their balls move through the
//!    step at the velocities of its end. All other balls fly on their parabolas.
//! 2. Bodies that meet on these paths faster than g h collide at the instant of the meeting (`flight`), with
//!    Newton's restitution and Coulomb's friction, pair by pair in the order of time. The instants and speeds
//!    of impacts, which determine the sound, are therefore those of the exact solver as long as a ball flies.
//!    Only bounces slower than g h, which is at most half of the audible speed, are lost.
//! 3. A part of each overlap is corrected, and balls that have been at rest for a while fall asleep
//!    (`sleep`).
//!
//! Candidate pairs come from neighbour lists with a margin (`neighbours`), valid as long as no ball leaves
//! its margin.
//!
//! Differs from [`rigid`](crate::rigid), which is for all shapes: impacts occur at their own instants, and a
//! contact needs a tenth of the arithmetic, because the normal of a sphere passes through its centre. Rods
//! and springs are not supported.

mod flight;
mod neighbours;
mod resting;
mod sleep;

use clangor_core::body::{BodyId, Motion, Surface, World};
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::{DQuat, DVec3};

use super::bodies::{Bodies, Plane, Sphere};
use super::cells::Cells;
use super::pair_coefficients::PairTable;
use crate::SimulationError;
use crate::body_state::BodyState;
use crate::record::Recorder;
use flight::Flight;
use neighbours::Neighbours;
use resting::Resting;

/// Marks a partner that is a plane.
const PLANE: u32 = 1 << 31;
/// Largest fall from rest in a step, as a part of the radius; smaller balls need shorter steps.
const LONGEST_FALL: f64 = 0.002;
/// Largest travel of the balls in a step, in units of their radii.
const LONGEST_WAY: f64 = 2.0;
/// Shortest step \[s\].
const SHORTEST_STEP: f64 = 1e-4;
/// Slowest approach that is an impact under weak gravity \[m/s\].
const LEAST_APPROACH: f64 = 1e-3;

/// A ball at the beginning of a step, and its path through it.
#[derive(Clone, Debug)]
struct Ball {
    /// Centre at `since` \[m\].
    position: DVec3,
    /// Velocity at `since` \[m/s\].
    velocity: DVec3,
    /// Acceleration of the path \[m/s²\].
    acceleration: DVec3,
    /// Angular velocity \[rad/s\].
    omega: DVec3,
    orientation: DQuat,
    /// Time into the step at which the state was taken \[s\].
    since: f64,
    radius: f64,
    mass: f64,
    /// 1/m \[1/kg\]; 0 if contacts do not move it.
    inverse_mass: f64,
    inverse_inertia: f64,
    /// Index in the world's bodies.
    body: u32,
    /// Class of its material.
    material: u32,
    /// Whether it is free.
    free: bool,
    /// Whether it has not been removed.
    there: bool,
    asleep: bool,
    /// Whether it stays in place until the end of the step, after too many impacts.
    waits: bool,
    /// Time that it has waited in this step \[s\].
    waited: f64,
    /// Steps since it last moved fast.
    quiet: u32,
    /// Counts the changes of the path.
    generation: u32,
    /// Impacts in this step.
    hits: u32,
    /// Time of its last impact \[s\], and its velocities before all impacts of that instant.
    struck: f64,
    before: (DVec3, DVec3),
    /// Position at the last search for its neighbours, and allowed distance from there \[m\].
    origin: DVec3,
    margin: f64,
}

impl Ball {
    /// A ball at rest with default values at a position.
    fn untouched(position: DVec3) -> Self {
        Ball {
            position,
            velocity: DVec3::ZERO,
            acceleration: DVec3::ZERO,
            omega: DVec3::ZERO,
            orientation: DQuat::IDENTITY,
            since: 0.0,
            radius: 0.0,
            mass: 0.0,
            inverse_mass: 0.0,
            inverse_inertia: 0.0,
            body: 0,
            material: 0,
            free: false,
            there: true,
            asleep: false,
            waits: false,
            waited: 0.0,
            quiet: 0,
            generation: 0,
            hits: 0,
            struck: f64::NEG_INFINITY,
            before: (DVec3::ZERO, DVec3::ZERO),
            origin: position,
            margin: 0.0,
        }
    }

    /// A ball of a world in its initial state.
    fn from_body(world: &World, sphere: Sphere, material: u32) -> Self {
        let body = &world.bodies[sphere.body];
        let free = body.motion == Motion::Free;
        let moving = |v: DVec3| if free { v } else { DVec3::ZERO };
        Ball {
            velocity: moving(body.velocity),
            omega: moving(body.angular_velocity),
            orientation: body.pose.orientation.normalize(),
            radius: sphere.radius,
            mass: body.mass,
            inverse_mass: if free { 1.0 / body.mass } else { 0.0 },
            inverse_inertia: if free { 1.0 / body.inertia.x_axis.x } else { 0.0 },
            body: sphere.body as u32,
            material,
            free,
            ..Ball::untouched(body.pose.position)
        }
    }

    /// Centre and velocity at a time into the step.
    fn at(&self, time: f64) -> (DVec3, DVec3) {
        if self.waits {
            return (self.position, self.velocity);
        }
        let s = time - self.since;
        (
            self.position + (self.velocity + self.acceleration * (0.5 * s)) * s,
            self.velocity + self.acceleration * s,
        )
    }

    /// Whether it moves in this step.
    fn moves(&self) -> bool {
        self.free && self.there && !self.asleep
    }

    /// Constraint impulse that held a ball in place while it waited in the step that ends at `time`: the
    /// opposite of its weight.
    fn held(&self, time: f64) -> ContactRow {
        let impulse = self.acceleration * (-self.mass * self.waited);
        ContactRow {
            time,
            body_a: BodyId(self.body),
            body_b: BodyId::WORLD,
            kind: ContactKind::Constraint,
            point: self.position,
            normal: DVec3::Y,
            impulse_n: impulse.y,
            impulse_t: DVec3::new(impulse.x, 0.0, impulse.z),
            couple: DVec3::ZERO,
            velocity: self.velocity,
            depth: 0.0,
            impact_id: 0,
            effective_mass: None,
        }
    }

    /// Makes the state at a time into the step its new reference state.
    fn bring_forward(&mut self, time: f64) {
        let s = time - self.since;
        if s == 0.0 || !self.moves() {
            return;
        }
        (self.position, self.velocity) = self.at(time);
        self.since = time;
        if self.waits {
            self.waited += s;
            return;
        }
        let turn = self.omega * s;
        if turn != DVec3::ZERO {
            self.orientation = (DQuat::from_scaled_axis(turn) * self.orientation).normalize();
        }
    }
}

/// The time-stepped sphere solver.
pub(crate) struct Stepped {
    now: f64,
    longest_step: f64,
    /// The longest step for the present balls and gravity \[s\].
    usual_step: f64,
    /// Half of the audible speed \[m/s\].
    quiet_speed: f64,
    step: f64,
    gravity: DVec3,
    balls: Vec<Ball>,
    /// Ball of each body.
    ball_of: Vec<Option<u32>>,
    planes: Vec<Plane>,
    classes: PairTable,
    neighbours: Neighbours,
    resting: Resting,
    flight: Flight,
}

impl Stepped {
    /// The balls of a world at t = 0. Steps are at most `longest_step` \[s\], and so short that every
    /// approach faster than `v_min` \[m/s\] is an impact.
    pub(crate) fn new(world: &World, longest_step: f64, v_min: f64) -> Result<Self, SimulationError> {
        let mut bodies = Bodies::from_world(world)?;
        Cells::sort(world, &mut bodies.spheres);
        let Bodies { spheres, planes, pairs, classes } = bodies;
        let balls: Vec<Ball> =
            spheres.iter().map(|sphere| Ball::from_body(world, *sphere, classes[sphere.body])).collect();
        let mut ball_of = vec![None; world.bodies.len()];
        for (at, ball) in balls.iter().enumerate() {
            ball_of[ball.body as usize] = Some(at as u32);
        }
        let mut stepped = Stepped {
            now: 0.0,
            longest_step,
            usual_step: longest_step,
            quiet_speed: 0.5 * v_min,
            step: longest_step,
            gravity: world.gravity,
            balls,
            ball_of,
            planes,
            classes: pairs,
            neighbours: Neighbours::default(),
            resting: Resting::default(),
            flight: Flight::default(),
        };
        stepped.choose_step();
        Ok(stepped)
    }

    /// Chooses the step that gravity, the smallest ball and the audible speed allow.
    fn choose_step(&mut self) {
        let g = self.gravity.length();
        let there = self.balls.iter().filter(|ball| ball.there && ball.free);
        let smallest = there.map(|ball| ball.radius).fold(f64::INFINITY, f64::min);
        let step =
            self.longest_step.min((2.0 * LONGEST_FALL * smallest / g).sqrt()).min(self.quiet_speed / g);
        self.usual_step = step.max(SHORTEST_STEP);
        self.neighbours.invalidate();
    }

    /// Shortens the next step if most of the balls are fast.
    fn fit_step(&mut self) {
        let moving = self.balls.iter().filter(|ball| ball.moves());
        let (squares, radii) = moving.fold((0.0, 0.0), |(squares, radii), ball| {
            (squares + ball.velocity.length_squared(), radii + ball.radius * ball.radius)
        });
        let way = LONGEST_WAY * (radii / squares).sqrt();
        // The comparison also covers NaN, when nothing moves.
        self.step = if way < self.usual_step { way.max(SHORTEST_STEP) } else { self.usual_step };
    }

    /// Time since the beginning \[s\].
    pub(crate) fn now(&self) -> f64 {
        self.now
    }

    /// Slowest approach that is an impact \[m/s\].
    fn impact_speed(&self) -> f64 {
        (self.gravity.length() * self.step).max(LEAST_APPROACH)
    }

    /// One step. Returns what it cost, in events of the exact solver.
    pub(crate) fn step(
        &mut self,
        world: &World,
        recorder: &mut Recorder<'_>,
    ) -> Result<u64, SimulationError> {
        // Lasting contacts set the paths, then impacts are resolved on them.
        self.fit_step();
        self.refresh_neighbours();
        let sweeps = self.solve_resting(recorder)?;
        let impacts = self.resolve_impacts(recorder)?;
        // Bring all balls to the end of the step.
        let mut awake = 0;
        for ball in self.balls.iter_mut().filter(|ball| ball.moves()) {
            ball.bring_forward(self.step);
            if ball.waits && !recorder.ignores_slow_contacts() {
                recorder.contact(&[ball.held(self.now + self.step)], &[])?;
            }
            (ball.since, ball.waits, ball.waited, ball.hits) = (0.0, false, 0.0, 0);
            awake += 1;
            if !(ball.position.is_finite() && ball.velocity.is_finite() && ball.omega.is_finite()) {
                let body = world.bodies[ball.body as usize].name.clone();
                return Err(SimulationError::Diverged { body, time: self.now });
            }
        }
        // Correct positions; put quiet balls to sleep.
        self.correct_overlaps();
        self.now += self.step;
        self.fall_asleep(recorder)?;
        let pairs = (self.neighbours.pairs.len() / 64) as u64;
        Ok(1 + awake / 16 + pairs + sweeps * self.resting.contacts.len() as u64 / 64 + impacts)
    }

    /// Index in the world's bodies and present state of every ball, in the order of those indices.
    pub(crate) fn states(&self) -> impl Iterator<Item = (u32, BodyState)> {
        self.ball_of.iter().flatten().map(|&ball| {
            let ball = &self.balls[ball as usize];
            let pose = Pose { position: ball.position, orientation: ball.orientation };
            (ball.body, BodyState { pose, velocity: ball.velocity, angular_velocity: ball.omega })
        })
    }

    fn ball(&self, body: BodyId) -> Option<usize> {
        self.ball_of.get(body.index()).copied().flatten().map(|ball| ball as usize)
    }

    /// Sets the velocity of a ball \[m/s\].
    pub(crate) fn set_velocity(&mut self, body: BodyId, velocity: DVec3) {
        if let Some(ball) = self.ball(body) {
            self.wake(ball);
            self.balls[ball].velocity = velocity;
        }
    }

    /// Changes gravity \[m/s²\].
    pub(crate) fn set_gravity(&mut self, gravity: DVec3) {
        self.gravity = gravity;
        (0..self.balls.len()).for_each(|ball| self.wake(ball));
        self.choose_step();
    }

    /// Adds a ball that has been added to the world.
    pub(crate) fn add(&mut self, world: &World, body: BodyId) {
        let description = &world.bodies[body.index()];
        let Surface::Sphere { radius } = *description.surface else { return };
        let ball = Ball {
            velocity: description.velocity,
            omega: description.angular_velocity,
            orientation: description.pose.orientation,
            radius,
            mass: description.mass,
            inverse_mass: 1.0 / description.mass,
            inverse_inertia: 1.0 / description.inertia.x_axis.x,
            body: body.0,
            material: self.classes.class_of(&description.material),
            free: true,
            ..Ball::untouched(description.pose.position)
        };
        let place = self.balls.iter().position(|ball| !ball.there).unwrap_or(self.balls.len());
        match self.balls.get_mut(place) {
            Some(slot) => *slot = ball,
            None => self.balls.push(ball),
        }
        self.ball_of.resize(self.ball_of.len().max(body.index() + 1), None);
        self.ball_of[body.index()] = Some(place as u32);
        self.choose_step();
    }

    /// Removes a ball and wakes the balls that it touched.
    pub(crate) fn remove(&mut self, body: BodyId) {
        let Some(ball) = self.ball(body) else { return };
        for at in 0..self.neighbours.of(ball).len() {
            let pair = &self.neighbours.pairs[self.neighbours.of(ball)[at] as usize];
            let other = if pair.a as usize == ball { pair.b } else { pair.a };
            if other & PLANE == 0 {
                self.wake(other as usize);
            }
        }
        self.balls[ball].there = false;
        self.ball_of[body.index()] = None;
        self.choose_step();
    }

    /// State of a ball for the log, before all impacts at this time \[s\].
    fn pose_row(&mut self, ball: usize, time: f64) -> PoseRow {
        let ball = &mut self.balls[ball];
        if ball.struck != time {
            (ball.struck, ball.before) = (time, (ball.velocity, ball.omega));
        }
        let Ball { body, position, orientation, before: (velocity, angular_velocity), .. } = *ball;
        PoseRow { time, body: BodyId(body), position, orientation, velocity, angular_velocity }
    }

    fn body_of(&self, partner: u32) -> BodyId {
        if partner & PLANE == 0 {
            BodyId(self.balls[partner as usize].body)
        } else {
            BodyId(self.planes[(partner & !PLANE) as usize].body)
        }
    }
}
