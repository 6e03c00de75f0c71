//! Modal voice: the modal sound of one body at the receivers of a listener.
//!
//! The modes are computed on the grid of emission samples, in blocks of about 4 ms. At each end of a block,
//! the place of every receiver in the frame of the body gives the transfers, which are linear in time in
//! between. Where the direction turns fast for the highest order, a block has up to 32 parts. Modes that have
//! decayed are not computed. A varying delay carries the emitted sound to the receiver.
//!
//! A body that dies is no longer driven, and its emission fades within 1 ms as ½ (1 + cos), because a step
//! would click. Its pieces inherit the vibration and rise by the complement
//! ([`modal_state_transfer`](super::modal_state_transfer)); until then, it is in a separate bank. Emitted
//! sound still arrives.

mod input;
mod stream;

use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use self::stream::Stream;
use super::delay::{DelayLine, HALF_TAPS};
use super::source::{ModalSource, StrikeMemory};
use super::transfer::TransferMemory;
use crate::acoustics::Acoustics;
use crate::body::{BodyId, Life};
use crate::contact::{ForceShape, PoseHistory};
use crate::propagation::PropagationPaths;
use crate::synthesis::listener::Listener;
use crate::synthesis::modal::modal_state_transfer::ModalState;
use crate::synthesis::modal::resonator_bank::ResonatorBank;
use crate::synthesis::{RenderSettings, SynthesisError};

/// Points within a block at which delays are computed.
const DELAYS: i64 = 4;
/// Largest number of parts of a block, between which transfers are computed.
const MAX_PARTS: usize = 32;
/// Largest change of order × direction between two transfers [rad].
const TURN: f64 = 0.25;

/// Duration of the fade after the death of a body \[s\].
pub const FADE: f64 = 1e-3;
/// Largest growth back to the beginning of its block, in e-folds, of an inherited mode. Faster modes have
/// decayed and are left out.
const MOST_GROWTH: f64 = 30.0;

/// See the module.
pub struct ModalVoice<'a> {
    source: Arc<ModalSource>,
    body: BodyId,
    poses: &'a PoseHistory,
    listener: &'a Listener,
    settings: RenderSettings,
    bank: ResonatorBank,
    /// By first sample, the next one last.
    forces: Vec<Force>,
    stream: Option<Stream>,
    inherited: Option<Inherited>,
    propagation: Arc<PropagationPaths>,
    paths: Vec<Path>,
    /// Signal emitted along each path.
    sent: Vec<Vec<f64>>,
    /// Birth and death of the body \[samples\].
    life: [f64; 2],
    /// Length of a block \[samples\].
    block: i64,
    /// Whether any sound has been emitted.
    begun: bool,
    /// First sample at which the next block can arrive.
    heard: i64,
    /// Factor of the walls and attenuation in air [1/m] of each mode, for each path; empty for a path without
    /// losses.
    losses: Vec<Vec<(f64, f64)>>,
    memory: Memory,
}

/// An impact to come.
#[derive(Clone, Debug, PartialEq)]
struct Force {
    /// First sample that it affects \[samples\].
    first: i64,
    /// Onset \[samples\].
    onset: f64,
    duration: f64,
    shape: ForceShape,
    /// Places \[m\] and impulses [N s], frame of the body.
    points: Vec<(DVec3, DVec3)>,
}

/// Vibration that a piece inherits from the broken body.
struct Inherited {
    /// State at the birth.
    state: ModalState,
    /// Bank in which it rings until it has risen.
    bank: Option<ResonatorBank>,
    /// Signal emitted by it along each path.
    sent: Vec<Vec<f64>>,
}

/// Propagation from the body to a receiver.
#[derive(Clone, Debug, Default)]
struct Path {
    receiver: usize,
    /// Index among the propagation paths.
    index: usize,
    line: DelayLine,
    /// Place of the receiver for which the transfers are [m, frame of the body]; `None` without a path to it.
    place: Option<DVec3>,
    /// Whether the transfers have been set since modes at rest woke.
    set: bool,
    /// Whether they have been set since the damping changed.
    fresh: bool,
}

#[derive(Clone, Debug, Default)]
struct Memory {
    amplitudes: Vec<f64>,
    striking: StrikeMemory,
    transfers: Vec<Complex64>,
    evaluation: TransferMemory,
}

/// The resonators of a body, at rest.
fn new_bank(source: &ModalSource, paths: usize, settings: &RenderSettings) -> ResonatorBank {
    let (low, high) = settings.band();
    ResonatorBank::new(
        source.resonances(),
        paths,
        settings.sample_rate,
        0.5 * (low + high),
        source.pressure(),
    )
}

