//! Modal sound of one body in real time: its modes, excited by impacts, and a delay line for each path and
//! receiver.
//!
//! The same resonators, forces and transfers as in [`voice`](super::voice), in blocks of any length. After
//! [`LiveVoice::new`] nothing is allocated. The body emits [`AHEAD`] samples before its sound can first be
//! heard, so that an impact must be known [`LOOK_AHEAD`] samples before it begins.
//!
//! The caller sets the pose at any time; in between, it continues with its velocity. Transfers follow the
//! pose when the caller allows it, from the end of one block to the next. Modes that start to vibrate get
//! their transfers at once.
//!
//! Differs from the offline voice: no force streams, no inherited vibration, delays linear in time within a
//! block, and a sinc of 16 samples between samples (error 3e-4 below a third of the sample rate).

use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex64;

use super::live_delay::{self, HALF_TAPS, LiveDelay};
use super::live_forces::LiveForce;
use super::live_pose::LivePose;
use super::live_trail::LiveTrail;
use super::source::{ModalSource, StrikeMemory};
use super::transfer::TransferMemory;
use crate::pose::Pose;
use crate::propagation::PropagationPaths;
use crate::synthesis::lowpass::REACH;
use crate::synthesis::modal::resonator_bank::ResonatorBank;
use crate::synthesis::render_settings::RenderSettings;

/// Samples by which a body emits ahead of the receivers.
pub const AHEAD: usize = HALF_TAPS;
/// Samples before its onset at which an impact must be known.
pub const LOOK_AHEAD: usize = AHEAD + REACH + 1;

/// Change of direction, times the order of the transfer, at which transfers are evaluated again [rad].
const TURN: f64 = 0.01;
/// Number of modes with the same cost as the delay line of a path.
const LISTENING: usize = 8;
/// Forces in progress on one body; more are rejected.
const MOST_FORCES: usize = 64;

/// Modal sound of a body: see the module.
pub struct LiveVoice {
    source: Arc<ModalSource>,
    bank: ResonatorBank,
    pose: LivePose,
    /// Whether the pose has been set from outside.
    posed: bool,
    trail: LiveTrail,
    rate: f64,
    sound_speed: f64,
    /// For each receiver all paths.
    paths: Vec<Path>,
    path_count: usize,
    /// Factor of the walls and attenuation in air [1/m] of each mode, for each path; empty for a path without
    /// losses.
    losses: Vec<Vec<(f64, f64)>>,
    /// Samples emitted along each path in a block.
    sent: Vec<Vec<f64>>,
    /// Samples received along one path in a block.
    heard: Vec<f32>,
    /// Samples since the last vibration.
    quiet: usize,
    /// Samples after which everything emitted has been received.
    longest: usize,
    ending: bool,
    /// Mean square of the emission to the first receiver in the last block \[Pa²\].
    loudness: f64,
    amplitudes: Vec<f64>,
    striking: StrikeMemory,
    transfers: Vec<Complex64>,
    evaluation: TransferMemory,
}

#[derive(Clone, Debug)]
struct Path {
    line: LiveDelay,
    /// Place of the receiver for which the transfers are [m, frame of the body]; `None` where the path does
    /// not lead.
    place: Option<DVec3>,
    /// Whether the transfers have been set.
    set: bool,
}

/// A block to be rendered.
#[derive(Clone, Copy)]
pub struct LiveBlock<'a> {
    /// Its first sample.
    pub position: i64,
    /// Its length \[samples\].
    pub frames: usize,
    /// Paths to each receiver.
    pub propagation: &'a PropagationPaths,
    /// Positions of the receivers at its end [m, world].
    pub receivers: &'a [DVec3],
}

impl LiveBlock<'_> {
    /// The sample after the last.
    fn end(&self) -> i64 {
        self.position + self.frames as i64
    }
}

/// Signals that a block is added to.
pub struct LiveOutputs<'a> {
    /// Pressure \[Pa\] at each receiver.
    pub channels: &'a mut [Vec<f64>],
    /// Signal of each input of the late reverberation \[Pa m\].
    pub entering: &'a mut [Vec<f64>],
}

