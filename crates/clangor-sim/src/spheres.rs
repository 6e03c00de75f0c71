//! Exact event-driven spheres: motion between events in closed form, events at the roots of the gaps.
//!
//! Balls fly, slide, roll and rest on constant accelerations (`ball`, `support`); balls on rods and springs
//! follow Chebyshev series exact to rounding (`arc`). The first meeting of a ball with another or with a
//! plane is a root (`approach`, `predict`) among its neighbours (`grid`); the earliest of all (`schedule`) is
//! resolved together with everything that touches at that instant (`collide`, `impact`), and only what it
//! moved is predicted anew. A prediction carries the generation of its partner: a partner that has changed
//! its motion since voids it. There is no time step, so impact times and impulses are exact to rounding.
//!
//! Differs from HW §2.3.1: trajectories are parabolas and arcs, not straight lines within a step, and balls
//! have friction and spin.
//!
//! What ends the endless:
//! * bounces on a plane under gravity whose next flight would be shorter than `CONTACT_TIME` end in lasting
//!   contact, which slides, rolls and rests in closed form;
//! * pairs that nothing supports (a ball on a ball, a hung ball on a plane) rebound with flights of
//!   `CONTACT_TIME` while they are pressed together: no energy is gained, and they are off by
//!   g·`CONTACT_TIME`²/2 ≈ 12 nm at most;
//! * where nothing presses, inelastic collapse is cut off as in Luding and McNamara's TC model (1998): balls
//!   that have been hit `QUICK_HITS` times in quick succession lose no more energy at each other;
//! * where gravity presses, balls that are hit so often form a pile, in which approaches of up to 1 cm/s are
//!   stopped.
//!
//! Piles that rest on each other are safe but slow here (30 balls: a minute per second); the time-stepped
//! solver is for them.

mod approach;
mod arc;
mod ball;
mod collide;
mod engine;
mod grid;
mod impact;
mod log;
mod pairs;
mod predict;
mod renumber;
mod schedule;
mod setup;
mod stepped;
mod support;

use std::ops::ControlFlow;

use clangor_core::body::World;

use crate::record::Recorder;
use crate::{SimulationError, SimulationSettings};

/// Shortest flight between two impacts of bodies that are pressed together [s].
///
/// Under gravity g it stands for bounces slower than g·CONTACT_TIME/2: 0.25 mm/s on Earth, 200 times below
/// the speed that is heard ([`crate::record::RecordSettings::v_min`]).
const CONTACT_TIME: f64 = 5e-5;
/// Hits in quick succession that make a collapse or a pile.
const QUICK_HITS: u32 = 32;
/// Surfaces nearer than this touch [m]: ten thousand roundings of a position of 1 m.
const TOUCH: f64 = 1e-12;
/// Surfaces that will meet within this time are hit at the same instant [s].
const TIE: f64 = 1e-10;
/// An approach slower than this is rounding [m/s].
const QUIET_SPEED: f64 = 1e-11;
/// An acceleration smaller than this does not press bodies together [m/s²].
const QUIET_ACCELERATION: f64 = 1e-9;
/// How often impacts are closed and the caller is told the time [s].
const BEAT: f64 = 0.25e-3;

pub(crate) use engine::Engine;
pub(crate) use stepped::Stepped;

pub(crate) fn simulate(
    world: &World,
    settings: &SimulationSettings,
    recorder: &mut Recorder<'_>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(), SimulationError> {
    let mut engine = Engine::new(world, !recorder.ignores_slow_contacts())?;
    engine.check_overlaps(world)?;
    engine.begin();
    engine.run(world, settings, recorder, progress)
}
