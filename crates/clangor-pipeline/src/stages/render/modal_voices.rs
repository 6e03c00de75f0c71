//! The vibration of all bodies as one listener hears it, a stretch at a time.
//!
//! Every body is a voice of its own. Voices are played on all threads, and added in the order of the bodies.

use std::collections::BTreeMap;

use clangor_core::body::BodyId;
use clangor_core::contact::force_stream::StreamedForce;
use clangor_core::synthesis::SynthesisError;
use clangor_core::synthesis::modal::ModalVoice;
use rayon::prelude::*;

/// Frames that a voice plays at once.
const FRAMES: i64 = 1 << 14;

/// Forces too gentle to be impacts.
pub(super) struct Rolling {
    pub(super) forces: Vec<StreamedForce>,
    /// Of the dynamics \[s\].
    pub(super) time_step: f64,
}

/// A stretch of a voice.
struct Played {
    body: BodyId,
    /// Pressure at each receiver \[Pa\].
    channels: Vec<Vec<f64>>,
    /// ∫ p² dt over all receivers [Pa² s].
    energy: f64,
}

/// Voices in progress.
pub(super) struct ModalVoices<'a> {
    pub(super) voices: Vec<(BodyId, ModalVoice<'a>)>,
    pub(super) energies: BTreeMap<BodyId, f64>,
    pub(super) rate: f64,
    /// Signals that they add to.
    pub(super) channels: usize,
}

impl ModalVoices<'_> {
    /// Silence.
    pub(super) fn none() -> Self {
        ModalVoices { voices: Vec::new(), energies: BTreeMap::new(), rate: 1.0, channels: 0 }
    }

    /// Adds the pressure \[Pa\] of the samples from `first` on to one channel per receiver.
    pub(super) fn add(&mut self, first: i64, channels: &mut [Vec<f64>]) -> Result<(), SynthesisError> {
        let count = channels.first().map_or(0, Vec::len) as i64;
        let mut from = 0;
        while from < count {
            let length = (count - from).min(FRAMES);
            let (signals, rate) = (self.channels, self.rate);
            let played: Vec<Option<Played>> = self
                .voices
                .par_iter_mut()
                .map(|(id, voice)| {
                    let begins = voice.first_sample();
                    if begins.is_none_or(|begins| begins >= first + from + length) {
                        return Ok(None);
                    }
                    let mut own = vec![vec![0.0; length as usize]; signals];
                    voice.render_block(first + from, &mut own)?;
                    let energy = own.iter().flatten().map(|p| p * p).sum::<f64>() / rate;
                    Ok(Some(Played { body: *id, channels: own, energy }))
                })
                .collect::<Result<_, SynthesisError>>()?;
            for Played { body, channels: own, energy } in played.into_iter().flatten() {
                *self.energies.entry(body).or_default() += energy;
                for (channel, own) in channels.iter_mut().zip(own) {
                    let part = &mut channel[from as usize..(from + length) as usize];
                    part.iter_mut().zip(own).for_each(|(sum, p)| *sum += p);
                }
            }
            from += length;
        }
        Ok(())
    }

    /// ∫ p² dt [Pa² s] of each body so far, over all receivers.
    pub(super) fn energies(&self) -> &BTreeMap<BodyId, f64> {
        &self.energies
    }
}
