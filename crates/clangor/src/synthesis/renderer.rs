//! Sorts clicks into time blocks and turns blocks into samples.
//!
//! A click belongs to the block in which it begins to be heard. A block's buffer holds, before its own span, the reach
//! of the band limit, and after it the longest click of its length class and the reach again. Short clicks use short
//! blocks, because a click costs one pass over the bins of its block: lengths are 256 samples times a power of two, the
//! smallest that fits.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner};

use super::click::Click;
use super::listener::{Floor, Listener};
use super::lowpass::REACH;
use super::spectrum::{Grid, Wave};
use super::{SampleRate, SynthesisError};
use crate::body::BodyId;
use crate::medium::Medium;
use crate::model::sphere_radiation::{SphereModel, SphereTransfer};

/// Blocks are handed out in whole spans of this many samples, so that their order never depends on when.
const SPAN: i64 = 1 << 16;
/// Shortest block \[samples\].
const MIN_LENGTH: usize = 256;
/// Longest block \[samples\]: 11 s at 384 kHz.
const MAX_LENGTH: usize = 1 << 22;
/// Ringing is followed until it has fallen by e^−23 = 1e-10.
const DECAY_FOLDS: f64 = 23.0;

/// How to render.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderSettings {
    /// Samples per second.
    pub sample_rate: SampleRate,
    /// Time of sample 0 \[s\].
    pub start: f64,
    /// What carries the sound.
    pub medium: Medium,
    /// What reflects it.
    pub floor: Floor,
    /// Field of an accelerated sphere.
    pub sphere_model: SphereModel,
    /// Highest frequency that is rendered in full \[Hz\]; by default what the sample rate holds.
    pub max_frequency: Option<f64>,
}

/// What was heard, and what could not be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderReport {
    /// Clicks taken.
    pub clicks: u64,
    /// Clicks left out at a receiver because it was inside the sphere that stands for the body.
    pub receiver_inside: u64,
    /// The first of them: receiver, body, time of the click \[s\].
    pub first_inside: Option<(usize, BodyId, f64)>,
    /// Clicks left out because the body's centre was below the rigid floor.
    pub below_floor: u64,
}

/// Takes clicks, gives blocks.
pub struct Renderer {
    listener: Listener,
    settings: RenderSettings,
    pending: BTreeMap<BlockKey, Vec<HeardClick>>,
    tables: BTreeMap<usize, Arc<BlockTables>>,
    planner: RealFftPlanner<f64>,
    handed_out: i64,
    report: RenderReport,
}

/// Place of a block; blocks are rendered and added in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct BlockKey {
    first: i64,
    length: usize,
    receiver: usize,
}

/// A click as a receiver hears it.
#[derive(Clone, Copy, Debug)]
struct HeardClick {
    body: BodyId,
    direct: Wave,
    /// The floor's reflection, where it overlaps the direct wave.
    reflected: Option<Wave>,
}

