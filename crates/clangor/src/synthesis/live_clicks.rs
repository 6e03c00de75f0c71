//! Clicks as they happen: what a click will sound like is added at once to the samples to come.
//!
//! The same spectra as in [`renderer`](super::renderer), one inverse FFT for each wave, in blocks of 256 to 4096 samples. After
//! [`LiveClicks::new`] nothing is allocated and nothing waits: a click takes microseconds, whatever came before.
//!
//! The low-pass looks ahead, and so a click is heard from [`LOOK_AHEAD`] samples before its wave on; what of it should already
//! have been heard is lost. Whoever drives this delays all events by that and the length of a block.
//!
//! Differs from the offline renderer: a listener in the bounding sphere of a body hears the field on it; the ground and
//! the published form of a field are not heard.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use pulp::{Arch, Simd, WithSimd};
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner};

use super::SynthesisError;
use super::click::Click;
use super::field_interpolation::Interpolation;
use super::field_spectrum::FieldPlayer;
use super::heard_wave::HeardWave;
use super::lowpass::REACH;
use super::renderer::{MIN_LENGTH, RenderSettings};
use super::source::{FieldSource, SoundSource};
use super::spectrum::{Grid, Losses, Spectrum, Transfer};
use crate::body::BodyId;
use crate::contact::ForceProfile;

/// Samples by which a click is heard before its wave.
pub const LOOK_AHEAD: usize = REACH;
/// Longest block \[samples\]: longer clicks are cut.
const LONGEST: usize = 4096;

/// What became of the clicks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiveReport {
    /// Waves that were added: one for each click, receiver and reflection.
    pub waves: u64,
    /// Waves of which the beginning came too late.
    pub late: u64,
    /// Waves that begin after all samples that are kept, from too far away.
    pub distant: u64,
    /// Clicks with numbers that are not finite, or of sources that are not known.
    pub refused: u64,
    /// Waves of clicks with the receiver inside the body.
    pub inside: u64,
}

/// See the module.
pub struct LiveClicks {
    settings: RenderSettings,
    lengths: Vec<Length>,
    fields: Vec<KnownField>,
    coming: Vec<Coming>,
    memory: Memory,
    report: LiveReport,
}

/// What all blocks of one length share.
struct Length {
    grid: Grid,
    losses: Option<Losses>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

/// A field that may be played.
struct KnownField {
    /// As it was given.
    source: Arc<FieldSource>,
    /// What is played for it.
    played: Arc<FieldSource>,
    /// For each length.
    tables: Vec<Arc<Interpolation>>,
}

/// The samples to come at one receiver, in a circle.
struct Coming {
    samples: Vec<f64>,
    /// Index of the next one to be taken.
    next: i64,
}

#[derive(Default)]
struct Memory {
    spectrum: Spectrum,
    player: FieldPlayer,
    bins: Vec<Complex<f64>>,
    transform: Vec<Complex<f64>>,
    samples: Vec<f64>,
}

impl LiveClicks {
    /// Silence at so many receivers from sample 0 on, for clicks of spheres and of these fields. Samples of `seconds` to come
    /// are kept, which is also how long sound may be on its way.
    ///
    /// # Errors
    /// A medium that carries no sound, a band limit of nothing.
    pub fn new(
        settings: &RenderSettings,
        fields: &[Arc<FieldSource>],
        receivers: usize,
        seconds: f64,
    ) -> Result<Self, SynthesisError> {
        settings.check()?;
        let rate = settings.sample_rate.as_f64();
        let mut planner = RealFftPlanner::new();
        let lengths: Vec<Length> = std::iter::successors(Some(MIN_LENGTH), |length| Some(2 * length))
            .take_while(|length| *length <= LONGEST)
            .map(|length| {
                let grid = Grid::new(length, rate, settings.max_frequency);
                let losses = Losses::on(&grid, settings.loss);
                Length { grid, losses, inverse: planner.plan_fft_inverse(length) }
            })
            .collect();
        let known = |source: &Arc<FieldSource>| {
            let mut played = FieldSource::clone(source);
            played.near = None;
            let crossing = source.radius / settings.medium.sound_speed;
            let tables = lengths.iter().map(|l| Arc::new(Interpolation::of(&played, crossing, &l.grid)));
            KnownField { source: Arc::clone(source), tables: tables.collect(), played: Arc::new(played) }
        };
        let fields: Vec<KnownField> = fields.iter().map(known).collect();
        let kept = ((seconds * rate) as usize + 2 * LONGEST).next_power_of_two();
        let coming = (0..receivers).map(|_| Coming { samples: vec![0.0; kept], next: 0 }).collect();
        let mut clicks = LiveClicks {
            settings: *settings,
            lengths,
            fields,
            coming,
            memory: Memory::default(),
            report: LiveReport::default(),
        };
        clicks.warm();
        Ok(clicks)
    }

