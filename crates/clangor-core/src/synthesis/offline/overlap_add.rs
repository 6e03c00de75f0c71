//! Adds rendered blocks into one continuous signal per receiver.

use std::collections::BTreeMap;

use super::block::RenderedBlock;
use crate::body::BodyId;

/// A signal under construction: samples from a first index on, up to the end of the last block.
#[derive(Clone, Debug)]
pub struct OverlapAdd {
    channels: Vec<Vec<f64>>,
    first: i64,
    energies: BTreeMap<BodyId, f64>,
    missing_energies: BTreeMap<BodyId, f64>,
}

impl OverlapAdd {
    /// A silent signal of `receivers` channels that begins with sample `first`; earlier samples are
    /// discarded.
    pub fn new(receivers: usize, first: i64) -> Self {
        OverlapAdd {
            channels: vec![Vec::new(); receivers],
            first,
            energies: BTreeMap::new(),
            missing_energies: BTreeMap::new(),
        }
    }

    /// Adds a block. Blocks in the renderer's order give the same bits every time.
    pub fn add(&mut self, block: &RenderedBlock) {
        for (body, energy) in &block.energies {
            *self.energies.entry(*body).or_default() += energy;
        }
        for (body, energy) in &block.missing_energies {
            *self.missing_energies.entry(*body).or_default() += energy;
        }
        let skip = (self.first - block.first_sample).clamp(0, block.samples.len() as i64) as usize;
        let samples = &block.samples[skip..];
        if samples.is_empty() {
            return;
        }
        let at = (block.first_sample + skip as i64 - self.first) as usize;
        let channel = &mut self.channels[block.receiver];
        if channel.len() < at + samples.len() {
            channel.resize(at + samples.len(), 0.0);
        }
        channel[at..].iter_mut().zip(samples).for_each(|(sum, sample)| *sum += sample);
    }

    /// Takes the samples \[Pa\] from the first one held up to `end`, one vector per receiver. Samples without
    /// a block are silent.
    pub fn take_until(&mut self, end: i64) -> Vec<Vec<f64>> {
        let count = (end - self.first).max(0) as usize;
        self.first = self.first.max(end);
        let take = |channel: &mut Vec<f64>| {
            let rest = channel.split_off(count.min(channel.len()));
            let mut taken = std::mem::replace(channel, rest);
            taken.resize(count, 0.0);
            taken
        };
        self.channels.iter_mut().map(take).collect()
    }

    /// Index of the first sample held.
    pub fn first(&self) -> i64 {
        self.first
    }

    /// Sum of ∫ p² dt [Pa² s] over the clicks of each body and all receivers, blocks before the first sample
    /// included.
    pub fn energies(&self) -> &BTreeMap<BodyId, f64> {
        &self.energies
    }

    /// Estimate of the same above the band of the fields, for bodies whose field ends within the band
    /// rendered.
    pub fn missing_energies(&self) -> &BTreeMap<BodyId, f64> {
        &self.missing_energies
    }
}