impl LiveVoice {
    /// A body at rest, for so many receivers, each with these paths of up to `seconds`, in blocks of up to
    /// `block` samples.
    pub fn new(
        source: Arc<ModalSource>,
        settings: &RenderSettings,
        propagation: &PropagationPaths,
        receivers: usize,
        block: usize,
        seconds: f64,
    ) -> Self {
        live_delay::warm();
        let rate = settings.sample_rate.as_f64();
        let (low, high) = settings.band();
        let paths = receivers * propagation.count();
        let centre = 0.5 * (low + high);
        let mut bank =
            ResonatorBank::new(source.resonances(), paths, settings.sample_rate, centre, source.pressure());
        bank.reserve(MOST_FORCES);
        let longest = (seconds * rate) as usize;
        let path = Path { line: LiveDelay::new(longest, block), place: None, set: false };
        let modes = source.resonances();
        let losses = propagation.losses().map(|loss| match loss.is_none() {
            true => Vec::new(),
            false => modes.iter().map(|mode| loss.at(mode.frequency)).collect(),
        });
        let mut voice = LiveVoice {
            bank,
            pose: LivePose::at_rest(0.0, Pose::IDENTITY),
            posed: false,
            trail: LiveTrail::new(longest, block),
            rate,
            sound_speed: settings.acoustics.medium.sound_speed,
            paths: vec![path; paths],
            path_count: propagation.count(),
            losses: losses.collect(),
            sent: (0..paths).map(|_| Vec::with_capacity(block + AHEAD)).collect(),
            heard: vec![0.0; block],
            quiet: usize::MAX,
            longest: longest + block + AHEAD,
            ending: false,
            loudness: 0.0,
            amplitudes: Vec::with_capacity(modes.len()),
            striking: StrikeMemory::default(),
            transfers: Vec::with_capacity(modes.len()),
            evaluation: TransferMemory::default(),
            source,
        };
        // Lets memory grow to its final size.
        let everything = |_: usize| true;
        voice.source.transfers_of(DVec3::X, everything, &mut voice.evaluation, &mut voice.transfers);
        voice.source.amplitudes(&[(DVec3::X, DVec3::X)], &mut voice.striking, &mut voice.amplitudes);
        voice
    }

    /// Whether no sound is left, at the body or on its paths.
    pub fn is_silent(&self) -> bool {
        self.quiet >= self.longest
    }

    /// Whether it is fading out.
    pub fn is_ending(&self) -> bool {
        self.ending
    }

    /// Number of vibrating modes, rounded up to the groups in which they are computed.
    pub fn awake_modes(&self) -> usize {
        self.bank.awake_modes()
    }

    /// Work of a block: vibrating modes, and the equivalent of a delay line, times paths and receivers.
    pub fn load(&self) -> usize {
        let modes = self.awake_modes();
        if modes == 0 { 0 } else { (modes + LISTENING) * self.paths.len() }
    }

    /// Mean square of the emission to the first receiver in the last block \[Pa²\]; infinite while a force
    /// acts.
    pub fn loudness(&self) -> f64 {
        if self.bank.forces() > 0 { f64::INFINITY } else { self.loudness }
    }

    /// Sets the motion of the body.
    pub fn set_pose(&mut self, pose: LivePose) {
        (self.pose, self.posed) = (pose, true);
    }

    /// Sets a pose at rest, unless [`set_pose`](Self::set_pose) has set the motion.
    pub fn stand(&mut self, sample: f64, pose: Pose) {
        if !self.posed {
            self.pose = LivePose::at_rest(sample, pose);
        }
    }

    /// Starts an impact with these impulses [N s] at points \[m\], both in the frame of the body. Returns
    /// whether there was memory for it. If it is known later than [`LOOK_AHEAD`] samples before its onset,
    /// its beginning is missing.
    pub fn strike(&mut self, force: &LiveForce, points: &[(DVec3, DVec3)], position: i64) -> bool {
        if self.bank.forces() >= MOST_FORCES || self.ending {
            return false;
        }
        if self.is_silent() {
            let next = position + AHEAD as i64;
            self.bank.seek(next);
            self.paths.iter_mut().for_each(|path| path.line.restart(next));
            let now = self.pose.at(position as f64, self.rate).position;
            self.trail.restart(position as f64, now);
        }
        if self.bank.is_silent() {
            self.paths.iter_mut().for_each(|path| path.set = false);
        }
        self.quiet = 0;
        self.source.amplitudes(points, &mut self.striking, &mut self.amplitudes);
        self.bank.add_force(force.first, Arc::clone(&force.samples), &self.amplitudes);
        true
    }

    /// Fades out within the next block, and rests.
    pub fn end(&mut self) {
        self.ending = !self.is_silent();
    }