/// The bank of a voice, and that of its inherited vibration.
fn both<'b>(
    bank: &'b mut ResonatorBank,
    inherited: &'b mut Option<Inherited>,
) -> impl Iterator<Item = &'b mut ResonatorBank> {
    std::iter::once(bank).chain(inherited.as_mut().and_then(|inherited| inherited.bank.as_mut()))
}

/// Gain of a fade of `length` \[samples\], at this number of samples after its beginning.
fn faded(since: f64, length: f64) -> f64 {
    0.5 * (1.0 + (std::f64::consts::PI * (since / length).clamp(0.0, 1.0)).cos())
}

impl<'a> ModalVoice<'a> {
    /// A body at rest, heard by all paths of the acoustics, late reverberation apart.
    ///
    /// # Errors
    /// A listener without receivers, invalid settings.
    pub fn new(
        source: Arc<ModalSource>,
        body: BodyId,
        poses: &'a PoseHistory,
        listener: &'a Listener,
        settings: &RenderSettings,
    ) -> Result<Self, SynthesisError> {
        let paths = Arc::new(settings.acoustics.paths().heard());
        ModalVoice::along(source, body, poses, listener, settings, paths)
    }

    /// A body at rest, heard by these paths.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn along(
        source: Arc<ModalSource>,
        body: BodyId,
        poses: &'a PoseHistory,
        listener: &'a Listener,
        settings: &RenderSettings,
        propagation: Arc<PropagationPaths>,
    ) -> Result<Self, SynthesisError> {
        settings.check()?;
        if listener.receivers.is_empty() {
            return Err(SynthesisError::NoReceivers { listener: listener.name.clone() });
        }
        let paths: Vec<Path> = (0..listener.receivers.len())
            .flat_map(|receiver| (0..propagation.count()).map(move |index| (receiver, index)))
            .map(|(receiver, index)| Path { receiver, index, ..Path::default() })
            .collect();
        let rate = settings.sample_rate.as_f64();
        let bank = new_bank(&source, paths.len(), settings);
        let Life { birth, death, .. } = poses.life(body);
        let modes = source.resonances();
        let losses = propagation.losses().map(|loss| match loss.is_none() {
            true => Vec::new(),
            false => modes.iter().map(|mode| loss.at(mode.frequency)).collect(),
        });
        let losses = losses.collect();
        Ok(ModalVoice {
            life: [birth, death].map(|time| (time - settings.start) * rate),
            source,
            body,
            poses,
            listener,
            settings: *settings,
            bank,
            forces: Vec::new(),
            stream: None,
            inherited: None,
            sent: vec![Vec::new(); paths.len()],
            propagation,
            paths,
            block: DELAYS * (rate / 1000.0).round() as i64,
            begun: false,
            heard: i64::MIN,
            losses,
            memory: Memory::default(),
        })
    }

    /// First sample affected by a force to come, or by inherited vibration that is still rising.
    fn next_force(&self) -> Option<i64> {
        let streamed = self.stream.as_ref().and_then(Stream::next);
        let inherited = self.inherited.as_ref().map(|_| self.life[0].floor() as i64);
        self.forces.last().map(|force| force.first).into_iter().chain(streamed).chain(inherited).min()
    }

    /// A sample before which the impacts pushed so far make no sound; `None` if nothing is to come.
    pub fn first_sample(&self) -> Option<i64> {
        let first = if self.begun { self.bank.position() } else { self.next_force()? };
        (!self.is_finished()).then_some(first - HALF_TAPS as i64)
    }

    /// Whether only silence remains, unless more impacts are pushed.
    pub fn is_finished(&self) -> bool {
        self.next_force().is_none()
            && self.bank.is_silent()
            && (!self.begun || self.sent.iter().flatten().all(|pressure| *pressure == 0.0))
    }

    /// Adds the pressure \[Pa\] of the samples from `first_sample` on to one channel per receiver. All
    /// channels have the same length.
    ///
    /// # Errors
    /// A receiver below the rigid floor.
    pub fn render_block(
        &mut self,
        first_sample: i64,
        channels: &mut [Vec<f64>],
    ) -> Result<(), SynthesisError> {
        let count = channels.iter().map(Vec::len).min().unwrap_or(0);
        let last = first_sample + count as i64 - 1;
        if count == 0 || self.is_finished() {
            return Ok(());
        }
        if !self.begun {
            // Sound arrives after its emission.
            let Some(first) = self.next_force().filter(|first| *first <= last) else { return Ok(()) };
            let start = first.div_euclid(self.block) * self.block;
            self.begin(start)?;
        }
        while !self.paths.iter().all(|path| path.line.covers(last, self.bank.position())) {
            self.send_block()?;
        }
        if first_sample != self.heard {
            self.paths.iter_mut().for_each(|path| path.line.forget_place());
        }
        for (path, sent) in self.paths.iter_mut().zip(&mut self.sent) {
            let channel = self.propagation.channel(path.index, path.receiver);
            let channel = &mut channels[channel][..count];
            path.line.listen(sent, first_sample, channel);
            path.line.trim(sent);
        }
        self.heard = first_sample + count as i64;
        Ok(())
    }

    /// Emits from sample `start` on.
    fn begin(&mut self, start: i64) -> Result<(), SynthesisError> {
        self.begun = true;
        self.bank.seek(start);
        let spacing = self.block / DELAYS;
        let first = start / spacing - 1;
        for p in 0..self.paths.len() {
            self.paths[p].line = DelayLine::new(start, spacing, first);
            for i in first..first + 1 + 3 {
                let delay = self.delay(p, i * spacing)?;
                self.paths[p].line.push_delay(delay);
            }
        }
        Ok(())
    }

    /// Emits one block.
    fn send_block(&mut self) -> Result<(), SynthesisError> {
        let start = self.bank.position();
        let end = start + self.block;
        while let Some(force) = self.forces.pop_if(|force| force.first < end) {
            let Memory { amplitudes, striking, .. } = &mut self.memory;
            self.source.amplitudes(&force.points, striking, amplitudes);
            self.bank.add_pulse(&force.shape, force.onset, force.duration, &self.memory.amplitudes);
        }
        if let Some(stream) = &mut self.stream
            && stream.take(end, self.block, &self.source, &mut self.bank)
        {
            // The pressure of a mode depends on its pole.
            self.paths.iter_mut().for_each(|path| path.fresh = false);
        }
        self.begin_inherited(start, end);
        if self.bank.take_woken() {
            // Modes at rest have no transfers.
            self.paths.iter_mut().for_each(|path| path.set = false);
        }
        let spacing = self.block / DELAYS;
        for p in 0..self.paths.len() {
            for i in 1..=DELAYS {
                // Two ahead of the block, for the slopes at its end.
                let delay = self.delay(p, start + (i + 2) * spacing)?;
                self.paths[p].line.push_delay(delay);
            }
        }
        let rising = self.inherited.as_ref().is_some_and(|inherited| inherited.bank.is_some());
        if self.bank.is_silent() && !rising {
            for sent in &mut self.sent {
                sent.resize(sent.len() + self.block as usize, 0.0);
            }
            self.bank.seek(end);
            return Ok(());
        }
        self.set_transfers(start)?;
        let parts = self.parts(end)?;
        for part in 1..=parts {
            let next = start + self.block * part as i64 / parts as i64;
            self.set_transfers(next)?;
            let count = (next - self.bank.position()) as usize;
            self.bank.render(count, &mut self.sent);
            if let Some(Inherited { bank: Some(bank), sent, .. }) = &mut self.inherited {
                bank.render(count, sent);
            }
        }
        self.raise(start, end);
        self.fade(start, end);
        Ok(())
    }

    /// Starts inherited vibration that acts before `end`.
    fn begin_inherited(&mut self, start: i64, end: i64) {
        let Some(inherited) = &mut self.inherited else { return };
        if inherited.bank.is_some() || self.life[0] >= end as f64 {
            return;
        }
        let mut bank = new_bank(&self.source, self.paths.len(), &self.settings);
        bank.seek(start);
        // As if it had rung from the beginning of the block; the part before the birth is not received.
        let since = (start as f64 - self.life[0]) / self.settings.sample_rate.as_f64();
        let begun = inherited.state.later_within(&self.source, since, MOST_GROWTH);
        bank.add_ringing(|mode| begun.0[mode]);
        inherited.bank = Some(bank);
        self.paths.iter_mut().for_each(|path| path.set = false);
    }

    /// Adds the inherited vibration to the emission from `start` to `end`, and to the bank once it has risen.
    fn raise(&mut self, start: i64, end: i64) {
        let Some(Inherited { bank: Some(bank), sent: inherited, .. }) = &mut self.inherited else { return };
        let length = FADE * self.settings.sample_rate.as_f64();
        let birth = self.life[0];
        for (sent, inherited) in self.sent.iter_mut().zip(inherited) {
            let first = sent.len() - (end - start) as usize;
            for ((pressure, own), sample) in sent[first..].iter_mut().zip(inherited.drain(..)).zip(start..) {
                *pressure += own * (1.0 - faded(sample as f64 - birth, length));
            }
        }
        if end as f64 >= birth + length {
            self.bank.take_over(bank);
            self.inherited = None;
        }
    }

    /// Fades the emission from `start` to `end` if the body is dead by then; ends it after the fade.
    fn fade(&mut self, start: i64, end: i64) {
        let length = FADE * self.settings.sample_rate.as_f64();
        let death = self.life[1];
        if (end as f64) <= death {
            return;
        }
        let gain = |sample: i64| faded(sample as f64 - death, length);
        for sent in &mut self.sent {
            let first = sent.len() - (end - start) as usize;
            sent[first..].iter_mut().zip(start..).for_each(|(pressure, sample)| *pressure *= gain(sample));
        }
        if end as f64 >= death + length {
            self.bank.silence();
            self.forces.clear();
            self.stream = None;
            self.inherited = None;
        }
    }

    /// Number of parts for a block that ends at `end`.
    fn parts(&mut self, end: i64) -> Result<usize, SynthesisError> {
        let mut largest: f64 = 0.0;
        for p in 0..self.paths.len() {
            let then = self.towards(p, end)?.1;
            if let (Some(now), Some(then)) = (self.paths[p].place, then) {
                let size = now.length().min(then.length());
                // The angle, and the relative change of distance.
                largest = largest.max((now - then).length() / size.max(1e-3 * self.source.radius()));
            }
        }
        let turn = largest * (self.source.max_order() + 1) as f64;
        Ok(((turn / TURN).ceil() as usize).clamp(1, MAX_PARTS))
    }

    /// Sets the transfers of all paths at a sample.
    fn set_transfers(&mut self, sample: i64) -> Result<(), SynthesisError> {
        let mut jumped = false;
        for p in 0..self.paths.len() {
            // Paths whose receiver has not moved in the frame of the body keep their transfers.
            let place = self.towards(p, sample)?.1;
            let path = &mut self.paths[p];
            if path.set && path.fresh && path.place == place {
                continue;
            }
            jumped |= !path.set;
            (path.place, path.set, path.fresh) = (place, true, true);
            let Memory { transfers, evaluation, .. } = &mut self.memory;
            match place {
                Some(place) => {
                    let inherited = self.inherited.as_ref().and_then(|inherited| inherited.bank.as_ref());
                    let banks = [Some(&self.bank), inherited];
                    let rings = |mode: usize| banks.iter().flatten().any(|bank| bank.rings(mode));
                    // Transfers of the modes that ring, with the losses of the path.
                    self.source.transfers_of(place, rings, evaluation, transfers);
                    let (loss, distance) = (self.propagation.loss(path.index), place.length());
                    transfers
                        .iter_mut()
                        .zip(&self.losses[path.index])
                        .for_each(|(transfer, mode)| *transfer *= loss.gain(*mode, distance));
                }
                None => {
                    transfers.clear();
                    transfers.resize(self.source.resonances().len(), Complex64::ZERO);
                }
            }
            for bank in both(&mut self.bank, &mut self.inherited) {
                bank.set_transfers(p, transfers);
            }
        }
        // Transfers set for the first time apply at once.
        if jumped {
            both(&mut self.bank, &mut self.inherited).for_each(ResonatorBank::jump_to_transfers);
        }
        Ok(())
    }

    /// Propagation delay of the emission at a sample \[samples\].
    fn delay(&self, path: usize, sample: i64) -> Result<f64, SynthesisError> {
        Ok(self.towards(path, sample)?.0 * self.settings.sample_rate.as_f64())
    }

    /// Propagation time of the emission from the centre of mass at a sample \[s\], and the place of the
    /// receiver at its arrival [m, frame of the body]; none where the path does not lead.
    fn towards(&self, path: usize, sample: i64) -> Result<(f64, Option<DVec3>), SynthesisError> {
        let RenderSettings { acoustics: Acoustics { medium, floor, .. }, start, sample_rate, .. } =
            &self.settings;
        let Path { receiver, index, .. } = self.paths[path];
        let time = start + sample as f64 / sample_rate.as_f64();
        let pose = self.poses.at(self.body, time);
        let from = (self.propagation.image(index).image(pose.position), 0.0);
        let (heard, position) = self.listener.arrival(receiver, from, time, medium.sound_speed);
        floor.check(self.listener, position, heard)?;
        let towards = self.propagation.towards(index, pose.position, position);
        Ok((heard - time, towards.map(|towards| pose.orientation.inverse() * towards)))
    }
}
