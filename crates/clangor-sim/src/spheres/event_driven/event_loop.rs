//! The event loop: lets the events of all balls happen in the order of their times.

use std::ops::ControlFlow;

use clangor_core::body::World;

use super::cluster::Participant;
use super::engine::{Engine, PLANE, PRESSED, SEARCH};
use crate::record::Recorder;
use crate::{SimulationError, SimulationSettings};

/// Interval at which ended impacts are closed and progress is reported \[s\].
const BEAT: f64 = 0.25e-3;
/// Events without any progress of time before the run is given up as diverged: this many, and
/// [`STALL_PER_BALL`] more for each ball.
const STALL: u64 = 10_000;
const STALL_PER_BALL: u64 = 100;

impl Engine {
    /// Computes the first phase of motion and the first event of every ball.
    pub(crate) fn begin(&mut self) {
        let count = self.balls.len();
        for ball in 0..count {
            if self.traits[ball].free && self.island_places[ball].is_none() {
                self.start_phase(ball, None);
            }
        }
        for island in 0..self.islands.len() {
            self.launch(island);
        }
        for ball in 0..count {
            self.predict(ball);
        }
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
            self.advance(world, stop, u64::MAX, recorder)?;
            recorder.keep_order(self.now.min(self.pressed.first_onset()))?;
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
                self.end_press(recorder)?;
                self.write_lasting(recorder)?;
                return Ok(());
            }
        }
    }

    /// Processes all events until `stop` \[s\], with a total cost of about `most` events at most; large
    /// clusters count for several. The present time becomes `stop` unless the limit was reached. Returns the
    /// cost.
    pub(crate) fn advance(
        &mut self,
        world: &World,
        stop: f64,
        most: u64,
        recorder: &mut Recorder<'_>,
    ) -> Result<u64, SimulationError> {
        let first = self.work;
        while self.work - first < most {
            if let Some(body) = self.lost {
                let body = world.bodies[body as usize].name.clone();
                return Err(SimulationError::Diverged { body, time: self.now });
            }
            let (time, ball) = self.schedule.first();
            if time > stop {
                self.now = stop;
                break;
            }
            self.stalled = if time > self.now { 0 } else { self.stalled + 1 };
            let stalls = self.stalled > STALL + STALL_PER_BALL * self.balls.len() as u64;
            if stalls || !self.balls[ball].velocity.is_finite() {
                let body = &world.bodies[self.traits[ball].body as usize];
                return Err(SimulationError::Diverged { body: body.name.clone(), time: self.now });
            }
            self.now = self.now.max(time);
            self.work += 1;
            recorder.count_event();
            self.process_event(ball, recorder)?;
        }
        Ok(self.work - first)
    }

    /// Processes the next event of a ball.
    fn process_event(&mut self, ball: usize, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let next = self.next[ball];
        if next.phase_end <= next.contact && next.phase_end <= next.crossing {
            if let Some((island, _)) = self.island_place(ball) {
                self.bring_island_forward(island);
                self.launch(island);
                self.predict_island(island);
                return Ok(());
            }
            self.bring_forward(ball);
            let ended = self.phases[ball].as_deref().and_then(|p| Some((p.reactions.first()?.ground, p.end)));
            self.start_phase(ball, ended);
            self.predict(ball);
        } else if next.crossing < next.contact {
            self.cross(ball);
        } else if next.partner == PRESSED {
            self.continue_press(recorder)?;
        } else if next.partner == SEARCH {
            self.predict(ball);
        } else if next.partner & PLANE != 0 {
            self.collide(ball, Participant::Plane((next.partner & !PLANE) as usize), recorder)?;
        } else if self.balls[next.partner as usize].generation == next.generation {
            self.collide(ball, Participant::Ball(next.partner as usize), recorder)?;
        } else {
            self.predict(ball);
        }
        Ok(())
    }
}
