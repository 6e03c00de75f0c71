//! One ringing body as a live listener hears it: its modes, driven as impacts come, and a delay for each
//! path_index and receiver.
//!
//! The same resonators, forces and transfers as in [`voice`](super::voice), in blocks as they are asked for.
//! After [`LiveVoice::new`] nothing is allocated. What leaves the body is sent [`AHEAD`] samples before it
//! could first be heard, so that an impact must be known [`LOOK_AHEAD`] samples before it begins.
//!
//! The pose comes from outside, as often as somebody wants, and goes on with its velocity in between.
//! Transfers follow it when they may, from the end of one block to the next; modes that wake get theirs at
//! once.
//!
//! Differs from the offline voice: no force streams, no vibration that is taken over, and delays that are
//! straight lines within a block, between samples a sinc of 16: 3e-4 below a third of the rate.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use num_complex::Complex64;

use super::drive::{ForceSamples, Shaper};
use super::live_delay::{self, HALF_TAPS, LiveDelay};
use super::live_trail::LiveTrail;
use super::source::{ModalSource, StrikeMemory};
use super::transfer::TransferMemory;
use crate::contact::ForceProfile;
use crate::pose::Pose;
use crate::synthesis::lowpass::{self, REACH};
use crate::synthesis::modal::resonator_bank::ResonatorBank;
use crate::synthesis::propagation_paths::PropagationPaths;
use crate::synthesis::render_settings::RenderSettings;

/// Samples by which a body sends ahead of what is heard.
pub const AHEAD: usize = HALF_TAPS;
/// Samples before its beginning at which an impact must be known.
pub const LOOK_AHEAD: usize = AHEAD + REACH + 1;

/// By how much order × direction may turn before transfers are due [rad].
const TURN: f64 = 0.01;
/// Modes that cost as much as the delay of a path.
const LISTENING: usize = 8;
/// Time for which a body goes on without news \[s\].
const LONGEST_MOTION: f64 = 0.1;
/// Forces in progress on one body; more are refused.
const MOST_FORCES: usize = 64;
/// Longest force of a force \[samples\]; longer ones are refused.
const LONGEST_COURSE: usize = 4096;

/// The forces of impacts, which bodies share.
pub struct LiveForces {
    shaper: Shaper,
    rate: f64,
    forces: Vec<Arc<ForceSamples>>,
    next: usize,
}

/// One impact, ready to strike.
#[derive(Clone, Debug)]
pub struct LiveForce {
    first: i64,
    force: Arc<ForceSamples>,
}

impl LiveForces {
    /// Memory for so many impacts in progress.
    pub fn new(settings: &RenderSettings, impacts: usize) -> Self {
        let rate = settings.sample_rate.as_f64();
        let (low, high) = settings.band();
        let mut shaper = Shaper::new(rate, 0.5 * (low + high), lowpass::HALF_WIDTH * rate);
        shaper.reserve(LONGEST_COURSE);
        let force = || {
            Arc::new(ForceSamples {
                values: Vec::with_capacity(LONGEST_COURSE),
                terms: Vec::with_capacity(LONGEST_COURSE),
            })
        };
        LiveForces { shaper, rate, forces: (0..impacts).map(|_| force()).collect(), next: 0 }
    }

    /// An impact of unit impulse that begins at `onset` \[samples\] and lasts `duration` \[s\]; `None` if it
    /// lasts too long or too many are in progress.
    pub fn impact(&mut self, profile: ForceProfile, onset: f64, duration: f64) -> Option<LiveForce> {
        let (begin, end) = profile.extent(duration);
        let samples = (end - begin) * self.rate + 2.0 * self.shaper.reach() as f64 + 3.0;
        if samples.is_nan() || samples > LONGEST_COURSE as f64 || !onset.is_finite() {
            return None;
        }
        // The one that was given out first is the likeliest to be over.
        let count = self.forces.len();
        let free = (0..count).map(|k| (self.next + k) % count).find(|at| {
            // Nobody else holds it.
            Arc::strong_count(&self.forces[*at]) == 1
        })?;
        self.next = (free + 1) % count;
        let first = self.shaper.pulse(profile, onset, duration, Arc::get_mut(&mut self.forces[free])?);
        Some(LiveForce { first, force: Arc::clone(&self.forces[free]) })
    }
}

