//! The event loop, and the phases of motion between events.

use std::ops::ControlFlow;

use clangor_core::body::World;
use clangor_core::pose::Pose;
use glam::DVec3;

use super::arc::Island;
use super::ball::{Ball, MotionPhase, Spin, Traits};
use super::collide::Cluster;
use super::grid::{Grid, NONE, NOWHERE};
use super::log::Pending;
use super::pairs::Pairs;
use super::schedule::Schedule;
use super::setup::{self, Plane};
use super::support::{self, End, Ground, Phase};
use super::{BEAT, CONTACT_TIME, TOUCH};
use crate::live::BodyState;
use crate::record::Recorder;
use crate::{SimulationError, SimulationSettings};

/// Marks a partner that is a plane.
pub(super) const PLANE: u32 = 1 << 31;
/// Marks a search to be taken up again.
pub(super) const SEARCH: u32 = u32::MAX - 1;
/// Events without any progress of time, per ball, before the run is given up.
const STALL: u64 = 10_000;

/// What a ball will do next: never across two cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct Next {
    /// When it meets its partner [s].
    pub(super) contact: f64,
    /// Ball, or plane with [`PLANE`], or [`SEARCH`], or [`NONE`].
    pub(super) partner: u32,
    /// Generation of the partner for which this holds.
    pub(super) generation: u32,
    /// When it leaves its cell [s].
    pub(super) crossing: f64,
    /// When its phase of motion ends [s].
    pub(super) phase_end: f64,
}

/// No event at all.
pub(super) const NEVER: Next = Next {
    contact: f64::INFINITY,
    partner: NONE,
    generation: 0,
    crossing: f64::INFINITY,
    phase_end: f64::INFINITY,
};

/// Partner of an impact.
#[derive(Clone, Copy, Debug)]
pub(super) enum Partner {
    /// A ball.
    Ball(usize),
    /// A plane.
    Plane(usize),
}

/// The state of a simulation.
pub(crate) struct Engine {
    /// Gravity [m/s²].
    pub(super) gravity: DVec3,
    /// The present time [s].
    pub(crate) now: f64,
    pub(super) balls: Vec<Ball>,
    pub(super) spins: Vec<Spin>,
    pub(super) traits: Vec<Traits>,
    pub(super) planes: Vec<Plane>,
    pub(super) pairs: Pairs,
    pub(super) grid: Grid,
    pub(super) wide: Vec<u32>,
    /// The moving balls in the order of their bodies.
    pub(super) by_body: Vec<u32>,
    /// Phases of the balls in lasting contact.
    pub(super) phases: Vec<Option<Box<Phase>>>,
    /// Impulses of lasting contacts since the last sample, if they are logged.
    pub(super) pending: Option<Vec<Pending>>,
    /// Balls on rods and springs.
    pub(super) islands: Vec<Island>,
    /// Island of each ball and its place there.
    pub(super) seats: Vec<Option<(usize, usize)>>,
    /// Largest radius [m].
    pub(super) broadest: f64,
    /// Buffers of the cluster at hand.
    pub(super) cluster: Cluster,
    /// Impacts since the balls were last renumbered.
    pub(super) impacts: usize,
    /// What each ball will do next.
    pub(super) next: Vec<Next>,
    /// Which ball is first.
    pub(super) schedule: Schedule,
    /// Events since time last went on.
    stalled: u64,
    /// Events so far, those of large clusters counted by their cost.
    pub(super) work: u64,
}

impl Engine {
    /// The balls of a world in their places, with or without the impulses of lasting contacts;
    /// [`Engine::begin`] sets them in motion.
    pub(crate) fn new(world: &World, logs_lasting: bool) -> Result<Self, SimulationError> {
        let start = setup::start(world)?;
        let count = start.balls.len();
        let broadest = start.balls.iter().map(|b| b.radius).fold(0.0, f64::max);
        let mut by_body: Vec<u32> = (0..count as u32).filter(|&b| start.traits[b as usize].free).collect();
        by_body.sort_by_key(|&ball| start.traits[ball as usize].body);
        Ok(Engine {
            by_body,
            gravity: world.gravity,
            now: 0.0,
            balls: start.balls,
            spins: start.spins,
            traits: start.traits,
            planes: start.planes,
            pairs: start.pairs,
            grid: start.grid,
            wide: start.wide,
            phases: (0..count).map(|_| None).collect(),
            pending: logs_lasting.then(|| vec![Pending::default(); count]),
            islands: start.islands,
            broadest,
            cluster: Cluster::default(),
            impacts: 0,
            seats: start.seats,
            next: vec![NEVER; count],
            schedule: Schedule::new(count),
            stalled: 0,
            work: 0,
        })
    }

