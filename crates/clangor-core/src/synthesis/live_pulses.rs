//! Acceleration pulses in real time: the pressure of each pulse is added at once to the samples to come.
//!
//! The spectra are those of [`offline`](super::offline), with one inverse FFT for each wave, in blocks of 256
//! to 4096 samples. After [`LivePulses::new`] nothing is allocated and nothing waits. A click takes
//! microseconds, independent of earlier clicks.
//!
//! The low-pass looks ahead: a click begins [`LOOK_AHEAD`] samples before its wave. Samples that have been
//! taken already cannot be changed, so a late beginning is lost. The caller delays all events by that and the
//! length of a block.
//!
//! A wave may come by several paths, each with its own loss ([`PropagationPaths`]), and be added to several
//! outputs.
//!
//! Differs from the offline renderer: a listener in the bounding sphere of a body gets the field on the
//! sphere. The ground and the papers' representations of a field are not rendered.

mod live_field;

use std::sync::Arc;

use clangor_fourier::{ComplexToReal, Planner};
use glam::DVec3;
use num_complex::Complex;
use pulp::{Arch, Simd, WithSimd};

pub use self::live_field::LiveField;
use super::SynthesisError;
use super::field_spectrum::FieldPlayer;
use super::history_spectra::HistorySpectra;
use super::lowpass::REACH;
use super::offline::block_length::MIN_LENGTH;
use super::render_settings::RenderSettings;
use super::source::SoundSource;
use super::spectrum::{Grid, Losses, Spectrum};
use super::wave::{Transfer, WaveMemory};
use crate::contact::hertz_pulse;
use crate::propagation::PropagationPaths;
use crate::synthesis::acceleration_pulse::AccelerationPulse;
use crate::synthesis::received_wave::ReceivedWave;

/// Samples by which a click begins before its wave.
pub const LOOK_AHEAD: usize = REACH;
/// Longest block \[samples\]; longer clicks are rejected.
const LONGEST: usize = 4096;

/// Counts of waves by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiveReport {
    /// Waves that were added: one for each click, receiver and reflection.
    pub waves: u64,
    /// Waves whose beginning came too late.
    pub late: u64,
    /// Waves that begin after all samples that are kept, from too far away.
    pub distant: u64,
    /// Waves of clicks with numbers that are not finite, or of unknown sources.
    pub refused: u64,
    /// Waves of clicks with the receiver inside the body.
    pub inside: u64,
}

/// See the module.
pub struct LivePulses {
    settings: RenderSettings,
    lengths: Vec<Length>,
    fields: Vec<Option<LiveField>>,
    coming: Vec<Coming>,
    memory: Memory,
    report: LiveReport,
}

/// Tables shared by all blocks of one length.
struct Length {
    grid: Grid,
    /// Loss of each path.
    losses: Vec<Option<Losses>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

/// The samples to come at one output, in a ring buffer.
struct Coming {
    samples: Vec<f64>,
    /// Index of the next sample to be taken.
    next: i64,
}

#[derive(Default)]
struct Memory {
    spectrum: Spectrum,
    /// Not used for spheres.
    player: FieldPlayer,
    spectra: HistorySpectra,
    bins: Vec<Complex<f64>>,
    transform: Vec<Complex<f64>>,
    samples: Vec<f64>,
}

/// The grids of all lengths of blocks.
fn grids(settings: &RenderSettings) -> impl Iterator<Item = (usize, Grid)> + '_ {
    let lengths = std::iter::successors(Some(MIN_LENGTH), |length| Some(2 * length));
    let grid = |length| Grid::new(length, settings.sample_rate.as_f64(), settings.acoustics.max_frequency);
    lengths.take_while(|length| *length <= LONGEST).map(move |length| (length, grid(length)))
}

impl LivePulses {
    /// Silence at this number of outputs from sample 0 on, for clicks of spheres and of up to `fields`
    /// fields. Each path has its own loss. The buffer holds `seconds`, which is also the longest delay of a
    /// path.
    ///
    /// # Errors
    /// A medium that carries no sound, a band limit of nothing.
    pub fn new(
        settings: &RenderSettings,
        paths: &PropagationPaths,
        fields: usize,
        outputs: usize,
        seconds: f64,
    ) -> Result<Self, SynthesisError> {
        settings.check()?;
        let mut planner = Planner::new();
        let lengths: Vec<Length> = grids(settings)
            .map(|(length, grid)| {
                let losses = paths.losses().map(|loss| Losses::on(&grid, *loss)).collect();
                Length { grid, losses, inverse: planner.inverse(length) }
            })
            .collect();
        let kept = ((seconds * settings.sample_rate.as_f64()) as usize + 2 * LONGEST).next_power_of_two();
        let coming = (0..outputs).map(|_| Coming { samples: vec![0.0; kept], next: 0 }).collect();
        let mut clicks = LivePulses {
            settings: *settings,
            lengths,
            fields: (0..fields).map(|_| None).collect(),
            coming,
            memory: Memory::default(),
            report: LiveReport::default(),
        };
        clicks.warm();
        Ok(clicks)
    }

    /// Lets all memory grow to what it will ever need.
    fn warm(&mut self) {
        let bins = self.lengths.iter().map(|length| length.grid.omega.len()).max();
        self.memory.spectra.reserve(bins.unwrap_or(0));
        hertz_pulse::prepare();
        for length in &self.lengths {
            let memory = &mut self.memory;
            memory.spectrum.clear(&length.grid);
            memory.bins.resize(length.inverse.complex_len(), Complex::ZERO);
            memory.transform.resize(length.inverse.get_scratch_len(), Complex::ZERO);
            memory.samples.resize(length.inverse.len(), 0.0);
        }
    }

