//! Sorts clicks into time blocks for rendering.
//!
//! A click belongs to the block in which its sound begins. A block's buffer extends before its span by the
//! reach of the band limit. After its span it extends by the longest click of its length class and the reach
//! again. A click costs one pass over the bins of its block, so short clicks use short blocks: lengths are
//! 256 samples times a power of two, the smallest that fits.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use realfft::RealFftPlanner;

use super::block::{BlockJob, BlockKey, BlockTables, ReceivedPulse, ReceivedSound};
use super::block_length::{SPAN, block_length, hop};
use super::interpolation_cache::InterpolationCache;
use super::render_report::RenderReport;
use crate::acoustics::Acoustics;
use crate::reference::PanSource;
use crate::synthesis::acceleration_pulse::AccelerationPulse;
use crate::synthesis::band_end_fade::LONGEST_FADE_REACH;
use crate::synthesis::listener::{Floor, Listener};
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
    pending: BTreeMap<BlockKey, Vec<ReceivedPulse>>,
    tables: BTreeMap<usize, Arc<BlockTables>>,
    interpolations: InterpolationCache,
    planner: RealFftPlanner<f64>,
    handed_out: i64,
    report: RenderReport,
}

impl Renderer {
    /// A renderer for one listener.
    ///
    /// # Errors
    /// A listener without receivers or below the floor, a medium that carries no sound.
    pub fn new(listener: &Listener, settings: &RenderSettings) -> Result<Self, SynthesisError> {
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
            pending: BTreeMap::new(),
            tables: BTreeMap::new(),
            interpolations: InterpolationCache::default(),
            planner: RealFftPlanner::new(),
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
        let floor = self.settings.acoustics.floor;
        let is_ground = matches!(click.source, SoundSource::Ground { .. });
        // A point of the ground may be on the floor, up to rounding.
        let depth = if is_ground { 2e-6 } else { 0.0 };
        if floor.mirrored(click.centre).is_some_and(|mirrored| mirrored.y > click.centre.y + depth) {
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
            let Some(direct) = self.wave(click, receiver, false)? else {
                continue;
            };
            let reflected = match floor {
                // The ground is the reflecting boundary: its sound already contains the reflection.
                _ if is_ground => None,
                Floor::None => None,
                Floor::Rigid { .. } => match self.wave(click, receiver, true)? {
                    None => continue,
                    wave => wave,
                },
            };
            // Overlapping waves form one sound, whose energy is not the sum of their energies.
            match reflected {
                Some(reflected) if reflected.wave.middle - direct.wave.middle > self.overlap(click) => {
                    self.file(click, receiver, direct, None)?;
                    self.file(click, receiver, reflected, None)?;
                }
                _ => self.file(click, receiver, direct, reflected)?,
            }
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

    /// Vector \[m, world\] from the centre of a click to a receiver, directly or `reflected` by the floor.
    /// `None`, and counted, if the receiver, or its mirror image, is inside the source.
    fn towards(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
        reflected: bool,
    ) -> Result<Option<DVec3>, SynthesisError> {
        let Acoustics { medium, floor, .. } = self.settings.acoustics;
        let mirrored = |point: DVec3| floor.mirrored(point).filter(|_| reflected).unwrap_or(point);
        let from = (mirrored(click.centre), click.source.radius());
        let (heard, position) = self.listener.arrival(receiver, from, click.time, medium.sound_speed);
        floor.check(&self.listener, position, heard)?;
        // Reciprocity of mirror images: the source makes at the mirrored receiver what its image makes at the
        // receiver.
        let towards = mirrored(position) - click.centre;
        if click.source.silent_at(click.orientation.inverse() * towards) {
            self.report.receiver_inside += 1;
            self.report.first_inside.get_or_insert((receiver, click.body, click.time));
            return Ok(None);
        }
        Ok(Some(towards))
    }

    /// The wave at a receiver, directly or `reflected` by the floor; `None` if it does not reach the
    /// receiver.
    fn wave(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
        reflected: bool,
    ) -> Result<Option<ReceivedWave>, SynthesisError> {
        let towards = self.towards(click, receiver, reflected)?;
        Ok(towards.and_then(|towards| self.settings.wave(click, towards)))
    }

    /// The sound of a source that gives samples at a receiver, with its reflection by the floor.
    fn push_samples(
        &mut self,
        click: &AccelerationPulse,
        source: &PanSource,
        receiver: usize,
    ) -> Result<(), SynthesisError> {
        let mut sound = SampledSound::default();
        let reflections: &[bool] =
            if self.settings.acoustics.floor == Floor::None { &[false] } else { &[false, true] };
        for &reflected in reflections {
            let Some(towards) = self.towards(click, receiver, reflected)? else { return Ok(()) };
            let place = click.orientation.inverse() * towards;
            sound.add(&source.samples(click, place, &self.settings)?);
        }
        if sound.pressures.is_empty() {
            return Ok(());
        }
        let (first, count) = (sound.first, sound.pressures.len() as f64);
        self.put(click, receiver, first, count, |_, _| ReceivedSound::Samples(sound))
    }

    /// Delay \[s\] between direct sound and floor reflection below which they are one sound: the time in
    /// which the direct sound falls by 50 dB.
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

    /// Puts waves into the blocks in which they begin.
    fn file(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
        direct: ReceivedWave,
        reflected: Option<ReceivedWave>,
    ) -> Result<(), SynthesisError> {
        let rate = self.settings.sample_rate.as_f64();
        let until = reflected.as_ref().map_or(direct.until, |r| r.until.max(direct.until));
        let first = ((direct.from - self.settings.start) * rate).floor() as i64;
        self.put(click, receiver, first, (until - direct.from) * rate, |renderer, length| {
            let of_path = |heard: ReceivedWave| Box::new((heard.wave, heard.distance));
            let (mut direct, mut reflected) = (of_path(direct), reflected.map(of_path));
            for (wave, _) in std::iter::once(&mut *direct).chain(reflected.as_deref_mut()) {
                if let Transfer::Field(transfer) = &mut wave.transfer {
                    let Some(tables) = renderer.tables.get(&length) else { continue };
                    let grid = (length, &tables.grid);
                    transfer.table = renderer.interpolations.get(&transfer.source, transfer.crossing, grid);
                }
            }
            ReceivedSound::Waves { direct, reflected }
        })
    }

    /// Puts a sound of this length \[samples\] from sample `first` on into the block in which it begins;
    /// `sound` receives the length of the block.
    fn put(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
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
            let inverse = self.planner.plan_fft_inverse(length);
            let grid = Grid::new(length, rate, self.settings.acoustics.max_frequency);
            let losses = Losses::on(&grid, self.settings.loss);
            Arc::new(BlockTables { grid, losses, inverse })
        });
        let key = BlockKey { first, length, receiver };
        let sound = sound(self, length);
        self.pending.entry(key).or_default().push(ReceivedPulse { body: click.body, sound });
        Ok(())
    }
}