    /// Finds the first phase of motion and the first event of every ball.
    pub(crate) fn begin(&mut self) {
        let count = self.balls.len();
        for ball in 0..count {
            if self.traits[ball].free && self.seats[ball].is_none() {
                self.settle(ball, None);
            }
        }
        for island in 0..self.islands.len() {
            self.launch(island);
        }
        for ball in 0..count {
            self.predict(ball);
        }
    }

    /// Pairs of balls that touch.
    pub(crate) fn touching(&self) -> usize {
        let mut count = 0;
        for (i, ball) in self.balls.iter().enumerate() {
            self.for_each_near(i, |j, other| {
                let reach = ball.radius + other.radius + TOUCH;
                count +=
                    usize::from(j > i && ball.position.distance_squared(other.position) <= reach * reach);
            });
        }
        count
    }

    /// Refuses bodies that overlap by more than rounding.
    pub(crate) fn check_overlaps(&self, world: &World) -> Result<(), SimulationError> {
        for (i, ball) in self.balls.iter().enumerate().filter(|(i, _)| self.traits[*i].free) {
            for plane in &self.planes {
                let depth = ball.radius - (plane.normal.dot(ball.position) - plane.offset);
                setup::check_overlap(world, self.traits[i].body, plane.body, depth, ball.radius)?;
            }
            let mut found = Ok(());
            self.for_each_near(i, |j, other| {
                let depth = ball.radius + other.radius - ball.position.distance(other.position);
                let smaller = ball.radius.min(other.radius);
                if found.is_ok() {
                    found =
                        setup::check_overlap(world, self.traits[i].body, self.traits[j].body, depth, smaller);
                }
            });
            found?;
        }
        Ok(())
    }

