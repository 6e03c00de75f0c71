//! Sorts clicks into time blocks and turns blocks into samples.
//!
//! A click belongs to the block in which it begins to be heard. A block's buffer holds, before its own span,
//! the reach of the band limit, and after it the longest click of its length class and the reach again. Short
//! clicks use short blocks, because a click costs one pass over the bins of its block: lengths are 256
//! samples times a power of two, the smallest that fits.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner};

use super::SynthesisError;
use super::field_interpolation::Interpolation;
use super::field_spectrum::{FieldPlayer, LONGEST_FADE_REACH};
use super::listener::{Floor, Listener};
use super::lowpass::REACH;
use super::render_settings::RenderSettings;
use super::source::{FieldSource, SoundSource};
use super::spectrum::{Grid, Losses, Spectrum, Transfer, Wave};
use crate::body::BodyId;
use crate::reference::pan_sound::{PanSource, Samples};
use crate::synthesis::acceleration_pulse::AccelerationPulse;
use crate::synthesis::received_wave::ReceivedWave;

/// Blocks are handed out in whole spans of this many samples, so that their order never depends on when.
const SPAN: i64 = 1 << 16;
/// Shortest block \[samples\].
pub(super) const MIN_LENGTH: usize = 256;
/// Longest block \[samples\]: 11 s at 384 kHz.
const MAX_LENGTH: usize = 1 << 22;

/// Memory for interpolations of fields that are kept from click to click; beyond, they are computed anew.
const MAX_INTERPOLATION_BYTES: usize = 256 << 20;

/// What was heard, and what could not be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderReport {
    /// Clicks taken.
    pub clicks: u64,
    /// Clicks left out at a receiver because it was inside the body, or the sphere that stands for it.
    pub receiver_inside: u64,
    /// The first of them: receiver, body, time of the click \[s\].
    pub first_inside: Option<(usize, BodyId, f64)>,
    /// Clicks left out because the body's centre was below the rigid floor.
    pub below_floor: u64,
    /// Where the field of a body ends \[Hz\], of those that end below the highest frequency that is rendered
    /// in full. What is missing above is in
    /// [`OverlapAdd::missing_energies`](super::OverlapAdd::missing_energies).
    pub band_ends: BTreeMap<BodyId, f64>,
}

/// Takes clicks, gives blocks.
pub struct Renderer {
    listener: Listener,
    settings: RenderSettings,
    pending: BTreeMap<BlockKey, Vec<ReceivedPulse>>,
    tables: BTreeMap<usize, Arc<BlockTables>>,
    interpolations: BTreeMap<InterpolationKey, KeptInterpolation>,
    interpolation_bytes: usize,
    planner: RealFftPlanner<f64>,
    handed_out: i64,
    report: RenderReport,
}

/// Address of a field, bits of R/c, and length of the block.
type InterpolationKey = (usize, u64, usize);

/// An interpolation that the next click of the body may use.
struct KeptInterpolation {
    table: Arc<Interpolation>,
    /// Kept so that no other field gets its address.
    _source: Arc<FieldSource>,
}

/// Place of a block; blocks are rendered and added in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct BlockKey {
    first: i64,
    length: usize,
    receiver: usize,
}

/// A click as a receiver hears it.
#[derive(Clone, Debug)]
struct ReceivedPulse {
    body: BodyId,
    sound: HeardSound,
}

#[derive(Clone, Debug)]
enum HeardSound {
    /// To be computed in frequency.
    Waves {
        direct: Box<(Wave, f64)>,
        /// The floor's reflection, where it overlaps the direct wave.
        reflected: Option<Box<(Wave, f64)>>,
    },
    /// Computed in time.
    Samples(Samples),
}

