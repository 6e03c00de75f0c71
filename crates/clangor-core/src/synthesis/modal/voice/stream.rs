//! Force streams as input of the modes of a body.
//!
//! The dynamics compute these forces once per time step, so they are limited to half the rate of the steps.
//! The impulse of each step becomes the impulse response of that band limit. One response is tabulated for
//! each of [`FRACTIONS`] places between two samples.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;

use crate::contact::{StreamPoint, StreamedForce};
use crate::synthesis::RenderSettings;
use crate::synthesis::modal::drive::{ForceSamples, Shaper};
use crate::synthesis::modal::resonator_bank::ResonatorBank;
use crate::synthesis::modal::source::{ModalSource, StrikeMemory};

/// Resolution of impulse times, as a fraction of a sample.
const FRACTIONS: i64 = 1024;

/// Queue of forces to come.
pub(super) struct Stream {
    shaper: Shaper,
    /// Samples of impulses at fractions of a sample, and their first samples.
    sampled: BTreeMap<i64, (i64, Arc<ForceSamples>)>,
    /// By first sample, the next one last.
    forces: Vec<StreamForce>,
    /// Length of a time step \[samples\].
    step: f64,
    /// Whether contacts add damping in the present block.
    damps: bool,
    amplitudes: Vec<f64>,
    striking: StrikeMemory,
    points: Vec<(DVec3, DVec3)>,
    decay: Vec<f64>,
}

struct StreamForce {
    /// First sample that it affects \[samples\].
    first: i64,
    /// Time of action, in fractions of a sample.
    at: i64,
    points: Vec<StreamPoint>,
}

impl Stream {
    /// Forces, all of finite numbers, on one body, known at steps of `time_step` \[s\].
    pub(super) fn new<'f>(
        forces: impl Iterator<Item = &'f StreamedForce>,
        time_step: f64,
        settings: &RenderSettings,
    ) -> Self {
        let rate = settings.sample_rate.as_f64();
        let (low, high) = settings.band();
        let half_width = (0.5 * (high - low)).min(0.1 / time_step);
        let centre = (0.5 * (low + high)).min(0.5 / time_step - half_width);
        let shaper = Shaper::new(rate, centre, half_width);
        let mut forces: Vec<StreamForce> = forces
            .map(|force| {
                let at = ((force.time - settings.start) * rate * FRACTIONS as f64).round() as i64;
                let first = at.div_euclid(FRACTIONS) - shaper.reach();
                StreamForce { first, at, points: force.points.clone() }
            })
            .collect();
        forces.sort_by_key(|force| Reverse(force.first));
        Stream {
            shaper,
            sampled: BTreeMap::new(),
            forces,
            step: time_step * rate,
            damps: false,
            amplitudes: Vec::new(),
            striking: StrikeMemory::default(),
            points: Vec::new(),
            decay: Vec::new(),
        }
    }

    /// First sample affected by a force to come.
    pub(super) fn next(&self) -> Option<i64> {
        self.forces.last().map(|force| force.first)
    }

    /// Applies the forces that act before `end` to the modes. Contacts made in a block of this length
    /// \[samples\] damp the modes from its beginning, a little early. Returns whether the damping changed.
    pub(super) fn take(
        &mut self,
        end: i64,
        block: i64,
        source: &ModalSource,
        bank: &mut ResonatorBank,
    ) -> bool {
        let contact_damping = source.contact_damping() > 0.0;
        self.decay.clear();
        self.decay.resize(source.resonances().len(), 0.0);
        let part = self.step / block as f64;
        let mut touches = false;
        while let Some(force) = self.forces.pop_if(|force| force.first < end) {
            if contact_damping {
                touches = true;
                for point in &force.points {
                    source.add_contact_decay(point.place, point.normal, part, &mut self.decay);
                }
            }
            self.points.clear();
            self.points.extend(force.points.iter().map(|point| (point.place, point.impulse)));
            if self.points.iter().all(|(_, impulse)| *impulse == DVec3::ZERO) {
                continue;
            }
            let fraction = force.at.rem_euclid(FRACTIONS);
            let shaper = &mut self.shaper;
            let (before, samples) = self.sampled.entry(fraction).or_insert_with(|| {
                let (first, samples) = shaper.impulse(fraction as f64 / FRACTIONS as f64);
                (first, Arc::new(samples))
            });
            let first = force.at.div_euclid(FRACTIONS) + *before;
            source.amplitudes(&self.points, &mut self.striking, &mut self.amplitudes);
            bank.add_force(first, Arc::clone(samples), &self.amplitudes);
        }
        let changed = touches || self.damps;
        if changed {
            bank.set_added_damping(|mode| self.decay[mode]);
            self.damps = touches;
        }
        changed
    }
}
