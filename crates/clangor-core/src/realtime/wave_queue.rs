//! Waves of clicks that are to be computed: those that are heard first come first, and if there are too many,
//! the weakest are left out.

use glam::DVec3;

use super::schedule::Schedule;
use crate::medium::Medium;
use crate::synthesis::SoundSource;
use crate::synthesis::acceleration_pulse::AccelerationPulse;

/// What is this much weaker than the strongest wave of its block is masked by it: 80 dB.
const MASKED: f64 = 1e-4;

/// A wave of a click that runs towards a receiver.
#[derive(Clone)]
pub(super) struct QueuedWave {
    pub(super) click: AccelerationPulse,
    /// From the centre of the click \[m\].
    pub(super) towards: DVec3,
    pub(super) path: usize,
    pub(super) receiver: usize,
    /// Peak pressure \[Pa\], an estimate.
    pub(super) strength: f64,
}

/// What became of the waves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Shed {
    /// Left out though they could have been heard.
    pub(super) audible: u64,
    /// Left out under others.
    pub(super) masked: u64,
}

/// See the module.
pub(super) struct WaveQueue {
    waiting: Schedule<QueuedWave>,
    due: Vec<QueuedWave>,
    most: usize,
    pub(super) shed: Shed,
}

impl WaveQueue {
    /// Room for so many.
    pub(super) fn new(most: usize) -> Self {
        WaveQueue { waiting: Schedule::new(most), due: Vec::with_capacity(most), most, shed: Shed::default() }
    }

    /// Whether there is no room for more.
    pub(super) fn is_full(&self) -> bool {
        self.waiting.is_full()
    }

    /// Adds a wave of which the first sample is this.
    pub(super) fn add(&mut self, first: i64, wave: QueuedWave) {
        if self.waiting.add(first, wave).is_err() {
            self.shed.audible += 1;
        }
    }

    /// Plays all waves that begin before a sample, but at most `budget`, and then others as far as the budget
    /// lasts.
    pub(super) fn play(&mut self, before: i64, budget: usize, mut play: impl FnMut(&QueuedWave)) {
        self.due.clear();
        while self.due.len() < self.most
            && let Some(wave) = self.waiting.next_before(before)
        {
            self.due.push(wave);
        }
        if self.due.len() > budget {
            self.due.sort_unstable_by(|a, b| b.strength.total_cmp(&a.strength));
            let least = MASKED * self.due[0].strength;
            for wave in self.due.drain(budget..) {
                let count =
                    if wave.strength < least { &mut self.shed.masked } else { &mut self.shed.audible };
                *count += 1;
            }
        }
        self.due.iter().for_each(&mut play);
        let played = self.due.len();
        // Nothing is kept that others may want to free.
        self.due.clear();
        for _ in played..budget {
            let Some(wave) = self.waiting.next_before(i64::MAX) else { break };
            play(&wave);
        }
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }
}

/// Peak pressure \[Pa\] of a click at a distance \[m\], as of a sphere of this radius \[m\] seen along its
/// motion: an estimate for telling loud from soft.
///
/// A compact sphere that is accelerated by a half-sine, a = π Δv/(2τ), sounds as ρR³/2 (ȧ/(cr) + a/r²), and
/// none louder than one that starts in no time, ρcΔv R/r.
pub(super) fn strength(click: &AccelerationPulse, radius: f64, distance: f64, medium: &Medium) -> f64 {
    let Medium { density, sound_speed } = *medium;
    let distance = distance.max(radius);
    let turning = match click.source {
        SoundSource::Sphere { .. } => 0.0,
        _ => radius * click.angular_velocity_change.length(),
    };
    let speed = click.velocity_change.length() + turning;
    let rate = std::f64::consts::PI / click.duration;
    let acceleration = 0.5 * rate * speed;
    let compact = 0.5
        * density
        * radius.powi(3)
        * (acceleration * rate / (sound_speed * distance) + acceleration / distance.powi(2));
    compact.min(density * sound_speed * speed * radius / distance)
}
