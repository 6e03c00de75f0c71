//! Sorts clicks into time blocks for rendering.
//!
//! A click belongs to the block in which its sound begins. A block's buffer extends before its span by the
//! reach of the band limit. After its span it extends by the longest click of its length class and the reach
//! again. A click costs one pass over the bins of its block, so short clicks use short blocks: lengths are
//! 256 samples times a power of two, the smallest that fits.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_fourier::Planner;
use glam::DVec3;

use super::block::{BlockJob, BlockKey, BlockTables, PathWave, ReceivedPulse, ReceivedSound};
use super::block_length::{SPAN, block_length, hop};
use super::interpolation_cache::InterpolationCache;
use super::render_report::RenderReport;
use crate::propagation::PropagationPaths;
use crate::reference::PanSource;
use crate::synthesis::acceleration_pulse::AccelerationPulse;
use crate::synthesis::band_end_fade::LONGEST_FADE_REACH;
use crate::synthesis::listener::Listener;
use crate::synthesis::lowpass::REACH;
use crate::synthesis::received_wave::ReceivedWave;
use crate::synthesis::render_settings::RenderSettings;
use crate::synthesis::sampled_sound::SampledSound;
use crate::synthesis::source::SoundSource;
use crate::synthesis::spectrum::{Grid, Losses};
use crate::synthesis::synthesis_error::SynthesisError;
use crate::synthesis::wave::Transfer;

/// Sorts clicks into blocks.
pub struct Renderer {
    listener: Listener,
    settings: RenderSettings,
    paths: Arc<PropagationPaths>,
    pending: BTreeMap<BlockKey, Vec<ReceivedPulse>>,
    tables: BTreeMap<usize, Arc<BlockTables>>,
    interpolations: InterpolationCache,
    planner: Planner,
    handed_out: i64,
    report: RenderReport,
}

/// How a click arrives at a receiver by a path.
enum Arrival {
    /// Along this vector from the centre of the click \[m\], in its own space.
    Towards(DVec3),
    /// Not at all: there is no such path.
    Nowhere,
    /// The receiver, or its mirror image, is inside the source.
    Inside,
}

/// A wave at a receiver, and the signal that it is added to.
struct ArrivingWave {
    channel: usize,
    path: usize,
    received: ReceivedWave,
}

impl Renderer {
    /// A renderer for one listener, who hears by all paths of the acoustics, late reverberation apart.
    ///
    /// # Errors
    /// A listener without receivers or below the floor, a medium that carries no sound, planes in a room.
    pub fn new(listener: &Listener, settings: &RenderSettings) -> Result<Self, SynthesisError> {
        Renderer::along(listener, settings, Arc::new(settings.acoustics.paths().heard()))
    }