    /// Runs a world to the end of the settings' duration.
    pub(super) fn run(
        mut self,
        world: &World,
        settings: &SimulationSettings,
        recorder: &mut Recorder<'_>,
        progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<(), SimulationError> {
        let pose_rate = settings.record.pose_rate;
        let sample = |k: u64, step: f64| if step > 0.0 { k as f64 * step } else { f64::INFINITY };
        let pose_time = |k: u64| if pose_rate > 0.0 { k as f64 / pose_rate } else { f64::INFINITY };
        let step = if self.pending.is_some() { settings.time_step } else { 0.0 };
        let (mut poses, mut steps, mut beats) = (0, 1, 1);
        loop {
            let (pose_at, step_at, beat_at) = (pose_time(poses), sample(steps, step), sample(beats, BEAT));
            let stop = pose_at.min(step_at).min(beat_at).min(settings.duration);
            self.pass(world, stop, u64::MAX, recorder)?;
            if stop >= pose_at {
                self.write_poses(recorder)?;
                poses += 1;
            }
            if stop >= step_at {
                self.write_lasting(recorder)?;
                steps += 1;
            }
            if stop >= beat_at {
                recorder.advance(self.now)?;
                self.renumber_if_mixed();
                if progress(self.now).is_break() {
                    return Err(SimulationError::Interrupted);
                }
                beats += 1;
            }
            if stop >= settings.duration {
                self.write_lasting(recorder)?;
                return Ok(());
            }
        }
    }

    /// Lets everything until `stop` \[s\] happen, but not much more than `most` events, of which large
    /// clusters count for several. The present time is `stop` unless they were too many. Returns their
    /// number.
    pub(crate) fn pass(
        &mut self,
        world: &World,
        stop: f64,
        most: u64,
        recorder: &mut Recorder<'_>,
    ) -> Result<u64, SimulationError> {
        let first = self.work;
        while self.work - first < most {
            let (time, ball) = self.schedule.first();
            if time > stop {
                self.now = stop;
                break;
            }
            self.stalled = if time > self.now { 0 } else { self.stalled + 1 };
            let stalls = self.stalled > STALL + 100 * self.balls.len() as u64;
            if stalls || !self.balls[ball].velocity.is_finite() {
                let body = &world.bodies[self.traits[ball].body as usize];
                return Err(SimulationError::Diverged { body: body.name.clone(), time: self.now });
            }
            self.now = self.now.max(time);
            self.work += 1;
            recorder.count_event();
            self.happen(ball, recorder)?;
        }
        Ok(self.work - first)
    }

    /// Lets the next event of a ball happen.
    fn happen(&mut self, ball: usize, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let next = self.next[ball];
        if next.phase_end <= next.contact && next.phase_end <= next.crossing {
            if let Some((island, _)) = self.seat(ball) {
                self.bring_island_forward(island);
                self.launch(island);
                self.predict_island(island);
                return Ok(());
            }
            self.bring_forward(ball);
            let ended = self.phases[ball].as_deref().and_then(|p| Some((p.reactions.first()?.ground, p.end)));
            self.settle(ball, ended);
            self.predict(ball);
        } else if next.crossing < next.contact {
            self.cross(ball);
        } else if next.partner == SEARCH {
            self.predict(ball);
        } else if next.partner & PLANE != 0 {
            self.collide(ball, Partner::Plane((next.partner & !PLANE) as usize), recorder)?;
        } else if self.balls[next.partner as usize].generation == next.generation {
            self.collide(ball, Partner::Ball(next.partner as usize), recorder)?;
        } else {
            self.predict(ball);
        }
        Ok(())
    }

    /// Takes the state of a ball at the present time as its new reference.
    pub(super) fn bring_forward(&mut self, ball: usize) {
        self.bank(ball);
        let seat = self.seat(ball);
        let record = &mut self.balls[ball];
        if record.time == self.now {
            return;
        }
        let spin = &mut self.spins[ball];
        let (position, velocity) = match seat {
            Some((island, place)) => self.islands[island].arcs[place].at(self.now),
            None => record.at(self.now),
        };
        (spin.orientation, spin.omega) = spin.after(self.now - record.time);
        (record.position, record.velocity, record.time) = (position, velocity, self.now);
    }

    /// Takes the states of the balls of an island at the present time as their new references.
    pub(super) fn bring_island_forward(&mut self, island: usize) {
        self.bank_links(island);
        for place in 0..self.islands[island].balls.len() {
            self.bring_forward(self.islands[island].balls[place]);
        }
    }

    /// Starts a new segment of the arcs of an island, whose balls have been brought forward.
    pub(super) fn launch(&mut self, island: usize) {
        let Engine { islands, balls, spins, next, now, .. } = self;
        let island = &mut islands[island];
        let (mut x, mut v): (Vec<_>, Vec<_>) =
            island.balls.iter().map(|&ball| (balls[ball].position, balls[ball].velocity)).unzip();
        island.launch(*now, &mut x, &mut v);
        for (place, &ball) in island.balls.iter().enumerate() {
            let record = &mut balls[ball];
            (record.position, record.velocity) = (x[place], v[place]);
            record.motion_phase = MotionPhase::Arc;
            record.generation = record.generation.wrapping_add(1);
            spins[ball].alpha = DVec3::ZERO;
            next[ball].phase_end = island.end();
        }
    }

    /// Searches the next events of all balls of an island anew.
    pub(super) fn predict_island(&mut self, island: usize) {
        for place in 0..self.islands[island].balls.len() {
            self.predict(self.islands[island].balls[place]);
        }
    }

    /// Island of a ball that is on its way on an arc, and its place there.
    #[inline]
    pub(super) fn seat(&self, ball: usize) -> Option<(usize, usize)> {
        // The motion_phase is at hand wherever this is asked; the seats of all others need not be read.
        if self.balls[ball].motion_phase == MotionPhase::Arc { self.seats[ball] } else { None }
    }

    /// Centre and velocity of a ball.
    pub(super) fn state(&self, ball: usize, time: f64) -> (DVec3, DVec3) {
        match self.seat(ball) {
            Some((island, place)) => self.islands[island].arcs[place].at(time),
            None => self.balls[ball].at(time),
        }
    }

    /// Index in the world's bodies and present state of every moving ball, in the order of those indices.
    pub(crate) fn states(&self) -> impl Iterator<Item = (u32, BodyState)> {
        self.by_body.iter().map(|&ball| {
            let (record, spin) = (&self.balls[ball as usize], &self.spins[ball as usize]);
            let (position, velocity) = self.state(ball as usize, self.now);
            let (orientation, angular_velocity) = spin.after(self.now - record.time);
            let pose = Pose { position, orientation };
            (self.traits[ball as usize].body, BodyState { pose, velocity, angular_velocity })
        })
    }

    /// Speed of the shortest bounces on a level plane [m/s].
    pub(super) fn slow_speed(&self) -> f64 {
        0.5 * self.gravity.length() * CONTACT_TIME
    }

    /// Acceleration of a ball at the present time [m/s²].
    pub(super) fn acceleration(&self, ball: usize) -> DVec3 {
        match self.seat(ball) {
            Some((island, place)) => self.islands[island].arcs[place].acceleration(self.now),
            None => self.balls[ball].acceleration,
        }
    }

    /// Starts a new phase of motion at the present time, from a state that has been brought forward.
    pub(super) fn settle(&mut self, ball: usize, ended: Option<(Ground, End)>) {
        let (record, spin, traits) = (&mut self.balls[ball], &mut self.spins[ball], &self.traits[ball]);
        let mut state = support::State {
            radius: record.radius,
            mass: traits.mass,
            inertia: 1.0 / traits.inverse_inertia,
            velocity: record.velocity,
            omega: spin.omega,
            gravity: self.gravity,
        };
        if let Some((ground, end)) = ended {
            support::finish(&mut state, &ground, end);
        }
        let mut grounds = Vec::new();
        for (index, plane) in self.planes.iter().enumerate() {
            let gap = plane.normal.dot(record.position) - plane.offset - record.radius;
            if gap <= TOUCH && support::in_touch(plane.normal.dot(record.velocity)) {
                let pair = self.pairs.of(traits.material, plane.material);
                grounds.push(Ground {
                    plane: index,
                    normal: plane.normal,
                    friction: pair.friction,
                    rolling_loss: pair.rolling_loss,
                });
            }
        }
        let phase = support::phase(&mut state, &grounds);
        (record.velocity, spin.omega) = (state.velocity, state.omega);
        (record.acceleration, spin.alpha) = (phase.acceleration, phase.alpha);
        record.generation = record.generation.wrapping_add(1);
        self.next[ball].phase_end = self.now + phase.duration;
        let (flew, flies) = (record.motion_phase == MotionPhase::Ballistic, phase.reactions.is_empty());
        record.motion_phase = if flies { MotionPhase::Ballistic } else { MotionPhase::Steady };
        if !(flew && flies) {
            self.phases[ball] = (!flies).then(|| Box::new(phase));
        }
    }

    /// Whether a lasting contact holds a ball on a plane.
    pub(super) fn rests_on(&self, ball: usize, plane: usize) -> bool {
        let phase = self.phases[ball].as_deref();
        phase.is_some_and(|p| p.reactions.iter().any(|r| r.ground.plane == plane))
    }

    /// Calls `act` with every other ball in the cells about a ball.
    #[inline]
    pub(super) fn for_each_near(&self, ball: usize, mut act: impl FnMut(usize, &Ball)) {
        let record = &self.balls[ball];
        if record.bucket == NOWHERE {
            for (other, near) in self.balls.iter().enumerate().filter(|(other, _)| *other != ball) {
                act(other, near);
            }
            return;
        }
        for mut other in self.grid.around(record.cell).iter() {
            while other != NONE {
                let near = &self.balls[other as usize];
                if other as usize != ball {
                    act(other as usize, near);
                }
                other = near.next;
            }
        }
        for &other in &self.wide {
            act(other as usize, &self.balls[other as usize]);
        }
    }
}
