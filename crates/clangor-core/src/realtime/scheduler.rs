//! Takes events, orders them by time, and limits the work that impacts cause in a block.
//!
//! An event of time t acts at the sample of t + latency, the latency being a block and the look-ahead of
//! pulses and forces. Impacts act a look-ahead earlier, because their sound is computed before it is heard.

use super::budget::{Budget, Credit};
use super::engine_settings::EngineSettings;
use super::event::{Event, ImpactEvent};
use super::schedule::Schedule;
use crate::contact::ForceHistory;
use crate::synthesis::live_pulses::LOOK_AHEAD as PULSE_LOOK_AHEAD;
use crate::synthesis::modal::live_voice::LOOK_AHEAD as FORCE_LOOK_AHEAD;

/// Samples by which pulses and forces look ahead.
const LOOK_AHEAD: usize =
    if PULSE_LOOK_AHEAD > FORCE_LOOK_AHEAD { PULSE_LOOK_AHEAD } else { FORCE_LOOK_AHEAD };
/// Capacity of the schedule of events.
const MOST_WAITING: usize = 8192;
/// Events further ahead are rejected \[s\].
pub const HORIZON: f64 = 60.0;
/// Longest force history \[samples of the output\], so that its waves and forces fit the longest block.
const LONGEST_HISTORY: f64 = 3072.0;
/// Most samples of a history: the work of a spectrum is in proportion to them.
const MOST_HISTORY_SAMPLES: usize = 2048;
/// Longest delay of an impact on an object that exceeds the budget \[s\].
const LONGEST_WAIT: f64 = 0.03;

/// Counts of the scheduler.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EventCounts {
    pub(super) taken: u64,
    pub(super) refused: u64,
    pub(super) late: u64,
    pub(super) shed: u64,
    pub(super) simplified: u64,
}

/// Outcome of an event that arrives.
pub(super) enum Admission {
    /// It waits for its time.
    Scheduled,
    /// It acts at once.
    Immediate(Event),
    /// It is counted as rejected or shed; an object in it must be returned.
    Rejected(Event),
}

/// When the force of an impact begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Onset {
    /// Time of the onset at the body, on the clock of the samples \[s\].
    pub(super) time: f64,
    /// The same \[samples\].
    pub(super) sample: f64,
    /// By how much the onset is later than wanted \[s\]; negative if it is in time.
    lateness: f64,
}

/// See the module.
pub(super) struct Scheduler {
    sample_rate: f64,
    block: usize,
    budget: Budget,
    /// Sample that is rendered next.
    position: i64,
    waiting: Schedule<Event>,
    pub(super) credit: Credit,
    pub(super) counts: EventCounts,
}

impl Scheduler {
    /// An empty schedule at sample 0.
    pub(super) fn new(settings: &EngineSettings) -> Self {
        Scheduler {
            sample_rate: settings.sample_rate.as_f64(),
            block: settings.block,
            budget: settings.budget,
            position: 0,
            waiting: Schedule::new(MOST_WAITING),
            credit: Credit::of(&settings.budget),
            counts: EventCounts::default(),
        }
    }

    /// Sample that is rendered next.
    pub(super) fn position(&self) -> i64 {
        self.position
    }

    /// Time of that sample \[s\].
    pub(super) fn time(&self) -> f64 {
        self.position as f64 / self.sample_rate
    }

    /// Delay from the time of an event to its sound at a receiver that touches the body \[s\].
    pub(super) fn latency(&self) -> f64 {
        self.latency_samples() as f64 / self.sample_rate
    }

    fn latency_samples(&self) -> usize {
        self.block + LOOK_AHEAD
    }

    /// The sample at which what happens at a time \[s\] is heard.
    pub(super) fn audible_sample(&self, time: f64) -> f64 {
        (time + self.latency()) * self.sample_rate
    }

    /// Longest part of `left` samples, at most a block, that divides them about evenly: fades last as long as
    /// a part.
    pub(super) fn part_of(&self, left: usize) -> usize {
        left.div_ceil(left.div_ceil(self.block))
    }

