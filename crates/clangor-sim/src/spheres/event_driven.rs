//! Exact event-driven motion: closed form between events, events at the roots of the gaps.
//!
//! Balls fly, slide, roll and rest at constant accelerations (`ball`, `support`). Balls on rods and springs
//! follow Chebyshev series that are exact to rounding (`arc`, `island`). The first meeting of a ball with
//! another ball or with a plane is a root ([`approach`](super::approach), `predict`), sought among its
//! neighbours (`grid`). The earliest meeting of all balls (`schedule`) is resolved together with everything
//! that touches at that instant (`collide`, [`impact`](super::impact)). Only the balls that the impact moved
//! are predicted anew. A prediction stores the generation of its partner: a later change of the partner's
//! motion invalidates it. There is no time step, so impact times and impulses are exact to rounding.
//!
//! Differs from HW §2.3.1: trajectories are parabolas and arcs, not straight lines within a step, and balls
//! have friction and spin.
//!
//! Balls that would meet others before they part move by Hertz's forces through the time of the contacts
//! (`pressed`), with balls on rods at the place of the first touch (`press_in_place`); all else collides
//! at an instant.
//!
//! Infinite sequences of events are cut off:
//! * bounces on a plane under gravity whose next flight would be shorter than `CONTACT_TIME` end in lasting
//!   contact, which slides, rolls and rests in closed form;
//! * pairs without a support (a ball on a ball, a hung ball on a plane) rebound with flights of
//!   `CONTACT_TIME` while they are pressed together; no energy is gained, and the position error is at most
//!   g·`CONTACT_TIME`²/2 ≈ 12 nm;
//! * without gravity, inelastic collapse is cut off as in the TC model of Luding and McNamara (1998): balls
//!   that have been hit `QUICK_HITS` times in quick succession lose no more energy to each other;
//! * under gravity, balls that are hit so often form a pile, in which approaches of up to 1 cm/s are stopped.
//!
//! Piles of balls that rest on each other are safe but slow here (30 balls: a minute per simulated second);
//! the time-stepped solver is meant for them.

mod arc;
mod ball;
mod cluster;
mod collide;
mod engine;
mod event_loop;
mod grid;
mod island;
mod links;
mod motion;
mod pending;
mod predict;
mod press_in_place;
mod press_laws;
mod press_log;
mod press_neighbours;
mod press_state;
mod pressed;
mod renumber;
mod samples;
mod schedule;
mod setup;
mod support;
mod track;

use std::ops::ControlFlow;

use clangor_core::body::World;

use crate::record::Recorder;
use crate::solver_choice::ContactModel;
use crate::{SimulationError, SimulationSettings};

pub(crate) use engine::Engine;
use press_state::Compliance;

/// Steps per contact time of balls that press on several others.
const STEPS: f64 = 64.0;

/// Simulates a world of spheres and planes to the end of the settings' duration.
///
/// # Errors
/// [`SimulationError`], for example for bodies of other shapes or bodies that overlap at t = 0.
pub(crate) fn simulate(
    world: &World,
    settings: &SimulationSettings,
    recorder: &mut Recorder<'_>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(), SimulationError> {
    let compliance = match settings.contact {
        ContactModel::Compliant => Some(Compliance { steps: STEPS }),
        ContactModel::Rigid => None,
    };
    let mut engine = Engine::new(world, !recorder.ignores_slow_contacts(), compliance)?;
    engine.check_overlaps(world)?;
    engine.begin();
    engine.run(world, settings, recorder, progress)
}