    /// Puts a field into one of the places for fields, and returns the previous one. If the place does not
    /// exist, returns the field itself.
    pub fn put_field(&mut self, place: usize, field: Option<LiveField>) -> Option<LiveField> {
        match self.fields.get_mut(place) {
            Some(held) => std::mem::replace(held, field),
            None => field,
        }
    }

    /// The first sample of a click from `towards` \[m\], the path from its centre to a receiver; `None`, and
    /// counted, for a click that cannot be rendered.
    pub fn first_sample(&mut self, click: &AccelerationPulse, towards: DVec3) -> Option<i64> {
        let is_ground = matches!(click.source, SoundSource::Ground { .. });
        if click.check().is_err() || !towards.is_finite() || is_ground {
            self.report.refused += 1;
            return None;
        }
        if click.source.silent_at(click.orientation.inverse() * towards) {
            self.report.inside += 1;
            return None;
        }
        let heard =
            self.settings.wave(click, towards).filter(|heard| self.samples_of(heard) <= LONGEST as f64);
        if heard.is_none() {
            self.report.refused += 1;
        }
        heard.map(|heard| self.sample_of(heard.from) - REACH as i64)
    }

    /// Length of a wave \[samples\], with the reach of the band limit.
    fn samples_of(&self, heard: &ReceivedWave) -> f64 {
        (heard.until - heard.from) * self.settings.sample_rate.as_f64() + 2.0 * REACH as f64 + 1.0
    }

    fn sample_of(&self, time: f64) -> i64 {
        ((time - self.settings.start) * self.settings.sample_rate.as_f64()).floor() as i64
    }

    /// Adds the wave of a click that runs `towards` a receiver \[m\] along a path to some outputs, with a
    /// factor each. It must have a [`first_sample`](Self::first_sample).
    pub fn play(&mut self, click: &AccelerationPulse, towards: DVec3, path: usize, outputs: &[(usize, f64)]) {
        // Wave in closed form, and the shortest block that holds it.
        let rate = self.settings.sample_rate.as_f64();
        let heard = self.settings.wave(click, towards).map(|heard| (self.samples_of(&heard), heard));
        let fits = |samples: f64| self.lengths.iter().position(|l| l.inverse.len() as f64 >= samples);
        let Some((at, mut heard)) = heard.and_then(|(samples, heard)| Some((fits(samples)?, heard))) else {
            self.report.refused += 1;
            return;
        };
        let first = self.sample_of(heard.from);
        let length = &self.lengths[at];
        let Memory { spectrum, spectra, player, bins, transform, samples } = &mut self.memory;
        let mut player = player;
        // A field needs its interpolation for this block length.
        if let Transfer::Field(transfer) = &mut heard.wave.transfer {
            let known = self.fields.iter_mut().flatten().find(|field| field.is_of(&transfer.source));
            let Some(field) = known else {
                self.report.refused += 1;
                return;
            };
            player = field.prepare(transfer, at);
        }
        // The wave must end within the buffers.
        let end = first + length.inverse.len() as i64;
        let ends = |coming: &Coming| coming.next + coming.samples.len() as i64;
        if outputs.iter().any(|(output, _)| end > ends(&self.coming[*output])) {
            self.report.distant += 1;
            return;
        }
        self.report.waves += 1;
        self.report.late += u64::from(outputs.iter().any(|(output, _)| first < self.coming[*output].next));
        // Spectrum of the wave with the loss of its path.
        let begin = first - REACH as i64;
        let origin = self.settings.start + begin as f64 / rate;
        Arch::new().dispatch(Playing {
            grid: &length.grid,
            losses: length.losses[path].as_ref(),
            heard: &heard,
            origin,
            memory: WaveMemory { player, spectra },
            spectrum,
        });
        // Inverse transform, added to each output.
        let samples = &mut samples[..length.inverse.len()];
        spectrum.transform(&length.grid, &*length.inverse, (bins, transform), samples);
        for (output, factor) in outputs {
            self.coming[*output].add(begin, *factor, samples);
        }
    }

    /// Drops all samples to come.
    pub fn silence(&mut self) {
        self.coming.iter_mut().for_each(|coming| coming.samples.fill(0.0));
    }

    /// Adds the next samples \[Pa\] of an output to `samples`, and removes them.
    pub fn take(&mut self, output: usize, samples: &mut [f64]) {
        let coming = &mut self.coming[output];
        let mask = coming.samples.len() - 1;
        for sample in samples {
            *sample += std::mem::take(&mut coming.samples[coming.next as usize & mask]);
            coming.next += 1;
        }
    }

    /// Counts of waves so far.
    pub fn report(&self) -> LiveReport {
        self.report
    }
}

impl Coming {
    /// Adds samples times a factor; the first has this index. Samples already taken are skipped.
    fn add(&mut self, first: i64, factor: f64, samples: &[f64]) {
        let mask = self.samples.len() - 1;
        let skip = (self.next - first).clamp(0, samples.len() as i64) as usize;
        let start = (first + skip as i64) as usize;
        for (k, sample) in samples[skip..].iter().enumerate() {
            self.samples[(start + k) & mask] += factor * sample;
        }
    }
}

/// One copy of the loops for the widest vector instructions of this machine.
struct Playing<'a> {
    grid: &'a Grid,
    losses: Option<&'a Losses>,
    heard: &'a ReceivedWave,
    origin: f64,
    memory: WaveMemory<'a>,
    spectrum: &'a mut Spectrum,
}

impl WithSimd for Playing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Playing { grid, losses, heard, origin, mut memory, spectrum } = self;
        spectrum.clear(grid);
        heard.wave.add_to(simd, spectrum, grid, origin, &mut memory);
        if let Some(losses) = losses {
            losses.apply(spectrum, heard.distance);
        }
    }
}
