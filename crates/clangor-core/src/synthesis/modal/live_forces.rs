//! Band-limited forces of impacts, in memory shared by the bodies of a real-time engine.

use std::sync::Arc;

use super::drive::{ForceSamples, Shaper};
use crate::contact::{ForceHistory, ForceShape};
use crate::synthesis::lowpass;
use crate::synthesis::render_settings::RenderSettings;

/// Longest force \[samples\]; longer ones are rejected.
const LONGEST_FORCE: usize = 4096;
/// Samples of a history times samples of its force that take as long to compute as the rest of an impact.
const HISTORY_WORK: usize = 100_000;

/// See the module.
pub struct LiveForces {
    shaper: Shaper,
    rate: f64,
    forces: Vec<Arc<ForceSamples>>,
    next: usize,
    /// All points of an impact and both bodies have the same force.
    last: Option<LastForce>,
}

/// The last force with a history.
struct LastForce {
    history: Arc<ForceHistory>,
    onset: f64,
    duration: f64,
    force: LiveForce,
}

/// The force of one impact of unit impulse.
#[derive(Clone, Debug)]
pub struct LiveForce {
    /// Its first sample.
    pub(super) first: i64,
    /// Its samples.
    pub(super) samples: Arc<ForceSamples>,
    /// Work of computing it, 1 for a closed profile.
    pub work: usize,
}

impl LiveForces {
    /// Memory for this number of impacts in progress.
    pub fn new(settings: &RenderSettings, impacts: usize) -> Self {
        let rate = settings.sample_rate.as_f64();
        let (low, high) = settings.band();
        let mut shaper = Shaper::new(rate, 0.5 * (low + high), lowpass::HALF_WIDTH * rate);
        shaper.reserve(LONGEST_FORCE);
        let force = || {
            Arc::new(ForceSamples {
                values: Vec::with_capacity(LONGEST_FORCE),
                terms: Vec::with_capacity(LONGEST_FORCE),
            })
        };
        LiveForces { shaper, rate, forces: (0..impacts).map(|_| force()).collect(), next: 0, last: None }
    }

    /// The force of an impact of unit impulse that begins at `onset` \[samples\] and lasts `duration` \[s\];
    /// `None` if it lasts too long or too many are in progress.
    pub fn impact(&mut self, shape: &ForceShape, onset: f64, duration: f64) -> Option<LiveForce> {
        let history = match shape {
            ForceShape::History(history) => Some(history),
            ForceShape::Profile(_) => None,
        };
        if let (Some(history), Some(last)) = (history, &self.last)
            && Arc::ptr_eq(history, &last.history)
            && (onset, duration) == (last.onset, last.duration)
        {
            return Some(LiveForce { work: 1, ..last.force.clone() });
        }
        let (begin, end) = shape.extent(duration);
        let samples = (end - begin) * self.rate + 2.0 * self.shaper.reach() as f64 + 3.0;
        if samples.is_nan() || samples > LONGEST_FORCE as f64 || !onset.is_finite() {
            return None;
        }
        // The oldest force is the most likely to have ended.
        let count = self.forces.len();
        let free = (0..count).map(|k| (self.next + k) % count).find(|at| {
            // No body uses it.
            Arc::strong_count(&self.forces[*at]) == 1
        })?;
        self.next = (free + 1) % count;
        let first = self.shaper.pulse(shape, onset, duration, Arc::get_mut(&mut self.forces[free])?);
        let work = 1 + history.map_or(0, |history| history.values().len() * samples as usize / HISTORY_WORK);
        let force = LiveForce { first, samples: Arc::clone(&self.forces[free]), work };
        if let Some(history) = history {
            let (history, force) = (Arc::clone(history), force.clone());
            self.last = Some(LastForce { history, onset, duration, force });
        }
        Some(force)
    }
}
