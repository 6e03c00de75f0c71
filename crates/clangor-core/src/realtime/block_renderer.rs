//! Renders blocks: waves of acceleration pulses, voices, late reverberation, and the fade to silence.

use std::sync::Arc;

use super::engine_settings::EngineSettings;
use super::event::{ImpactEvent, Part};
use super::object_table::MOST_RETIRING;
use super::receivers::Receivers;
use super::scheduler::Onset;
use super::wave_queue::{QueuedWave, WaveQueue, rate, strength};
use crate::body::BodyId;
use crate::contact::{ForceHistory, ForceProfile, ForceShape};
use crate::medium::Medium;
use crate::propagation::{LateReverberation, PropagationPaths};
use crate::synthesis::live_pulses::LivePulses;
use crate::synthesis::modal::live_forces::{LiveForce, LiveForces};
use crate::synthesis::modal::live_voice::{LiveBlock, LiveOutputs};
use crate::synthesis::{AccelerationPulse, SoundSource, SynthesisError};

/// Capacity of the queue of waves.
const MOST_WAITING: usize = 8192;
/// Duration of the fade to silence \[s\].
const FADE: f64 = 1e-3;
/// Forces of impacts on objects in progress at once.
const FORCES: usize = 512;

/// See the module.
pub(super) struct BlockRenderer {
    sample_rate: f64,
    medium: Medium,
    profile: ForceProfile,
    /// Longest path of a sound \[m\].
    reach: f64,
    paths: PropagationPaths,
    pub(super) receivers: Receivers,
    pub(super) pulses: LivePulses,
    waves: WaveQueue,
    forces: LiveForces,
    reverberation: Option<LateReverberation>,
    mix: Mix,
    /// Which parts of the sound are on.
    parts: [bool; 3],
    /// Samples until everything is silent.
    stopping: Option<usize>,
    /// Waves left out because their path exceeds the reach.
    distant: u64,
}

/// The samples of one block.
struct Mix {
    /// Pressure \[Pa\] at each receiver.
    channels: Vec<Vec<f64>>,
    /// Input of the late reverberation \[Pa m\].
    entering: Vec<Vec<f64>>,
    /// One frame of late reverberation \[Pa\].
    late: Vec<f64>,
}

impl Mix {
    fn new(receivers: usize, block: usize) -> Self {
        let silent = |count: usize| (0..count).map(|_| vec![0.0; block]).collect::<Vec<_>>();
        Mix {
            channels: silent(receivers),
            entering: silent(LateReverberation::INPUTS),
            late: vec![0.0; receivers],
        }
    }

    /// Silence of so many samples.
    fn clear(&mut self, frames: usize) {
        for samples in self.channels.iter_mut().chain(&mut self.entering) {
            samples.resize(frames, 0.0);
            samples.fill(0.0);
        }
    }
}

impl BlockRenderer {
    /// Silence.
    ///
    /// # Errors
    /// [`SynthesisError`] for a medium, band or room out of range, and for planes in a room.
    pub(super) fn new(settings: &EngineSettings) -> Result<Self, SynthesisError> {
        settings.acoustics.check()?;
        let rendering = settings.rendering();
        let paths = settings.paths();
        let sample_rate = settings.sample_rate.as_f64();
        let reverberation = match &settings.acoustics.room {
            Some(room) if room.late => {
                let sound_speed = settings.acoustics.medium.sound_speed;
                Some(LateReverberation::new(room, settings.acoustics.air.as_ref(), sound_speed, sample_rate)?)
            }
            Some(room) => room.check().map(|()| None)?,
            None => None,
        };
        let outputs = settings.receivers + LateReverberation::INPUTS;
        let fields = settings.objects + MOST_RETIRING;
        let seconds = settings.longest_delay() + 0.1;
        Ok(BlockRenderer {
            sample_rate,
            medium: settings.acoustics.medium,
            profile: settings.profile,
            reach: settings.reach,
            receivers: Receivers::new(settings.receivers),
            pulses: LivePulses::new(&rendering, &paths, fields, outputs, seconds)?,
            waves: WaveQueue::new(MOST_WAITING),
            forces: LiveForces::new(&rendering, FORCES),
            reverberation,
            mix: Mix::new(settings.receivers, settings.block),
            parts: [true; 3],
            stopping: None,
            distant: 0,
            paths,
        })
    }

    /// Number of paths to each receiver.
    pub(super) fn path_count(&self) -> usize {
        self.paths.count()
    }

    /// Whether a part of the sound is on.
    pub(super) fn renders(&self, part: Part) -> bool {
        self.parts[part as usize]
    }

    /// Switches a part of the sound on or off.
    pub(super) fn switch(&mut self, part: Part, on: bool) {
        self.parts[part as usize] = on;
        self.paths.set_reflections(self.renders(Part::Reflections));
    }

    /// Drops all queued waves and begins the fade to silence.
    pub(super) fn stop(&mut self) {
        self.waves.clear();
        let length = (FADE * self.sample_rate) as usize;
        self.stopping.get_or_insert(length);
    }

    /// Samples until everything is silent, during the fade to silence.
    pub(super) fn stopping(&self) -> Option<usize> {
        self.stopping
    }