    /// Schedules an event, or says that it acts at once or is rejected. An object put into an empty slot acts
    /// at once.
    pub(super) fn admit(&mut self, mut event: Event, is_empty: impl Fn(usize) -> bool) -> Admission {
        let time = match (&event, event.time()) {
            (_, Some(time)) => time,
            (Event::Put { slot, .. }, None) if !is_empty(*slot) => self.time(),
            _ => return Admission::Immediate(event),
        };
        let ahead = time - self.time();
        if ahead.is_nan() || ahead > HORIZON {
            self.counts.refused += 1;
            return Admission::Rejected(event);
        }
        if let Event::Impact(impact) = &mut event
            && impact.force.as_deref().is_some_and(|force| self.is_too_long(force))
        {
            impact.force = None;
            self.counts.simplified += 1;
        }
        // Impacts act before they are heard; all else acts when it is heard.
        let extra = if matches!(event, Event::Pose { .. } | Event::End { .. }) { LOOK_AHEAD } else { 0 };
        // The time of an event long past does not matter.
        let sample = (time.max(self.time() - 1.0) * self.sample_rate).floor() as i64;
        let is_put = matches!(event, Event::Put { .. });
        match self.waiting.add(sample + (self.latency_samples() + extra) as i64, event) {
            Ok(()) => {
                self.counts.taken += u64::from(!is_put);
                Admission::Scheduled
            }
            Err(event) => {
                let count = if is_put { &mut self.counts.refused } else { &mut self.counts.shed };
                *count += 1;
                Admission::Rejected(event)
            }
        }
    }

    fn is_too_long(&self, force: &ForceHistory) -> bool {
        let (begin, end) = force.extent();
        (end - begin) * self.sample_rate > LONGEST_HISTORY || force.values().len() > MOST_HISTORY_SAMPLES
    }

    /// Begins a block, whose budget adds to the credit.
    pub(super) fn begin_block(&mut self, frames: usize) -> Budget {
        self.credit.add(&self.budget, frames);
        self.budget.of(frames)
    }

    /// The next event that acts in a block up to a sample.
    pub(super) fn next_event(&mut self, end: i64) -> Option<Event> {
        // Events that begin in the next block must be known in this one.
        self.waiting.next_before(end + LOOK_AHEAD as i64)
    }

    /// The next event of all, whenever it acts.
    pub(super) fn next_of_all(&mut self) -> Option<Event> {
        self.waiting.next_before(i64::MAX)
    }

    /// Ends the block.
    pub(super) fn advance_to(&mut self, end: i64) {
        self.position = end;
    }

    /// When the force of an impact of this time \[s\] begins: as soon as possible, if it is too late.
    pub(super) fn onset(&mut self, time: f64) -> Onset {
        let wanted = time + self.latency();
        let earliest = (self.position + LOOK_AHEAD as i64) as f64 / self.sample_rate;
        // Less than a sample is rounding.
        self.counts.late += u64::from(wanted < earliest - 0.5 / self.sample_rate);
        let time = wanted.max(earliest);
        Onset { time, sample: time * self.sample_rate, lateness: earliest - wanted }
    }

    /// Delays the modal part of an impact that exceeds the budget (`may_wait`) to a later block, or leaves it
    /// out.
    pub(super) fn postpone(&mut self, impact: &ImpactEvent, onset: &Onset, may_wait: bool) {
        let modal_only = impact.clone().with_velocity_changes(glam::DVec3::ZERO, glam::DVec3::ZERO);
        let next = self.position + (self.block + LOOK_AHEAD) as i64;
        let room = self.waiting.len() < MOST_WAITING / 8;
        let waits = may_wait && room && onset.lateness < LONGEST_WAIT;
        if !waits || self.waiting.add(next, Event::Impact(modal_only)).is_err() {
            self.counts.shed += 1;
        }
    }
}
