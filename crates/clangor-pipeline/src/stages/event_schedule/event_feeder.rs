//! Hands a score to an engine a little ahead of its time.

use std::ops::ControlFlow;

use clangor_core::body::BodyId;
use clangor_core::realtime::{Controller, Engine, Event, ImpactTarget, SendError};
use clangor_core::synthesis::Listener;

use super::{EventSchedule, Moving};

/// How far ahead events are sent \[s\]: more than devices take at once when they begin.
pub const AHEAD: f64 = 0.7;
/// Most often that ringing bodies say where they are \[Hz\].
const POSE_RATE: f64 = 60.0;
/// Poses per second of all bodies together, as many as the engine's ring takes with room for impacts.
const POSES_PER_SECOND: f64 = 4000.0;

/// A score in progress. Two clocks: that of the run, and that of the engine, which is ahead by a constant.
pub struct EventFeeder<'a> {
    score: &'a EventSchedule,
    listener: &'a Listener,
    /// What to add to a time of the run for the engine's \[s\].
    offset: f64,
    first_impact: usize,
    next_impact: usize,
    next_pose: f64,
    /// Deaths of ringing bodies, in order of time, with their slots.
    deaths: Vec<(f64, usize)>,
    next_death: usize,
}

impl<'a> EventFeeder<'a> {
    /// Begins with what happens from `from` on \[s\], which the engine is to play at its time `at` \[s\].
    pub fn new(score: &'a EventSchedule, listener: &'a Listener, from: f64, at: f64) -> Self {
        let lives = score.ringing.iter().map(|(slot, id)| (score.life(*id).death, *slot));
        let mut deaths: Vec<(f64, usize)> = lives.filter(|(death, _)| death.is_finite()).collect();
        deaths.sort_by(|a, b| a.0.total_cmp(&b.0));
        let first_impact = score.impacts.partition_point(|(_, impact)| impact.time < from);
        EventFeeder {
            score,
            listener,
            offset: at - from,
            first_impact,
            next_impact: first_impact,
            next_pose: from,
            next_death: deaths.partition_point(|(death, _)| *death < from),
            deaths,
        }
    }

    /// Sends what happens until [`AHEAD`] after `now` \[s of the engine\], and where the listener is now.
    ///
    /// # Errors
    /// [`SendError::Gone`]; events for which there is no room are counted by the engine.
    pub fn feed(&mut self, controller: &mut Controller, now: f64) -> Result<(), SendError> {
        let run_now = now - self.offset;
        let until = run_now + AHEAD;
        let ear = |receiver: usize| {
            self.listener.receiver_position(receiver.min(self.listener.receivers.len() - 1), run_now)
        };
        taken(controller.send(Event::Receivers([ear(0), ear(1)])))?;
        let rate = POSE_RATE.min(POSES_PER_SECOND / self.score.ringing.len().max(1) as f64);
        while self.next_pose < until {
            let time = self.next_pose;
            for (slot, id) in &self.score.ringing {
                if !self.score.life(*id).holds(time) {
                    continue;
                }
                taken(controller.send(self.pose(*slot, *id, time)))?;
            }
            self.next_pose += 1.0 / rate;
        }
        while let Some((id, impact)) =
            self.score.impacts.get(self.next_impact).filter(|(_, b)| b.time < until)
        {
            let mut impact = impact.clone();
            // It moves otherwise from now on.
            if let ImpactTarget::Object { slot } = impact.target {
                taken(controller.send(self.pose(slot, *id, impact.time)))?;
            }
            impact.time += self.offset;
            taken(controller.send(Event::Impact(impact)))?;
            self.next_impact += 1;
        }
        while let Some((time, slot)) = self.deaths.get(self.next_death).filter(|(time, _)| *time < until) {
            taken(controller.send(Event::End { slot: *slot, time: time + self.offset }))?;
            self.next_death += 1;
        }
        Ok(())
    }

    fn pose(&self, slot: usize, id: BodyId, time: f64) -> Event {
        let Moving { pose, velocity, angular_velocity } = self.score.moving(id, time);
        Event::Pose { slot, time: time + self.offset, pose, velocity, angular_velocity }
    }

    /// Impacts sent so far.
    pub fn impacts(&self) -> usize {
        self.next_impact - self.first_impact
    }
}

/// What the engine has no room for it counts itself.
fn taken(sent: Result<(), SendError>) -> Result<(), SendError> {
    match sent {
        Err(SendError::Full) => Ok(()),
        sent => sent,
    }
}

/// Frames rendered at once where nobody listens.
const BLOCK: usize = 1024;

/// Plays a part of a run \[s\] as fast as can be. Returns the loudest pressure \[Pa\], or nothing if
/// `progress`, which receives the time in the run, breaks. The engine is silent afterwards.
pub fn measure_peak(
    score: &EventSchedule,
    listener: &Listener,
    (from, to): (f64, f64),
    (controller, engine): (&mut Controller, &mut Engine),
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Option<f64> {
    let begin = engine.time();
    let mut feed = EventFeeder::new(score, listener, from, begin);
    let end = begin + (to - from) + engine.latency();
    let mut peak = 0.0_f64;
    while engine.time() < end {
        feed.feed(controller, engine.time()).ok()?;
        peak = engine.render(BLOCK).iter().flatten().fold(peak, |peak, p| peak.max(p.abs()));
        if progress(from + engine.time() - begin).is_break() {
            return None;
        }
    }
    controller.send(Event::Silence).ok()?;
    // It takes a millisecond to fall silent, and events to come are forgotten.
    engine.render(BLOCK);
    Some(peak)
}