    /// The force of an impact over time.
    fn shape(&self, impact: &ImpactEvent) -> ForceShape {
        let history = |force: &Arc<ForceHistory>| ForceShape::History(Arc::clone(force));
        impact.force.as_ref().map_or(self.profile.into(), history)
    }

    /// The force of an impact for unit impulse; `None` if it lasts too long or too many are in progress.
    pub(super) fn force(&mut self, onset: &Onset, impact: &ImpactEvent) -> Option<LiveForce> {
        let shape = self.shape(impact);
        self.forces.impact(&shape, onset.sample, impact.duration)
    }

    /// Queues the waves of the acceleration pulse that an impact causes on a source of this bounding radius
    /// \[m\], to all receivers by all paths.
    pub(super) fn send_waves(
        &mut self,
        impact: &ImpactEvent,
        onset: &Onset,
        source: SoundSource,
        radius: f64,
    ) {
        let pulse = AccelerationPulse {
            body: BodyId(0),
            time: onset.time,
            duration: impact.duration,
            shape: self.shape(impact),
            centre: impact.pose.position,
            orientation: impact.pose.orientation,
            velocity_change: impact.velocity_change,
            angular_velocity_change: impact.angular_velocity_change,
            source,
        };
        let rate = rate(&pulse.shape, pulse.duration);
        for (receiver, place) in self.receivers.targets().iter().enumerate() {
            for path in 0..self.paths.count() {
                let Some(towards) = self.paths.towards(path, pulse.centre, *place) else { continue };
                if towards.length() > self.reach {
                    self.distant += 1;
                    continue;
                }
                if self.waves.is_full() {
                    self.waves.shed.audible += 1;
                    continue;
                }
                let Some(first) = self.pulses.first_sample(&pulse, towards) else { continue };
                let strength = strength(&pulse, rate, radius, towards.length(), &self.medium);
                self.waves.add(first, QueuedWave { pulse: pulse.clone(), towards, path, receiver, strength });
            }
        }
    }

    /// Begins a block of silence, and moves the receivers on.
    pub(super) fn begin_block(&mut self, frames: usize) {
        self.receivers.follow(frames, self.sample_rate);
        self.mix.clear(frames);
    }

    /// Adds the waves of acceleration pulses until a sample, as many as the `credit` allows, and charges it.
    pub(super) fn render_waves(&mut self, end: i64, credit: &mut usize) {
        let BlockRenderer { waves, pulses, paths, mix, .. } = self;
        let receivers = mix.channels.len();
        let played = waves.play(end, *credit, |wave| {
            let QueuedWave { pulse, towards, path, receiver, .. } = wave;
            let input = paths.reverberation_input(*path).filter(|_| *receiver == 0);
            let into = [(*receiver, 1.0), (receivers + input.unwrap_or(0), towards.length())];
            let outputs = match (paths.is_heard(*path), input) {
                (true, Some(_)) => &into[..],
                (true, None) => &into[..1],
                (false, _) => &into[1..],
            };
            pulses.play(pulse, *towards, *path, outputs);
        });
        *credit = credit.saturating_sub(played);
        for (output, samples) in mix.channels.iter_mut().chain(&mut mix.entering).enumerate() {
            pulses.take(output, samples);
        }
    }

    /// The block from a sample on, as voices render it, and what they add to.
    pub(super) fn voice_block(&mut self, position: i64, frames: usize) -> (LiveBlock<'_>, LiveOutputs<'_>) {
        let Mix { channels, entering, .. } = &mut self.mix;
        let receivers = self.receivers.positions();
        (
            LiveBlock { position, frames, propagation: &self.paths, receivers },
            LiveOutputs { channels, entering },
        )
    }

    /// Adds the late reverberation.
    pub(super) fn reverberate(&mut self, frames: usize) {
        let Some(network) = &mut self.reverberation else { return };
        let Mix { channels, entering, late } = &mut self.mix;
        for frame in 0..frames {
            late.fill(0.0);
            network.step(&std::array::from_fn(|input| entering[input][frame]), late);
            channels.iter_mut().zip(&*late).for_each(|(channel, p)| channel[frame] += p);
        }
    }

    /// Applies the fade to silence; whether it has ended, and all voices must be silenced.
    pub(super) fn fade(&mut self, frames: usize) -> bool {
        let Some(left) = self.stopping else { return false };
        let length = FADE * self.sample_rate;
        for channel in &mut self.mix.channels {
            for (frame, p) in channel.iter_mut().enumerate() {
                *p *= (left.saturating_sub(frame + 1)) as f64 / length;
            }
        }
        self.stopping = left.checked_sub(frames).filter(|left| *left > 0);
        if self.stopping.is_some() {
            return false;
        }
        self.pulses.silence();
        self.waves.clear();
        if let Some(network) = &mut self.reverberation {
            network.silence();
        }
        true
    }

    /// Pressure of the block \[Pa\] at each receiver.
    pub(super) fn channels(&self) -> &[Vec<f64>] {
        &self.mix.channels
    }

    /// Counts of waves, as (left out for their distance, left out by the budget, masked).
    pub(super) fn wave_counts(&self) -> [u64; 3] {
        [self.distant, self.waves.shed.audible, self.waves.shed.masked]
    }
}
