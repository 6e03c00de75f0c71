//! Excitation of the resonators of a bank: forces to come, forces that have ended, and states of another
//! bank.

use std::sync::Arc;

use num_complex::Complex64;

use super::{CHUNK, Pulse, ResonatorBank, dot};
use crate::contact::ForceShape;
use crate::synthesis::modal::drive::ForceSamples;

impl ResonatorBank {
    /// Adds a force, limited to the band, that begins at `onset` \[samples\] and lasts `duration` \[s\];
    /// `amplitudes` has the modal impulse ∫ Q dt of each mode given.
    ///
    /// The part before the next sample is not rendered: add the force in time, see
    /// [`first_sample`](Self::first_sample).
    pub fn add_pulse(&mut self, shape: &ForceShape, onset: f64, duration: f64, amplitudes: &[f64]) {
        let mut force = ForceSamples::default();
        let first = self.shaper.pulse(shape, onset, duration, &mut force);
        self.add_force(first, Arc::new(force), amplitudes);
    }

    /// Adds a band-limited force from sample `first` on.
    pub(in crate::synthesis::modal) fn add_force(
        &mut self,
        first: i64,
        force: Arc<ForceSamples>,
        amplitudes: &[f64],
    ) {
        debug_assert_eq!(amplitudes.len(), self.given);
        let mut pulse = self.spare.pop().unwrap_or_else(|| {
            // Reserved here, so that rendering, which removes the force later, allocates nothing.
            self.spare.reserve(self.pulses.len() + 1);
            Pulse::default()
        });
        (pulse.first, pulse.force) = (first, force);
        let own = &mut pulse.amplitudes;
        own.clear();
        own.resize(self.state.re.len(), 0.0);
        for (i, voice) in self.voices.iter().enumerate() {
            own[i] = amplitudes[voice.mode];
            if own[i] != 0.0 {
                self.woken |= !self.awake[i / CHUNK];
                self.awake[i / CHUNK] = true;
            }
        }
        pulse.feeds.clear();
        pulse.feeds.extend(self.paths.iter().map(|path| [dot(&path.feed, own); 2]));
        self.pulses.push(pulse);
    }

    /// Adds the free ringing after a pulse that has ended by the next sample: no look-ahead, for real time.
    /// The response during the pulse is not rendered.
    pub fn add_past_pulse(&mut self, shape: &ForceShape, onset: f64, duration: f64, amplitudes: &[f64]) {
        let elapsed = (self.next as f64 - onset) / self.rate;
        for (i, voice) in self.voices.iter().enumerate() {
            let amplitude = amplitudes[voice.mode] * voice.gain;
            if amplitude != 0.0 {
                let ring = amplitude * (voice.pole * elapsed).exp() * shape.at_pole(voice.pole, duration);
                self.state.re[i] += ring.re;
                self.state.im[i] += ring.im;
                self.woken |= !self.awake[i / CHUNK];
                self.awake[i / CHUNK] = true;
            }
        }
    }

    /// Adds the state w of a given mode at the next sample.
    pub(in crate::synthesis::modal) fn add_ringing(&mut self, state: impl Fn(usize) -> Complex64) {
        for (i, voice) in self.voices.iter().enumerate() {
            let ring = state(voice.mode) * voice.gain;
            if ring != Complex64::ZERO {
                self.state.re[i] += ring.re;
                self.state.im[i] += ring.im;
                self.woken |= !self.awake[i / CHUNK];
                self.awake[i / CHUNK] = true;
            }
        }
    }

    /// Adds the states of a bank of the same resonators.
    pub(in crate::synthesis::modal) fn take_over(&mut self, other: &ResonatorBank) {
        let own = [&mut self.state.re, &mut self.state.im];
        for (own, other) in own.into_iter().zip([&other.state.re, &other.state.im]) {
            own.iter_mut().zip(other).for_each(|(own, other)| *own += other);
        }
        for (own, other) in self.awake.iter_mut().zip(&other.awake) {
            self.woken |= other & !*own;
            *own |= other;
        }
    }
}
