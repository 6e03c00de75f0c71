//! The state of the exact solver, and what can be read from it at any time.

use clangor_core::body::World;
use clangor_core::pose::Pose;
use glam::DVec3;

use super::ball::{Ball, MotionPhase, Spin, Traits};
use super::cluster::Cluster;
use super::grid::{Grid, NONE, NOWHERE};
use super::island::Island;
use super::pending::Pending;
use super::press_state::{Compliance, Pressed};
use super::schedule::Schedule;
use super::setup::Start;
use super::support::Phase;
use crate::SimulationError;
use crate::body_state::BodyState;
use crate::spheres::bodies::{Plane, check_overlap};
use crate::spheres::pair_coefficients::PairTable;
use crate::spheres::tolerances::{CONTACT_TIME, TOUCH};

/// Marks a partner that is a plane.
pub(super) const PLANE: u32 = 1 << 31;
/// Marks the next step of the balls that press on each other.
pub(super) const PRESSED: u32 = u32::MAX - 2;
/// Marks a search that must be resumed.
pub(super) const SEARCH: u32 = u32::MAX - 1;

/// The next event of a ball; aligned so that it never crosses a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct Next {
    /// Time of the meeting with its partner \[s\].
    pub(super) contact: f64,
    /// Ball, or plane with [`PLANE`], or [`SEARCH`], [`PRESSED`] or [`NONE`].
    pub(super) partner: u32,
    /// Generation of the partner for which the prediction holds.
    pub(super) generation: u32,
    /// Time at which it leaves its cell \[s\].
    pub(super) crossing: f64,
    /// Time at which its phase of motion ends \[s\].
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

/// The state of a simulation.
pub(crate) struct Engine {
    /// Gravity \[m/s²\].
    pub(super) gravity: DVec3,
    /// The present time \[s\].
    pub(crate) now: f64,
    pub(super) balls: Vec<Ball>,
    pub(super) spins: Vec<Spin>,
    pub(super) traits: Vec<Traits>,
    pub(super) planes: Vec<Plane>,
    pub(super) pairs: PairTable,
    pub(super) grid: Grid,
    /// Balls too wide for the grid.
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
    pub(super) island_places: Vec<Option<(usize, usize)>>,
    /// Largest radius \[m\].
    pub(super) broadest: f64,
    /// Contact compliance of each ball [1/Pa].
    pub(super) compliances: Vec<f64>,
    /// How impacts among several balls are solved; `None` for the law of impacts alone.
    pub(super) compliance: Option<Compliance>,
    /// The balls that press on each other.
    pub(super) pressed: Pressed,
    /// Buffers of the present cluster.
    pub(super) cluster: Cluster,
    /// Impacts since the balls were last renumbered.
    pub(super) impacts: usize,
    /// Next event of each ball.
    pub(super) next: Vec<Next>,
    /// Order of the next events.
    pub(super) schedule: Schedule,
    /// Events since time last advanced.
    pub(super) stalled: u64,
    /// Body whose motion on rods or springs can no longer be followed.
    pub(super) lost: Option<u32>,
    /// Cost so far in events; impacts of large clusters count for several.
    pub(super) work: u64,
}

impl Engine {
    /// The balls of a world at t = 0, with or without a log of lasting contacts; [`Engine::begin`] starts
    /// their motion.
    pub(crate) fn new(
        world: &World,
        logs_lasting: bool,
        compliance: Option<Compliance>,
    ) -> Result<Self, SimulationError> {
        let start = Start::from_world(world)?;
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
            compliances: start.compliances,
            compliance,
            pressed: Pressed::default(),
            cluster: Cluster::default(),
            impacts: 0,
            island_places: start.island_places,
            next: vec![NEVER; count],
            schedule: Schedule::new(count),
            stalled: 0,
            lost: None,
            work: 0,
        })
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

    /// Rejects bodies that overlap by more than rounding errors.
    pub(crate) fn check_overlaps(&self, world: &World) -> Result<(), SimulationError> {
        for (i, ball) in self.balls.iter().enumerate().filter(|(i, _)| self.traits[*i].free) {
            for plane in &self.planes {
                let depth = ball.radius - (plane.normal.dot(ball.position) - plane.offset);
                check_overlap(world, self.traits[i].body, plane.body, depth, ball.radius)?;
            }
            let mut found = Ok(());
            self.for_each_near(i, |j, other| {
                let depth = ball.radius + other.radius - ball.position.distance(other.position);
                let smaller = ball.radius.min(other.radius);
                if found.is_ok() {
                    found = check_overlap(world, self.traits[i].body, self.traits[j].body, depth, smaller);
                }
            });
            found?;
        }
        Ok(())
    }

    /// Island of a ball on an arc, and its place there.
    #[inline]
    pub(super) fn island_place(&self, ball: usize) -> Option<(usize, usize)> {
        // The motion phase is in cache here; the island places of other balls need not be read.
        if self.balls[ball].motion_phase == MotionPhase::Arc { self.island_places[ball] } else { None }
    }

    /// Centre and velocity of a ball.
    pub(super) fn state(&self, ball: usize, time: f64) -> (DVec3, DVec3) {
        match self.island_place(ball) {
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

    /// Speed of the shortest bounces on a horizontal plane \[m/s\].
    pub(super) fn slow_speed(&self) -> f64 {
        0.5 * self.gravity.length() * CONTACT_TIME
    }

    /// Acceleration of a ball at the present time \[m/s²\].
    pub(super) fn acceleration(&self, ball: usize) -> DVec3 {
        match self.island_place(ball) {
            Some((island, place)) => self.islands[island].arcs[place].acceleration(self.now),
            None => self.balls[ball].acceleration,
        }
    }

    /// Whether a ball is in lasting contact with a plane.
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