/// What all blocks of one length share.
struct BlockTables {
    grid: Grid,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl Renderer {
    /// A renderer for one listener.
    ///
    /// # Errors
    /// A listener without receivers or below the floor, a medium that carries no sound.
    pub fn new(listener: &Listener, settings: &RenderSettings) -> Result<Self, SynthesisError> {
        let Medium { density, sound_speed } = settings.medium;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !positive(density) || !positive(sound_speed) {
            return Err(SynthesisError::BadMedium { density, sound_speed });
        }
        if let Some(hz) = settings.max_frequency.filter(|hz| !positive(*hz)) {
            return Err(SynthesisError::MaxFrequency { hz });
        }
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
            planner: RealFftPlanner::new(),
            handed_out: i64::MIN,
            report: RenderReport::default(),
        })
    }

    /// Takes a click. The order of calls is the order of summation: keep it for the same bits. Clicks that have died
    /// away before sample 0 are not rendered.
    ///
    /// # Errors
    /// Numbers that are not finite, a click too long for any block or too late for its block, a moving receiver that
    /// is below the floor when it hears the click.
    pub fn push(&mut self, click: &Click) -> Result<(), SynthesisError> {
        click.check()?;
        self.report.clicks += 1;
        let image = self.settings.floor.mirrored(click.centre, click.velocity_change);
        if image.is_some_and(|(mirrored, _)| mirrored.y > click.centre.y) {
            self.report.below_floor += 1;
            return Ok(());
        }
        for receiver in 0..self.listener.receivers.len() {
            let Some(direct) = self.wave(click, receiver, (click.centre, click.velocity_change))? else {
                continue;
            };
            let reflected = match image {
                None => None,
                Some(source) => match self.wave(click, receiver, source)? {
                    None => continue,
                    wave => wave,
                },
            };
            // Waves that overlap are one sound, whose energy is not the sum of theirs.
            let lag = reflected.map_or(0.0, |r| r.middle - direct.middle);
            let overlap = click.duration
                + SphereTransfer::decay_time(&self.settings.medium, click.radius, 0.25 * DECAY_FOLDS);
            match reflected {
                Some(reflected) if lag > overlap => {
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
        let sample = (time - self.settings.start) * self.settings.sample_rate.as_f64();
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
        let job = |(key, clicks): (BlockKey, Vec<HeardClick>)| BlockJob {
            origin: self.settings.start + (key.first - REACH as i64) as f64 / rate,
            tables: Arc::clone(&self.tables[&key.length]),
            key,
            clicks,
        };
        ready.into_iter().map(job).collect()
    }

    /// The wave from a source (centre, velocity change) to a receiver; `None`, counted, if that is inside the sphere.
    fn wave(
        &mut self,
        click: &Click,
        receiver: usize,
        (centre, velocity_change): (DVec3, DVec3),
    ) -> Result<Option<Wave>, SynthesisError> {
        let RenderSettings { medium, floor, sphere_model, .. } = self.settings;
        let (heard, position) =
            self.listener.arrival(receiver, (centre, click.radius), click.time, medium.sound_speed);
        floor.check(&self.listener, position, heard)?;
        let towards = position - centre;
        let distance = towards.length();
        if distance < click.radius {
            self.report.receiver_inside += 1;
            self.report.first_inside.get_or_insert((receiver, click.body, click.time));
            return Ok(None);
        }
        // cosθ times the velocity change: the transfer of this wave is for a unit acceleration pulse.
        let along = velocity_change.dot(towards) / distance;
        let transfer = SphereTransfer::new(sphere_model, &medium, click.radius, distance, along);
        let middle = click.time + transfer.delay + 0.5 * click.duration;
        Ok(Some(Wave { transfer, profile: click.profile, duration: click.duration, middle }))
    }

    /// Puts a click into the block in which it begins to be heard.
    fn file(
        &mut self,
        click: &Click,
        receiver: usize,
        direct: Wave,
        reflected: Option<Wave>,
    ) -> Result<(), SynthesisError> {
        let rate = self.settings.sample_rate.as_f64();
        let (begin, end) = click.profile.extent(click.duration);
        let lag = reflected.map_or(0.0, |r| r.middle - direct.middle);
        let seconds =
            end - begin + lag + SphereTransfer::decay_time(&self.settings.medium, click.radius, DECAY_FOLDS);
        let Some(length) = block_length(seconds * rate) else {
            let Click { body, time, radius, .. } = *click;
            return Err(SynthesisError::TooLong { body, time, seconds, radius });
        };
        let heard = direct.middle - 0.5 * click.duration + begin;
        let hop = hop(length);
        let first = ((heard - self.settings.start) * rate / hop as f64).floor() as i64 * hop;
        if first < self.handed_out {
            return Err(SynthesisError::Late { body: click.body, time: click.time });
        }
        if first - REACH as i64 + length as i64 <= 0 {
            return Ok(());
        }
        self.tables.entry(length).or_insert_with(|| {
            let inverse = self.planner.plan_fft_inverse(length);
            Arc::new(BlockTables { grid: Grid::new(length, rate, self.settings.max_frequency), inverse })
        });
        let key = BlockKey { first, length, receiver };
        self.pending.entry(key).or_default().push(HeardClick { body: click.body, direct, reflected });
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
    clicks: Vec<HeardClick>,
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
}

impl BlockJob {
    /// Renders the block. Depends on nothing but the block.
    pub fn render(&self) -> RenderedBlock {
        let BlockTables { grid, inverse } = &*self.tables;
        let mut sum = grid.spectrum();
        let mut one = grid.spectrum();
        let mut energies = Vec::with_capacity(self.clicks.len());
        for click in &self.clicks {
            one.clear();
            one.add_wave(grid, &click.direct, self.origin);
            if let Some(reflected) = &click.reflected {
                one.add_wave(grid, reflected, self.origin);
            }
            energies.push((click.body, grid.energy(&one)));
            sum.add(&one);
        }
        let mut spectrum = inverse.make_input_vec();
        for (k, bin) in spectrum.iter_mut().take(grid.bins).enumerate() {
            let gain = grid.gain(k) * grid.spacing_hz;
            *bin = Complex::new(gain * sum.re[k], gain * sum.im[k]);
        }
        // The pressure is real, so its mean is; rounding may have left a negative zero.
        spectrum[0].im = 0.0;
        let mut samples = inverse.make_output_vec();
        inverse.process(&mut spectrum, &mut samples).expect("buffers of the plan's own lengths");
        RenderedBlock {
            receiver: self.key.receiver,
            first_sample: self.key.first - REACH as i64,
            samples,
            energies,
        }
    }
}
