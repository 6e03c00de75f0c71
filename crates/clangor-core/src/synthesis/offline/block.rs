//! Time blocks: the clicks that begin in one, and their samples by one inverse transform.
//!
//! A block depends on nothing but its clicks, so blocks can be rendered on any threads.

use std::sync::Arc;

use clangor_fourier::ComplexToReal;
use num_complex::Complex;
use pulp::{Arch, Simd, WithSimd};

use crate::body::BodyId;
use crate::synthesis::field_spectrum::FieldPlayer;
use crate::synthesis::history_spectra::HistorySpectra;
use crate::synthesis::lowpass::REACH;
use crate::synthesis::sampled_sound::SampledSound;
use crate::synthesis::spectrum::{Grid, Losses, Spectrum};
use crate::synthesis::wave::{Transfer, Wave, WaveMemory};

/// Place of a block; blocks are rendered and added in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct BlockKey {
    /// First sample of its span.
    pub(super) first: i64,
    /// Samples of its buffer.
    pub(super) length: usize,
    pub(super) receiver: usize,
}

/// A click at a receiver.
#[derive(Clone, Debug)]
pub(super) struct ReceivedPulse {
    pub(super) body: BodyId,
    pub(super) sound: ReceivedSound,
}

/// The sound of a click at a receiver.
#[derive(Clone, Debug)]
pub(super) enum ReceivedSound {
    /// Computed in the frequency domain: waves that overlap, by one path each.
    Waves(Vec<PathWave>),
    /// Computed in the time domain.
    Samples(SampledSound),
}

/// A wave that arrives by one path.
#[derive(Clone, Debug)]
pub(super) struct PathWave {
    pub(super) wave: Wave,
    /// Length of the path \[m\].
    pub(super) distance: f64,
    pub(super) path: usize,
}

/// Tables shared by all blocks of one length.
pub(super) struct BlockTables {
    pub(super) grid: Grid,
    /// Losses of each path; `None` without losses.
    pub(super) losses: Vec<Option<Losses>>,
    pub(super) inverse: Arc<dyn ComplexToReal<f64>>,
}

/// A block ready to be rendered, without references to the renderer.
pub struct BlockJob {
    pub(super) key: BlockKey,
    /// Time of the first sample of the buffer \[s\].
    pub(super) origin: f64,
    pub(super) clicks: Vec<ReceivedPulse>,
    pub(super) tables: Arc<BlockTables>,
}

/// Samples of one block.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedBlock {
    /// Index of the receiver.
    pub receiver: usize,
    /// Index of the first sample; may be negative.
    pub first_sample: i64,
    /// Pressure \[Pa\].
    pub samples: Vec<f64>,
    /// ∫ p² dt [Pa² s] of each click alone, with the body that made it.
    pub energies: Vec<(BodyId, f64)>,
    /// Estimates of the same above the band of the fields, for clicks with components there.
    pub missing_energies: Vec<(BodyId, f64)>,
}

/// Working memory of a rendering, reusable for the next block.
#[derive(Default)]
pub struct BlockMemory {
    sum: Spectrum,
    one: Spectrum,
    reflection: Spectrum,
    player: FieldPlayer,
    spectra: HistorySpectra,
    bins: Vec<Complex<f64>>,
    transform: Vec<Complex<f64>>,
}

impl BlockJob {
    /// Renders the block. The result depends on nothing but the block.
    pub fn render(&self) -> RenderedBlock {
        self.render_with(&mut BlockMemory::default())
    }

    /// Renders the block with reused working memory.
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
        let BlockMemory { sum, one, reflection, player, spectra, bins, transform } = memory;
        let mut waves_memory = WaveMemory { player, spectra };
        let memory = &mut waves_memory;
        let mut energies = Vec::with_capacity(clicks.len());
        let mut missing_energies = Vec::new();
        sum.clear(grid);
        let mut sampled = Vec::new();
        let rate = grid.spacing_hz * key.length as f64;
        for ReceivedPulse { body, sound } in clicks {
            let waves = match sound {
                ReceivedSound::Waves(waves) => waves,
                ReceivedSound::Samples(samples) => {
                    energies.push((*body, samples.energy(rate)));
                    sampled.push(samples);
                    continue;
                }
            };
            one.clear(grid);
            for (index, PathWave { wave, distance, path }) in waves.iter().enumerate() {
                match &losses[*path] {
                    None => wave.add_to(simd, one, grid, *origin, memory),
                    Some(losses) if index == 0 => {
                        wave.add_to(simd, one, grid, *origin, memory);
                        losses.apply(one, *distance);
                    }
                    Some(losses) => {
                        reflection.clear(grid);
                        wave.add_to(simd, reflection, grid, *origin, memory);
                        losses.apply(reflection, *distance);
                        one.add(reflection);
                    }
                }
            }
            energies.push((*body, grid.energy(one)));
            if let Some(PathWave { wave, .. }) = waves.first()
                && let Transfer::Field(_) = &wave.transfer
            {
                let missing = memory.player.missing_energy(grid, one, (&wave.shape, wave.duration));
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
        sampled.into_iter().for_each(|sound| sound.add_to(&mut samples, first_sample));
        RenderedBlock { receiver: key.receiver, first_sample, samples, energies, missing_energies }
    }
}