/// What all blocks of one length share.
struct BlockTables {
    grid: Grid,
    /// Nothing where nothing is lost.
    losses: Option<Losses>,
    inverse: Arc<dyn ComplexToReal<f64>>,
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
                settings.floor.check(listener, position, key.time)?;
            }
        }
        Ok(Renderer {
            listener: listener.clone(),
            settings: *settings,
            pending: BTreeMap::new(),
            tables: BTreeMap::new(),
            interpolations: BTreeMap::new(),
            interpolation_bytes: 0,
            planner: RealFftPlanner::new(),
            handed_out: i64::MIN,
            report: RenderReport::default(),
        })
    }

    /// Takes a click. The order of calls is the order of summation: keep it for the same bits. Clicks that
    /// have died away before sample 0 are not rendered.
    ///
    /// # Errors
    /// Numbers that are not finite, a click too long for any block or too late for its block, a moving
    /// receiver that is below the floor when it hears the click.
    pub fn push(&mut self, click: &AccelerationPulse) -> Result<(), SynthesisError> {
        click.check()?;
        self.report.clicks += 1;
        let floor = self.settings.floor;
        let is_ground = matches!(click.source, SoundSource::Ground { .. });
        // A point of the ground may be on the floor, but for rounding.
        let depth = if is_ground { 2e-6 } else { 0.0 };
        if floor.mirrored(click.centre).is_some_and(|mirrored| mirrored.y > click.centre.y + depth) {
            self.report.below_floor += 1;
            return Ok(());
        }
        if let SoundSource::Field(source) = &click.source {
            let band_end = source.max_frequency(self.settings.medium.sound_speed);
            if band_end < self.settings.band().0 {
                self.report.band_ends.insert(click.body, band_end);
            }
        }
        for receiver in 0..self.listener.receivers.len() {
            if let SoundSource::Pan(source) = &click.source {
                self.push_pan(click, source, receiver)?;
                continue;
            }
            let Some(direct) = self.wave(click, receiver, false)? else {
                continue;
            };
            let reflected = match floor {
                // The ground is the boundary: its sound has been reflected where it begins.
                _ if is_ground => None,
                Floor::None => None,
                Floor::Rigid { .. } => match self.wave(click, receiver, true)? {
                    None => continue,
                    wave => wave,
                },
            };
            // Waves that overlap are one sound, whose energy is not the sum of theirs.
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

    /// All blocks that are left, in order.
    pub fn take_all(&mut self) -> Vec<BlockJob> {
        self.take_before(i64::MAX)
    }

    /// Samples before this one are complete once the blocks handed out so far have been added.
    pub fn complete_until(&self) -> i64 {
        self.handed_out.saturating_sub(REACH as i64)
    }

    /// What was taken so far.
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

    /// From the centre of a click to a receiver that hears it directly or `reflected` by the floor \[m\],
    /// world; `None`, counted, if the receiver, or its mirror image, is inside what sounds.
    fn towards(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
        reflected: bool,
    ) -> Result<Option<DVec3>, SynthesisError> {
        let RenderSettings { medium, floor, .. } = self.settings;
        let mirrored = |point: DVec3| floor.mirrored(point).filter(|_| reflected).unwrap_or(point);
        let from = (mirrored(click.centre), click.source.radius());
        let (heard, position) = self.listener.arrival(receiver, from, click.time, medium.sound_speed);
        floor.check(&self.listener, position, heard)?;
        // What the mirrored source makes at the receiver, the source makes at the mirrored receiver.
        let towards = mirrored(position) - click.centre;
        if click.source.silent_at(click.orientation.inverse() * towards) {
            self.report.receiver_inside += 1;
            self.report.first_inside.get_or_insert((receiver, click.body, click.time));
            return Ok(None);
        }
        Ok(Some(towards))
    }

    /// The wave that reaches a receiver directly or `reflected` by the floor; `None` if there is none.
    fn wave(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
        reflected: bool,
    ) -> Result<Option<ReceivedWave>, SynthesisError> {
        let towards = self.towards(click, receiver, reflected)?;
        Ok(towards.and_then(|towards| self.settings.wave(click, towards)))
    }

    /// The sound of a published model at a receiver, with its reflection by the floor.
    fn push_pan(
        &mut self,
        click: &AccelerationPulse,
        source: &PanSource,
        receiver: usize,
    ) -> Result<(), SynthesisError> {
        let mut sound = Samples::default();
        let reflections: &[bool] = if self.settings.floor == Floor::None { &[false] } else { &[false, true] };
        for &reflected in reflections {
            let Some(towards) = self.towards(click, receiver, reflected)? else { return Ok(()) };
            let place = click.orientation.inverse() * towards;
            sound.add(&source.samples(click, place, &self.settings)?);
        }
        if sound.pressures.is_empty() {
            return Ok(());
        }
        let (first, count) = (sound.first, sound.pressures.len() as f64);
        self.put(click, receiver, first, count, |_, _| HeardSound::Samples(sound))
    }

    /// The interpolation of a field in blocks of this length; nothing once too many are kept.
    fn interpolation(
        &mut self,
        source: &Arc<FieldSource>,
        crossing: f64,
        length: usize,
    ) -> Option<Arc<Interpolation>> {
        let key = (Arc::as_ptr(&source.field) as usize, crossing.to_bits(), length);
        if let Some(kept) = self.interpolations.get(&key) {
            return Some(Arc::clone(&kept.table));
        }
        if self.interpolation_bytes > MAX_INTERPOLATION_BYTES {
            return None;
        }
        let table = Arc::new(Interpolation::of(source, crossing, &self.tables.get(&length)?.grid));
        self.interpolation_bytes += table.size();
        let kept = KeptInterpolation { table: Arc::clone(&table), _source: Arc::clone(source) };
        self.interpolations.insert(key, kept);
        Some(table)
    }

    /// Time between a wave and the floor's \[s\] below which they are one sound: that in which it falls by 50
    /// dB.
    fn overlap(&self, click: &AccelerationPulse) -> f64 {
        let medium = &self.settings.medium;
        let ringing = click.source.ring_time(medium);
        let until_quiet = match &click.source {
            // The ring times of spheres are those of 200 dB, of fields 100 dB.
            SoundSource::Sphere { .. } => 0.25 * ringing,
            // A field begins to be heard before the wave from its centre passes.
            SoundSource::Field(source) => source.radius / medium.sound_speed + 0.5 * ringing,
            SoundSource::Pan(_) | SoundSource::Ground { .. } => ringing,
        };
        click.duration + until_quiet
    }

    /// Puts waves into the block in which they begin to be heard.
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
                    transfer.table = renderer.interpolation(&transfer.source, transfer.crossing, length);
                }
            }
            HeardSound::Waves { direct, reflected }
        })
    }

    /// Puts a sound of so many samples from the `first` into the block in which it begins; `sound` gets the
    /// length of the block.
    fn put(
        &mut self,
        click: &AccelerationPulse,
        receiver: usize,
        first: i64,
        samples: f64,
        sound: impl FnOnce(&mut Self, usize) -> HeardSound,
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
            let grid = Grid::new(length, rate, self.settings.max_frequency);
            let losses = Losses::on(&grid, self.settings.loss);
            Arc::new(BlockTables { grid, losses, inverse })
        });
        let key = BlockKey { first, length, receiver };
        let sound = sound(self, length);
        self.pending.entry(key).or_default().push(ReceivedPulse { body: click.body, sound });
        Ok(())
    }
}