/// Where a body is, and how it moves on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LivePose {
    /// When \[samples\].
    pub sample: f64,
    /// Where then.
    pub pose: Pose,
    /// Velocity [m/s].
    pub velocity: DVec3,
    /// Angular velocity [rad/s].
    pub angular_velocity: DVec3,
}

impl LivePose {
    fn at(&self, sample: f64, rate: f64) -> Pose {
        let time = ((sample - self.sample) / rate).clamp(-LONGEST_MOTION, LONGEST_MOTION);
        Pose {
            position: self.pose.position + self.velocity * time,
            orientation: DQuat::from_scaled_axis(self.angular_velocity * time) * self.pose.orientation,
        }
    }
}

/// See the module.
pub struct LiveVoice {
    source: Arc<ModalSource>,
    bank: ResonatorBank,
    pose: LivePose,
    /// Whether somebody told it.
    posed: bool,
    trail: LiveTrail,
    rate: f64,
    sound_speed: f64,
    /// For each receiver all propagation.
    paths: Vec<Path>,
    path_count: usize,
    /// What walls leave of each mode and its attenuation in air [1/m], for each path_index; empty where
    /// nothing is lost.
    losses: Vec<Vec<(f64, f64)>>,
    /// What each path sends in a block.
    sent: Vec<Vec<f64>>,
    /// What a path brings in a block.
    heard: Vec<f32>,
    /// Samples since nothing moves.
    quiet: usize,
    /// Samples after which all that was sent has been heard.
    longest: usize,
    ending: bool,
    /// Mean square of what was sent to the first receiver in the last block \[Pa²\].
    loudness: f64,
    amplitudes: Vec<f64>,
    striking: StrikeMemory,
    transfers: Vec<Complex64>,
    evaluation: TransferMemory,
}

#[derive(Clone, Debug)]
struct Path {
    line: LiveDelay,
    /// For which the transfers are [m, frame of the body]; `None` where the path_index does not lead.
    place: Option<DVec3>,
    /// Whether they have ever been set.
    set: bool,
}

/// What a block is rendered into.
pub struct LiveOutputs<'a> {
    /// Pressure \[Pa\] at each receiver, added to.
    pub channels: &'a mut [Vec<f64>],
    /// What enters the late reverberation \[Pa m\], for each of its inputs, added to.
    pub entering: &'a mut [Vec<f64>],
}

impl LiveVoice {
    /// A body at rest, for receivers that hear by these propagation over up to `seconds`, in blocks of up to
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
        let losses = propagation.losses().iter().map(|loss| match loss.is_none() {
            true => Vec::new(),
            false => modes.iter().map(|mode| loss.at(mode.frequency)).collect(),
        });
        let mut voice = LiveVoice {
            bank,
            pose: LivePose {
                sample: 0.0,
                pose: Pose::IDENTITY,
                velocity: DVec3::ZERO,
                angular_velocity: DVec3::ZERO,
            },
            posed: false,
            trail: LiveTrail::new(longest, block),
            rate,
            sound_speed: settings.medium.sound_speed,
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
        // Lets memory grow to what it will ever need.
        let everything = |_: usize| true;
        voice.source.transfers_of(DVec3::X, everything, &mut voice.evaluation, &mut voice.transfers);
        voice.source.amplitudes(&[(DVec3::X, DVec3::X)], &mut voice.striking, &mut voice.amplitudes);
        voice
    }

    /// Whether there is nothing to be heard.
    pub fn is_silent(&self) -> bool {
        self.quiet >= self.longest
    }

    /// Whether it is fading out.
    pub fn is_ending(&self) -> bool {
        self.ending
    }

    /// Modes that move, in units in which they are computed.
    pub fn awake_modes(&self) -> usize {
        self.bank.awake_modes()
    }

