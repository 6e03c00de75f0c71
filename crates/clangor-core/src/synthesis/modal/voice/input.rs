//! Input of a voice: impacts, force streams and inherited vibration. Each is checked and kept until the block
//! that it affects.

use std::cmp::Reverse;

use super::stream::Stream;
use super::{Force, Inherited, ModalVoice};
use crate::contact::{ImpactPulse, StreamPoint, StreamedForce};
use crate::synthesis::modal::modal_state_transfer::ModalState;
use crate::synthesis::modal::resonator_bank::ResonatorBank;
use crate::synthesis::synthesis_error::SynthesisError;

impl ModalVoice<'_> {
    /// Takes the impacts on this body; others are skipped.
    ///
    /// # Errors
    /// Numbers that are not finite, impacts of a time that has been rendered.
    pub fn push_pulses(&mut self, pulses: &[ImpactPulse]) -> Result<(), SynthesisError> {
        let rate = self.settings.sample_rate.as_f64();
        for pulse in pulses {
            for points in pulse.modal_impulses_on(self.body) {
                let time = pulse.onset;
                let bad = |what, value| SynthesisError::BadPulse { what, value, body: self.body, time };
                if !time.is_finite() {
                    return Err(bad("the onset", time));
                }
                if !(pulse.duration > 0.0 && pulse.duration.is_finite()) {
                    return Err(bad("the duration", pulse.duration));
                }
                if let Some((_, impulse)) = points.iter().find(|(x, j)| !x.is_finite() || !j.is_finite()) {
                    return Err(bad("a point or an impulse", impulse.length()));
                }
                let onset = (time - self.settings.start) * rate;
                let (duration, shape) = (pulse.duration, pulse.shape.clone());
                let first = ResonatorBank::first_sample(onset, duration, &shape, self.settings.sample_rate);
                if self.begun && first < self.bank.position() {
                    return Err(SynthesisError::Late { body: self.body, time });
                }
                self.forces.push(Force { first, onset, duration, shape, points });
            }
        }
        self.forces.sort_by_key(|force| Reverse(force.first));
        Ok(())
    }

    /// Takes force streams, limited to half the rate of their time step \[s\]. With contact damping, they
    /// also damp the modes while they last. Forces on other bodies are skipped.
    ///
    /// # Errors
    /// A time step that is not positive, forces of a time that has been rendered, a second stream.
    pub fn push_stream(&mut self, forces: &[StreamedForce], time_step: f64) -> Result<(), SynthesisError> {
        let bad = |what, value, time| SynthesisError::BadPulse { what, value, body: self.body, time };
        if !(time_step > 0.0 && time_step.is_finite()) || self.stream.is_some() {
            return Err(bad("the time step of a stream", time_step, self.settings.start));
        }
        for force in forces.iter().filter(|force| force.body == self.body) {
            let StreamedForce { time, points, .. } = force;
            let good = |point: &StreamPoint| {
                point.place.is_finite() && point.impulse.is_finite() && point.normal.is_finite()
            };
            if !(time.is_finite() && points.iter().all(good)) {
                return Err(bad("a force of the stream", *time, *time));
            }
        }
        let own = forces.iter().filter(|force| force.body == self.body);
        let stream = Stream::new(own, time_step, &self.settings);
        if self.begun && stream.next().is_some_and(|first| first < self.bank.position()) {
            return Err(SynthesisError::Late { body: self.body, time: self.settings.start });
        }
        self.stream = Some(stream);
        Ok(())
    }

    /// Takes the vibration that a piece inherits at its birth.
    ///
    /// # Errors
    /// Another number of modes, numbers that are not finite, a time that has been rendered, a second time.
    pub fn inherit_state(&mut self, state: &ModalState) -> Result<(), SynthesisError> {
        let time = self.poses.life(self.body).birth;
        let bad = |what, value| SynthesisError::BadPulse { what, value, body: self.body, time };
        if state.0.len() != self.source.resonances().len() || self.inherited.is_some() {
            return Err(bad("the number of modes that are taken over", state.0.len() as f64));
        }
        if let Some(w) = state.0.iter().find(|w| !w.is_finite()) {
            return Err(bad("a vibration that is taken over", w.norm()));
        }
        if self.begun {
            return Err(SynthesisError::Late { body: self.body, time });
        }
        self.inherited =
            Some(Inherited { state: state.clone(), bank: None, sent: vec![Vec::new(); self.paths.len()] });
        Ok(())
    }
}