/// Samples between the starts of neighbouring blocks.
fn hop(length: usize) -> i64 {
    (length as i64 / 8).min(SPAN)
}

/// Shortest block that holds a click of so many samples wherever it begins.
fn block_length(samples: f64) -> Option<usize> {
    let fits = |length: &usize| (*length as i64 - hop(*length)) as f64 - 2.0 * REACH as f64 >= samples;
    std::iter::successors(Some(MIN_LENGTH), |length| Some(2 * length))
        .take_while(|length| *length <= MAX_LENGTH)
        .find(fits)
}

/// A block to be rendered: pure data.
pub struct BlockJob {
    key: BlockKey,
    /// Time of the first sample of the buffer \[s\].
    origin: f64,
    clicks: Vec<ReceivedPulse>,
    tables: Arc<BlockTables>,
}

/// Samples of one block.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedBlock {
    /// Which receiver.
    pub receiver: usize,
    /// Index of the first sample; may be negative.
    pub first_sample: i64,
    /// Pressure \[Pa\].
    pub samples: Vec<f64>,
    /// ∫ p² dt [Pa² s] of each click by itself, with the body that made it.
    pub energies: Vec<(BodyId, f64)>,
    /// Estimates of the same above the band of the fields, for clicks that lack some of it.
    pub missing_energies: Vec<(BodyId, f64)>,
}