    /// Work of a block that is spared if it ends: modes times propagation and receivers, of which listening
    /// is worth some.
    pub fn load(&self) -> usize {
        let modes = self.awake_modes();
        if modes == 0 { 0 } else { (modes + LISTENING) * self.paths.len() }
    }

    /// How loud it is: mean square of what left it for the first receiver in the last block \[Pa²\]. Infinite
    /// while it is struck.
    pub fn loudness(&self) -> f64 {
        if self.bank.forces() > 0 { f64::INFINITY } else { self.loudness }
    }

    /// Sets where the body is and how it moves on.
    pub fn set_pose(&mut self, pose: LivePose) {
        (self.pose, self.posed) = (pose, true);
    }

    /// Sets where it stands, unless that was told otherwise.
    pub fn stand(&mut self, sample: f64, pose: Pose) {
        if !self.posed {
            self.pose = LivePose { sample, pose, velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO };
        }
    }

    /// Lets an impact act with these impulses [N s] at points \[m\], both in the frame of the body; whether
    /// it could be taken. Of one that is known later than [`LOOK_AHEAD`] samples before it begins, what
    /// should already be heard is missing.
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
        self.bank.add_force(force.first, Arc::clone(&force.force), &self.amplitudes);
        true
    }

    /// Fades out within the next block, and rests.
    pub fn end(&mut self) {
        self.ending = !self.is_silent();
    }

    /// Renders `frames` samples from `position` on, while receivers move to where they are now. Transfers
    /// follow the motion if they `may`. Returns how many sets of transfers were computed.
    pub fn render(
        &mut self,
        position: i64,
        frames: usize,
        propagation: &PropagationPaths,
        receivers: &[DVec3],
        may: bool,
        outputs: &mut LiveOutputs<'_>,
    ) -> usize {
        if self.is_silent() {
            return 0;
        }
        let end = position + frames as i64;
        let pose = self.pose.at(end as f64, self.rate);
        self.trail.push(end as f64, pose.position);
        let computed = self.send(end, frames, propagation, receivers, may);
        self.quiet = if self.bank.is_silent() { self.quiet + frames } else { 0 };
        for (p, path) in self.paths.iter_mut().enumerate() {
            let (receiver, path_index) = (p / self.path_count, p % self.path_count);
            let leaves =
                |place: DVec3| propagation.towards(path_index, place, receivers[receiver]).map(DVec3::length);
            let distance = leaves(pose.position).map(|distance| {
                // What is heard now left where the body was then.
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
            // Late reverberation hears what the first receiver does.
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

    /// Rests at once, and forgets what is on its path_index.
    pub fn silence(&mut self) {
        if self.is_silent() {
            return;
        }
        self.bank.silence();
        self.paths.iter_mut().for_each(|path| path.line.silence());
        (self.ending, self.quiet) = (false, usize::MAX);
    }

    /// Sends until [`AHEAD`] samples after `end`; returns how many sets of transfers were computed.
    fn send(
        &mut self,
        end: i64,
        frames: usize,
        propagation: &PropagationPaths,
        receivers: &[DVec3],
        may: bool,
    ) -> usize {
        let mut computed = 0;
        if self.bank.take_woken() {
            computed += self.set_transfers(propagation, receivers, end + AHEAD as i64, true);
            self.bank.jump_to_transfers();
        }
        if may && !self.bank.is_silent() {
            computed += self.set_transfers(propagation, receivers, end + AHEAD as i64, false);
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

    /// Sets the transfers where receivers are: of modes that `woke` for the place that their path has
    /// already, so that those that ring do not jump.
    fn set_transfers(
        &mut self,
        propagation: &PropagationPaths,
        receivers: &[DVec3],
        end: i64,
        woke: bool,
    ) -> usize {
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
            let (loss, distance) = (propagation.losses()[path_index], place.map_or(0.0, DVec3::length));
            for (transfer, mode) in self.transfers.iter_mut().zip(&self.losses[path_index]) {
                *transfer *= loss.gain(*mode, distance);
            }
            self.bank.set_transfers(p, &self.transfers);
        }
        computed
    }
}
