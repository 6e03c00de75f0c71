//! Times of keys without their rounding to 32 bits.
//!
//! Files keep times as 32-bit floats, and most keys lie on the frames of one rate. The rate is found once for
//! a file, and all its curves are moved onto it: keys of one instant then have one time, whichever curve they
//! belong to. Keys off those frames keep their times.

use std::collections::BTreeSet;

use crate::formats::mesh_reader::gltf::document::GltfFile;
use crate::motion::file_units::TimeUnit;

/// Rounding of a time in 32 bits: relative, and of the smallest \[s\].
const ROUNDING: (f64, f64) = (2.5e-7, 1e-8);
/// Largest move of a key, as a share of a frame.
const LARGEST_MOVE: f64 = 0.25;
/// Relative differences from a whole rate that count as rounding, at least and at most.
const WHOLE_RATE: (f64, f64) = (1e-5, 3e-4);
/// Rates that are tried for keys at uneven distances \[Hz\].
const COMMON_RATES: [f64; 9] = [24.0, 25.0, 30.0, 50.0, 60.0, 100.0, 120.0, 240.0, 1000.0];
/// Ratio of the rates of television to whole rates.
const TELEVISION: f64 = 1.001;

/// The frames on which the keys of a file lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KeyFrames {
    start: f64,
    rate: f64,
}

impl KeyFrames {
    /// Those of the curve with most keys that has a constant rate or a common one, of a file in this unit.
    pub(super) fn of_file(file: &GltfFile, TimeUnit { seconds }: TimeUnit) -> Option<Self> {
        let document = &file.document;
        let samplers = document.animations.iter().flat_map(|animation| &animation.samplers);
        let inputs: BTreeSet<usize> = samplers.map(|sampler| sampler.input).collect();
        let times = |index: &usize| -> Option<Vec<f64>> {
            let accessor = document.accessors.get(*index)?;
            let times: Vec<f64> = file.numbers::<1>(accessor).ok()?.map(|[time]| time * seconds).collect();
            let rises = times.windows(2).all(|pair| pair[0] < pair[1]);
            (times.len() > 2 && rises && times.iter().all(|time| time.is_finite())).then_some(times)
        };
        let mut curves: Vec<Vec<f64>> = inputs.iter().filter_map(times).collect();
        curves.sort_by_key(|times| std::cmp::Reverse(times.len()));
        let even = || curves.iter().find_map(|times| Self::even(times));
        even().or_else(|| curves.iter().find_map(|times| Self::common(times)))
    }

    /// Of keys at even distances.
    fn even(times: &[f64]) -> Option<Self> {
        let (first, last) = (*times.first()?, *times.last()?);
        let measured = (times.len() - 1) as f64 / (last - first);
        let doubt = (2.0 * rounding(last) / (last - first)).clamp(WHOLE_RATE.0, WHOLE_RATE.1);
        let whole = [1.0, TELEVISION].map(|ratio| (measured * ratio).round() / ratio);
        let is_near = |rate: &f64| *rate > 0.0 && (measured / rate - 1.0).abs() <= doubt;
        let rate = whole.into_iter().find(is_near).unwrap_or(measured);
        [0.0, first].map(|start| KeyFrames { start, rate }).into_iter().find(|f| f.have_all(times))
    }

    /// Of keys on the frames of a common rate.
    fn common(times: &[f64]) -> Option<Self> {
        COMMON_RATES.map(|rate| KeyFrames { start: 0.0, rate }).into_iter().find(|f| f.have_all(times))
    }

    fn have_all(&self, times: &[f64]) -> bool {
        times.iter().all(|time| self.frame_of(*time).is_some())
    }

    /// The time of the frame on which a key lies.
    fn frame_of(&self, time: f64) -> Option<f64> {
        let frame = self.start + ((time - self.start) * self.rate).round() / self.rate;
        let most = rounding(time).min(LARGEST_MOVE / self.rate);
        ((frame - time).abs() <= most).then_some(frame)
    }

    /// Times of keys, those on frames exactly.
    pub(super) fn exact(&self, times: &[f64]) -> Vec<f64> {
        let exact: Vec<f64> = times.iter().map(|time| self.frame_of(*time).unwrap_or(*time)).collect();
        if exact.windows(2).all(|pair| pair[0] < pair[1]) { exact } else { times.to_vec() }
    }
}

fn rounding(time: f64) -> f64 {
    ROUNDING.1 + ROUNDING.0 * time.abs()
}