/// Memory for rendering, to be used again by the next block.
#[derive(Default)]
pub struct BlockMemory {
    sum: Spectrum,
    one: Spectrum,
    reflection: Spectrum,
    player: FieldPlayer,
    bins: Vec<Complex<f64>>,
    transform: Vec<Complex<f64>>,
}

impl BlockJob {
    /// Renders the block. Depends on nothing but the block.
    pub fn render(&self) -> RenderedBlock {
        self.render_with(&mut BlockMemory::default())
    }

    /// Renders the block, in memory that another may have used.
    pub fn render_with(&self, memory: &mut BlockMemory) -> RenderedBlock {
        Arch::new().dispatch(Rendering { job: self, memory })
    }
}

/// One copy of the loops for the widest vector instructions of this machine.
struct Rendering<'a> {
    job: &'a BlockJob,
    memory: &'a mut BlockMemory,
}

impl WithSimd for Rendering<'_> {
    type Output = RenderedBlock;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> RenderedBlock {
        let Rendering { job: BlockJob { key, origin, clicks, tables }, memory } = self;
        let BlockTables { grid, losses, inverse } = &**tables;
        let BlockMemory { sum, one, reflection, player, bins, transform } = memory;
        let mut energies = Vec::with_capacity(clicks.len());
        let mut missing_energies = Vec::new();
        sum.clear(grid);
        let mut heard = Vec::new();
        let rate = grid.spacing_hz * key.length as f64;
        for ReceivedPulse { body, sound } in clicks {
            let ((direct, distance), reflected) = match sound {
                HeardSound::Waves { direct, reflected } => (&**direct, reflected.as_deref()),
                HeardSound::Samples(samples) => {
                    energies.push((*body, samples.energy(rate)));
                    heard.push(samples);
                    continue;
                }
            };
            one.clear(grid);
            one.add_wave(simd, grid, direct, *origin, player);
            if let Some(losses) = losses {
                losses.apply(one, *distance);
            }
            match (reflected, losses) {
                (None, _) => {}
                (Some((wave, _)), None) => one.add_wave(simd, grid, wave, *origin, player),
                (Some((wave, distance)), Some(losses)) => {
                    reflection.clear(grid);
                    reflection.add_wave(simd, grid, wave, *origin, player);
                    losses.apply(reflection, *distance);
                    one.add(reflection);
                }
            }
            energies.push((*body, grid.energy(one)));
            if let Transfer::Field(_) = &direct.transfer {
                let missing = player.missing_energy(grid, one, direct);
                if missing > 0.0 {
                    missing_energies.push((*body, missing));
                }
            }
            if clicks.len() == 1 {
                std::mem::swap(sum, one);
            } else {
                sum.add(one);
            }
        }
        let mut samples = inverse.make_output_vec();
        sum.transform(grid, &**inverse, (bins, transform), &mut samples);
        let first_sample = key.first - REACH as i64;
        heard.into_iter().for_each(|sound| sound.add_to(&mut samples, first_sample));
        RenderedBlock { receiver: key.receiver, first_sample, samples, energies, missing_energies }
    }
}
