//! Waves of acceleration pulses to be computed, in the order of their arrival. Beyond the budget of a block,
//! the weakest are left out.

use glam::DVec3;

use super::schedule::Schedule;
use crate::contact::ForceShape;
use crate::medium::Medium;
use crate::synthesis::SoundSource;
use crate::synthesis::acceleration_pulse::AccelerationPulse;

/// A wave this much weaker than the strongest wave of its block is masked by it: 80 dB.
const MASKED: f64 = 1e-4;

/// A wave of an acceleration pulse to a receiver.
#[derive(Clone)]
pub(super) struct QueuedWave {
    pub(super) pulse: AccelerationPulse,
    /// From the centre of the body \[m\].
    pub(super) towards: DVec3,
    pub(super) path: usize,
    pub(super) receiver: usize,
    /// Peak pressure \[Pa\], an estimate.
    pub(super) strength: f64,
}

/// Waves left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Shed {
    /// By the budget, though audible.
    pub(super) audible: u64,
    /// Masked by others.
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
    /// An empty queue of this capacity.
    pub(super) fn new(most: usize) -> Self {
        WaveQueue { waiting: Schedule::new(most), due: Vec::with_capacity(most), most, shed: Shed::default() }
    }

    /// Whether it is full.
    pub(super) fn is_full(&self) -> bool {
        self.waiting.is_full()
    }

    /// Adds a wave that begins at a sample.
    pub(super) fn add(&mut self, first: i64, wave: QueuedWave) {
        if self.waiting.add(first, wave).is_err() {
            self.shed.audible += 1;
        }
    }

    /// Plays the waves that begin before a sample, at most `budget` of them, and then later ones as long as
    /// the budget lasts. Returns how many it played.
    pub(super) fn play(&mut self, before: i64, budget: usize, mut play: impl FnMut(&QueuedWave)) -> usize {
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
        let mut played = self.due.len();
        // Sources must not be kept: their owners free them.
        self.due.clear();
        while played < budget
            && let Some(wave) = self.waiting.next_before(i64::MAX)
        {
            play(&wave);
            played += 1;
        }
        played
    }

    /// Drops all waves.
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }
}

/// Estimate of the peak pressure \[Pa\] of an acceleration pulse at a distance \[m\]: that of a sphere of
/// this radius \[m\] on the axis of its motion, with the [`rate`] π/τ \[1/s\] of its force.
///
/// A compact sphere accelerated by a half-sine, a = π Δv/(2τ), radiates ρR³/2 (ȧ/(cr) + a/r²), and at most
/// the pressure of an instantaneous start, ρcΔv R/r.
pub(super) fn strength(
    pulse: &AccelerationPulse,
    rate: f64,
    radius: f64,
    distance: f64,
    medium: &Medium,
) -> f64 {
    let Medium { density, sound_speed } = *medium;
    let distance = distance.max(radius);
    let turning = match pulse.source {
        SoundSource::Sphere { .. } => 0.0,
        _ => radius * pulse.angular_velocity_change.length(),
    };
    let speed = pulse.velocity_change.length() + turning;
    let acceleration = 0.5 * rate * speed;
    let compact = 0.5
        * density
        * radius.powi(3)
        * (acceleration * rate / (sound_speed * distance) + acceleration / distance.powi(2));
    compact.min(density * sound_speed * speed * radius / distance)
}

/// π/τ \[1/s\] of the half-sine that has the same peak as a force.
pub(super) fn rate(shape: &ForceShape, duration: f64) -> f64 {
    match shape {
        ForceShape::Profile(_) => std::f64::consts::PI / duration,
        ForceShape::History(history) => 2.0 * history.values().iter().copied().fold(0.0, f64::max),
    }
}