    /// A renderer for one listener, who hears by these paths.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn along(
        listener: &Listener,
        settings: &RenderSettings,
        paths: Arc<PropagationPaths>,
    ) -> Result<Self, SynthesisError> {
        settings.check()?;
        if listener.receivers.is_empty() {
            return Err(SynthesisError::NoReceivers { listener: listener.name.clone() });
        }
        for key in listener.track.keys() {
            for receiver in 0..listener.receivers.len() {
                let position = listener.receiver_position(receiver, key.time);
                settings.acoustics.floor.check(listener, position, key.time)?;
            }
        }
        Ok(Renderer {
            listener: listener.clone(),
            settings: *settings,
            paths,
            pending: BTreeMap::new(),
            tables: BTreeMap::new(),
            interpolations: InterpolationCache::default(),
            planner: Planner::new(),
            handed_out: i64::MIN,
            report: RenderReport::default(),
        })
    }

    /// Adds a click. The order of calls is the order of summation: the same order gives the same bits. Clicks
    /// that have decayed before sample 0 are not rendered.
    ///
    /// # Errors
    /// Numbers that are not finite, a click too long for any block or too late for its block, a moving
    /// receiver below the floor at the arrival of the click.
    pub fn push(&mut self, click: &AccelerationPulse) -> Result<(), SynthesisError> {
        click.check()?;
        self.report.clicks += 1;
        if self.paths.is_buried(click.centre) {
            self.report.below_floor += 1;
            return Ok(());
        }
        if let SoundSource::Field(source) = &click.source {
            let band_end = source.max_frequency(self.settings.acoustics.medium.sound_speed);
            if band_end < self.settings.band().0 {
                self.report.band_ends.insert(click.body, band_end);
            }
        }
        for receiver in 0..self.listener.receivers.len() {
            if let SoundSource::Reference(source) = &click.source {
                self.push_samples(click, source, receiver)?;
                continue;
            }
            let Some(waves) = self.waves(click, receiver)? else { continue };
            self.file_all(click, waves)?;
        }
        Ok(())
    }

    /// Blocks to which no later click can belong, in order; empty until a whole span of time is complete.
    ///
    /// `time` \[s\]: no force of a click pushed later acts before it.
    pub fn take_ready(&mut self, time: f64) -> Vec<BlockJob> {
        let sample = (time - LONGEST_FADE_REACH - self.settings.start) * self.settings.sample_rate.as_f64();
        let span = (sample / SPAN as f64).floor() as i64;
        self.take_before(span.saturating_mul(SPAN))
    }

    /// All remaining blocks, in order.
    pub fn take_all(&mut self) -> Vec<BlockJob> {
        self.take_before(i64::MAX)
    }

    /// Samples before this one are complete once the blocks handed out so far have been added.
    pub fn complete_until(&self) -> i64 {
        self.handed_out.saturating_sub(REACH as i64)
    }

    /// Counts of clicks so far.
    pub fn report(&self) -> &RenderReport {
        &self.report
    }

    fn take_before(&mut self, first: i64) -> Vec<BlockJob> {
        if first <= self.handed_out {
            return Vec::new();
        }
        self.handed_out = first;
        let later = self.pending.split_off(&BlockKey { first, length: 0, receiver: 0 });
        let ready = std::mem::replace(&mut self.pending, later);
        let rate = self.settings.sample_rate.as_f64();
        let job = |(key, clicks): (BlockKey, Vec<ReceivedPulse>)| BlockJob {
            origin: self.settings.start + (key.first - REACH as i64) as f64 / rate,
            tables: Arc::clone(&self.tables[&key.length]),
            key,
            clicks,
        };
        ready.into_iter().map(job).collect()
    }

    /// How a click arrives at a receiver by a path; counted if not at all because the receiver is inside.
    fn arrival(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
        path: usize,
    ) -> Result<Arrival, SynthesisError> {
        let acoustics = &self.settings.acoustics;
        let from = (self.paths.image(path).image(click.centre), click.source.radius());
        let (heard, position) =
            self.listener.arrival(receiver, from, click.time, acoustics.medium.sound_speed);
        acoustics.floor.check(&self.listener, position, heard)?;
        let Some(towards) = self.paths.towards(path, click.centre, position) else {
            return Ok(Arrival::Nowhere);
        };
        if click.source.silent_at(click.orientation.inverse() * towards) {
            self.report.receiver_inside += 1;
            self.report.first_inside.get_or_insert((receiver, click.body, click.time));
            return Ok(Arrival::Inside);
        }
        Ok(Arrival::Towards(towards))
    }

    /// The waves of a click at a receiver by all paths; `None` if the receiver is inside the source.
    fn waves(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
    ) -> Result<Option<Vec<ArrivingWave>>, SynthesisError> {
        let is_ground = matches!(click.source, SoundSource::Ground { .. });
        let paths = Arc::clone(&self.paths);
        let mut waves = Vec::with_capacity(paths.count());
        for path in 0..paths.count() {
            // The ground is the reflecting boundary: its sound already contains the reflection.
            if is_ground && paths.meets_ground(path, click.centre, click.orientation * DVec3::Y) {
                continue;
            }
            let towards = match self.arrival(click, receiver, path)? {
                Arrival::Towards(towards) => towards,
                Arrival::Nowhere => continue,
                Arrival::Inside => return Ok(None),
            };
            let channel = paths.channel(path, receiver);
            let received = self.settings.wave(click, towards);
            waves.extend(received.map(|received| ArrivingWave { channel, path, received }));
        }
        Ok(Some(waves))
    }

    /// The sound of a source that gives samples at a receiver, by all paths.
    fn push_samples(
        &mut self,
        click: &AccelerationPulse,
        source: &PanSource,
        receiver: usize,
    ) -> Result<(), SynthesisError> {
        let paths = Arc::clone(&self.paths);
        let mut sounds: BTreeMap<usize, SampledSound> = BTreeMap::new();
        for path in 0..paths.count() {
            let towards = match self.arrival(click, receiver, path)? {
                Arrival::Towards(towards) => towards,
                Arrival::Nowhere => continue,
                Arrival::Inside => return Ok(()),
            };
            let place = click.orientation.inverse() * towards;
            let sound = source.samples(click, place, &self.settings)?;
            sounds.entry(paths.channel(path, receiver)).or_default().add(&sound);
        }
        for (channel, sound) in sounds {
            if !sound.pressures.is_empty() {
                let (first, count) = (sound.first, sound.pressures.len() as f64);
                self.put(click, channel, first, count, |_, _| ReceivedSound::Samples(sound))?;
            }
        }
        Ok(())
    }

    /// Delay \[s\] between two waves of a click below which they are one sound: the time in which the first
    /// falls by 50 dB.
    fn overlap(&self, click: &AccelerationPulse) -> f64 {
        let medium = &self.settings.acoustics.medium;
        let ringing = click.source.ring_time(medium);
        let until_quiet = match &click.source {
            // Ring times are those for 200 dB with spheres, for 100 dB with fields.
            SoundSource::Sphere { .. } => 0.25 * ringing,
            // A field begins before the arrival of the wave from its centre.
            SoundSource::Field(source) => source.radius / medium.sound_speed + 0.5 * ringing,
            SoundSource::Reference(_) | SoundSource::Ground { .. } => ringing,
        };
        click.duration + until_quiet
    }

    /// Puts all waves of a click at a receiver into blocks.
    ///
    /// Overlapping waves form one sound, whose energy is not the sum of their energies; they share a block. A
    /// wave that a wall filters has a block of its own, as short as it needs.
    fn file_all(
        &mut self,
        click: &AccelerationPulse,
        waves: Vec<ArrivingWave>,
    ) -> Result<(), SynthesisError> {
        let paths = Arc::clone(&self.paths);
        let (alone, mut joined): (Vec<_>, Vec<_>) =
            waves.into_iter().partition(|wave| paths.loss(wave.path).has_walls());
        joined
            .sort_by(|a, b| a.channel.cmp(&b.channel).then(a.received.middle.total_cmp(&b.received.middle)));
        let overlap = self.overlap(click);
        while let Some(first) = joined.first() {
            let (channel, begin) = (first.channel, first.received.middle);
            let is_later =
                |wave: &ArrivingWave| wave.channel != channel || wave.received.middle - begin > overlap;
            let later = joined.iter().position(is_later).unwrap_or(joined.len());
            let rest = joined.split_off(later);
            self.file(click, joined)?;
            joined = rest;
        }
        alone.into_iter().try_for_each(|wave| self.file(click, vec![wave]))
    }

    /// Puts waves of one channel into the block in which the first begins.
    fn file(&mut self, click: &AccelerationPulse, waves: Vec<ArrivingWave>) -> Result<(), SynthesisError> {
        let rate = self.settings.sample_rate.as_f64();
        let Some(channel) = waves.first().map(|wave| wave.channel) else { return Ok(()) };
        let from = waves.iter().map(|wave| wave.received.from).fold(f64::INFINITY, f64::min);
        let until = waves.iter().map(|wave| wave.received.until).fold(f64::NEG_INFINITY, f64::max);
        let first = ((from - self.settings.start) * rate).floor() as i64;
        self.put(click, channel, first, (until - from) * rate, |renderer, length| {
            let of_path = |ArrivingWave {
                               path, received: ReceivedWave { mut wave, distance, .. }, ..
                           }| {
                if let Transfer::Field(transfer) = &mut wave.transfer
                    && let Some(tables) = renderer.tables.get(&length)
                {
                    let grid = (length, &tables.grid);
                    transfer.table = renderer.interpolations.get(&transfer.source, transfer.crossing, grid);
                }
                PathWave { wave, distance, path }
            };
            ReceivedSound::Waves(waves.into_iter().map(of_path).collect())
        })
    }

    /// Puts a sound of this length \[samples\] from sample `first` on into the block of a channel in which it
    /// begins; `sound` receives the length of the block.
    fn put(
        &mut self,
        click: &AccelerationPulse,
        channel: usize,
        first: i64,
        samples: f64,
        sound: impl FnOnce(&mut Self, usize) -> ReceivedSound,
    ) -> Result<(), SynthesisError> {
        let rate = self.settings.sample_rate.as_f64();
        let Some(length) = block_length(samples) else {
            let (body, time, radius) = (click.body, click.time, click.source.radius());
            return Err(SynthesisError::TooLong { body, time, seconds: samples / rate, radius });
        };
        let hop = hop(length);
        let first = first.div_euclid(hop) * hop;
        if first < self.handed_out {
            return Err(SynthesisError::Late { body: click.body, time: click.time });
        }
        if first - REACH as i64 + length as i64 <= 0 {
            return Ok(());
        }
        self.tables.entry(length).or_insert_with(|| {
            let inverse = self.planner.inverse(length);
            let grid = Grid::new(length, rate, self.settings.acoustics.max_frequency);
            let losses = self.paths.losses().map(|loss| Losses::on(&grid, *loss)).collect();
            Arc::new(BlockTables { grid, losses, inverse })
        });
        let key = BlockKey { first, length, receiver: channel };
        let sound = sound(self, length);
        self.pending.entry(key).or_default().push(ReceivedPulse { body: click.body, sound });
        Ok(())
    }
}