    /// Lets all memory grow to what it will ever need.
    fn warm(&mut self) {
        for at in 0..self.lengths.len() {
            let length = &self.lengths[at];
            let memory = &mut self.memory;
            memory.spectrum.clear(&length.grid);
            memory.bins.resize(length.inverse.complex_len(), Complex::ZERO);
            memory.transform.resize(length.inverse.get_scratch_len(), Complex::ZERO);
            memory.samples.resize(length.inverse.len(), 0.0);
        }
        for field in 0..self.fields.len() {
            let source = Arc::clone(&self.fields[field].source);
            let towards = DVec3::X * (2.0 * source.radius);
            let click = Click {
                body: BodyId(0),
                time: self.settings.start,
                duration: 1e-4,
                profile: ForceProfile::HalfSine,
                centre: DVec3::ZERO,
                orientation: DQuat::IDENTITY,
                velocity_change: DVec3::X,
                angular_velocity_change: DVec3::ZERO,
                source: SoundSource::Field(source),
            };
            self.play(0, &click, towards);
        }
        self.coming.iter_mut().for_each(|coming| coming.samples.fill(0.0));
        self.report = LiveReport::default();
    }

    /// Adds a click as each receiver, which is at one of these places [m, world], hears it.
    pub fn push(&mut self, click: &Click, receivers: &[DVec3]) {
        if click.check().is_err() {
            self.report.refused += 1;
            return;
        }
        let floor = self.settings.floor;
        for (receiver, place) in receivers.iter().enumerate().take(self.coming.len()) {
            self.play(receiver, click, *place - click.centre);
            if let Some(mirrored) = floor.mirrored(*place) {
                self.play(receiver, click, mirrored - click.centre);
            }
        }
    }

    /// Adds the wave of a click that runs `towards` a receiver \[m\].
    fn play(&mut self, receiver: usize, click: &Click, towards: DVec3) {
        if click.source.silent_at(click.orientation.inverse() * towards) {
            self.report.inside += 1;
            return;
        }
        let rate = self.settings.sample_rate.as_f64();
        let Some(mut heard) = self.settings.wave(click, towards) else {
            self.report.refused += 1;
            return;
        };
        let samples = (heard.until - heard.from) * rate + 2.0 * REACH as f64 + 1.0;
        let at = self.lengths.iter().position(|l| l.inverse.len() as f64 >= samples);
        let at = at.unwrap_or(self.lengths.len() - 1);
        if let Transfer::Field(transfer) = &mut heard.wave.transfer {
            let Some(field) = self.fields.iter().find(|f| Arc::ptr_eq(&f.source, &transfer.source)) else {
                self.report.refused += 1;
                return;
            };
            transfer.source = Arc::clone(&field.played);
            transfer.table = Some(Arc::clone(&field.tables[at]));
        }
        let first = ((heard.from - self.settings.start) * rate).floor() as i64;
        let coming = &mut self.coming[receiver];
        let length = &self.lengths[at];
        if first + length.inverse.len() as i64 > coming.next + coming.samples.len() as i64 {
            self.report.distant += 1;
            return;
        }
        self.report.waves += 1;
        self.report.late += u64::from(first < coming.next);
        let origin = self.settings.start + (first - REACH as i64) as f64 / rate;
        Arch::new().dispatch(Playing { length, heard: &heard, origin, memory: &mut self.memory });
        coming.add(first - REACH as i64, &self.memory.samples[..length.inverse.len()]);
    }

    /// Adds the next samples \[Pa\] of a receiver to `samples`, and forgets them.
    pub fn take(&mut self, receiver: usize, samples: &mut [f64]) {
        let coming = &mut self.coming[receiver];
        let mask = coming.samples.len() - 1;
        for sample in samples {
            *sample += std::mem::take(&mut coming.samples[coming.next as usize & mask]);
            coming.next += 1;
        }
    }

    /// Index of the sample that a receiver takes next.
    pub fn next_sample(&self, receiver: usize) -> i64 {
        self.coming[receiver].next
    }

    /// What became of the clicks so far.
    pub fn report(&self) -> LiveReport {
        self.report
    }
}

impl Coming {
    /// Adds samples of which the first has this index; what has been taken already is lost.
    fn add(&mut self, first: i64, samples: &[f64]) {
        let mask = self.samples.len() - 1;
        let skip = (self.next - first).clamp(0, samples.len() as i64) as usize;
        let start = (first + skip as i64) as usize;
        for (k, sample) in samples[skip..].iter().enumerate() {
            self.samples[(start + k) & mask] += sample;
        }
    }
}

/// One copy of the loops for the widest vector instructions of this machine.
struct Playing<'a> {
    length: &'a Length,
    heard: &'a HeardWave,
    origin: f64,
    memory: &'a mut Memory,
}

impl WithSimd for Playing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Playing { length: Length { grid, losses, inverse }, heard, origin, memory } = self;
        let Memory { spectrum, player, bins, transform, samples } = memory;
        spectrum.clear(grid);
        spectrum.add_wave(simd, grid, &heard.wave, origin, player);
        if let Some(losses) = losses {
            losses.apply(spectrum, heard.distance);
        }
        spectrum.transform(grid, &**inverse, (bins, transform), &mut samples[..inverse.len()]);
    }
}