    /// Adds a block, at whose end the receivers are at their positions. Transfers follow the motion if they
    /// `may`. Returns the number of sets of transfers evaluated.
    pub fn render(&mut self, block: &LiveBlock<'_>, may: bool, outputs: &mut LiveOutputs<'_>) -> usize {
        if self.is_silent() {
            return 0;
        }
        let LiveBlock { position, frames, propagation, receivers } = *block;
        let end = block.end();
        let pose = self.pose.at(end as f64, self.rate);
        self.trail.push(end as f64, pose.position);
        let computed = self.send(block, may);
        self.quiet = if self.bank.is_silent() { self.quiet + frames } else { 0 };
        for (p, path) in self.paths.iter_mut().enumerate() {
            let (receiver, path_index) = (p / self.path_count, p % self.path_count);
            let leaves =
                |place: DVec3| propagation.towards(path_index, place, receivers[receiver]).map(DVec3::length);
            let distance = leaves(pose.position).map(|distance| {
                // The sound received now left the body where it was then: three steps of the fixed point.
                (0..3).fold(distance, |distance, _| {
                    let left = end as f64 - distance / self.sound_speed * self.rate;
                    leaves(self.trail.at(left)).unwrap_or(distance)
                })
            });
            let delay = distance.map(|distance| distance / self.sound_speed * self.rate);
            let heard = &mut self.heard[..frames];
            if !path.line.listen(position, delay, heard) {
                continue;
            }
            if propagation.is_heard(path_index) {
                let channel = outputs.channels[receiver].iter_mut();
                channel.zip(&*heard).for_each(|(sum, pressure)| *sum += f64::from(*pressure));
            }
            // The first receiver feeds the late reverberation.
            if let Some(input) = propagation.reverberation_input(path_index).filter(|_| receiver == 0)
                && let Some(distance) = distance
            {
                let entering = outputs.entering[input].iter_mut().zip(&*heard);
                entering.for_each(|(sum, p)| *sum += f64::from(*p) * distance);
            }
        }
        if self.ending {
            self.bank.silence();
            (self.ending, self.quiet) = (false, 0);
        }
        computed
    }

    /// Stops at once, and drops the sound on its paths.
    pub fn silence(&mut self) {
        if self.is_silent() {
            return;
        }
        self.bank.silence();
        self.paths.iter_mut().for_each(|path| path.line.silence());
        (self.ending, self.quiet) = (false, usize::MAX);
    }

    /// Emits until [`AHEAD`] samples after the block; returns the number of sets of transfers evaluated.
    fn send(&mut self, block: &LiveBlock<'_>, may: bool) -> usize {
        let (frames, ahead) = (block.frames, block.end() + AHEAD as i64);
        let mut computed = 0;
        if self.bank.take_woken() {
            computed += self.set_transfers(block, ahead, true);
            self.bank.jump_to_transfers();
        }
        if may && !self.bank.is_silent() {
            computed += self.set_transfers(block, ahead, false);
        }
        self.sent.iter_mut().for_each(Vec::clear);
        if self.bank.is_silent() {
            self.bank.seek(self.bank.position() + frames as i64);
            self.sent.iter_mut().for_each(|sent| sent.resize(frames, 0.0));
        } else {
            self.bank.render(frames, &mut self.sent);
        }
        if self.ending {
            let fade = |frame: usize| 1.0 - (frame + 1) as f64 / frames as f64;
            for sent in &mut self.sent {
                sent.iter_mut().enumerate().for_each(|(frame, p)| *p *= fade(frame));
            }
        }
        self.loudness = self.sent[0].iter().map(|p| p * p).sum::<f64>() / frames as f64;
        for (path, sent) in self.paths.iter_mut().zip(&self.sent) {
            path.line.send(sent);
        }
        computed
    }

    /// Evaluates the transfers at the receivers at a sample. If modes `woke`: for the place that each path
    /// has already, so that modes in progress do not jump.
    fn set_transfers(&mut self, block: &LiveBlock<'_>, end: i64, woke: bool) -> usize {
        let LiveBlock { propagation, receivers, .. } = *block;
        let mut computed = 0;
        let pose = self.pose.at(end as f64, self.rate);
        let from_world = pose.orientation.inverse();
        let turn = TURN / (self.source.max_order() + 1) as f64;
        for p in 0..self.paths.len() {
            let (receiver, path_index) = (p / self.path_count, p % self.path_count);
            let path = &mut self.paths[p];
            let now =
                propagation.towards(path_index, pose.position, receivers[receiver]).map(|to| from_world * to);
            let moved = match (path.place, now) {
                (Some(old), Some(new)) => old.distance(new) > turn * new.length().min(old.length()),
                (old, new) => old.is_some() != new.is_some(),
            };
            let place = if woke && path.set { path.place } else { now };
            if !woke && path.set && !moved {
                continue;
            }
            (path.place, path.set) = (place, true);
            computed += 1;
            match place {
                Some(place) => {
                    let bank = &self.bank;
                    let rings = |mode: usize| bank.rings(mode);
                    self.source.transfers_of(place, rings, &mut self.evaluation, &mut self.transfers);
                }
                None => {
                    self.transfers.clear();
                    self.transfers.resize(self.source.resonances().len(), Complex64::ZERO);
                }
            }
            let (loss, distance) = (propagation.loss(path_index), place.map_or(0.0, DVec3::length));
            for (transfer, mode) in self.transfers.iter_mut().zip(&self.losses[path_index]) {
                *transfer *= loss.gain(*mode, distance);
            }
            self.bank.set_transfers(p, &self.transfers);
        }
        computed
    }
}
