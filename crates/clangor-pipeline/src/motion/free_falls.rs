//! The acceleration with which recorded bodies fall freely, measured from their poses as they come.
//!
//! ```text
//! v = (x₃ − x₀)/(t₃ − t₀)    w = (x₆ − x₃)/(t₆ − t₃)    a = 2 (w − v)/(t₆ − t₀)    frames x₀ … x₆
//! ```
//!
//! Seven frames, one to sixteen frames apart, are a fall if the other four lie on the parabola through these
//! three within 1 % of its sagitta, and if it bends along gravity or along z. Contacts and hands bend the
//! path in other ways, rest does not bend it, and no unit of time or length changes whether a path is a
//! parabola. Friction, a spring near its turning point, a wheel at its top and quadratic easing have
//! parabolas too.
//!
//! Not a test for gravity: a body that a constant force pulls falls too. [`fall_units`](super::fall_units)
//! judges the accelerations.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use super::quaternion_order;
use super::recording::Frame;

/// Frames of a fall.
const POINTS: usize = quaternion_order::POINTS;
/// Distances of those frames, powers of two; wide ones are needed where positions are rounded or noisy.
const STRIDES: [usize; 5] = [1, 2, 4, 8, 16];
/// Largest distance from the parabola, over its sagitta.
const ON_PARABOLA: f64 = 0.01;
/// Smallest sagitta \[m\], and over the largest coordinate, whose rounding in 32 bits is 6e-8 of it.
const BENT: (f64, f64) = (1e-5, 1e-5);
/// Largest share of the acceleration across the direction of the fall.
const ACROSS: f64 = 0.1;
/// Width of a class of accelerations, as a logarithm.
const CLASS: f64 = 0.02;

/// Where bodies fall to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FallsAlong {
    /// The gravity of the scene.
    Gravity,
    /// −z, as where z is up.
    MinusZ,
    /// +z, as where y was up and the axes were turned.
    PlusZ,
}

impl FallsAlong {
    /// All of them.
    pub(crate) const ALL: [FallsAlong; 3] = [FallsAlong::Gravity, FallsAlong::MinusZ, FallsAlong::PlusZ];
}

/// Accelerations of falls in one direction.
#[derive(Clone, Debug, Default)]
pub(crate) struct FallSpeeds {
    /// By the class of the acceleration: frames, and the sum of their accelerations [m/s²].
    classes: BTreeMap<i32, (u64, f64)>,
    /// Row of the first fall.
    pub(crate) first_row: u64,
}

/// The falls of one body.
#[derive(Clone, Debug)]
pub(crate) struct FreeFalls {
    down: DVec3,
    /// For each distance the last seven frames whose number it divides.
    recent: [Recent; STRIDES.len()],
    frames: usize,
    found: [FallSpeeds; 3],
}

/// The last seven frames of a row: time, place and orientation.
#[derive(Clone, Debug, Default)]
struct Recent {
    points: Vec<(f64, DVec3, DQuat)>,
    /// Place of the oldest, once there are seven.
    oldest: usize,
}

impl Recent {
    fn push(&mut self, point: (f64, DVec3, DQuat)) {
        if self.points.len() < POINTS {
            self.points.reserve_exact(POINTS);
            self.points.push(point);
        } else {
            self.points[self.oldest] = point;
            self.oldest = if self.oldest + 1 < POINTS { self.oldest + 1 } else { 0 };
        }
    }

    /// The `k`-th of seven from the oldest.
    fn at(&self, k: usize) -> &(f64, DVec3, DQuat) {
        let place = self.oldest + k;
        &self.points[if place < POINTS { place } else { place - POINTS }]
    }
}

impl FreeFalls {
    /// Without any, under a gravity [m/s²].
    pub(crate) fn new(gravity: DVec3) -> Self {
        let down = gravity.normalize_or_zero();
        FreeFalls { down, recent: Default::default(), frames: 0, found: Default::default() }
    }

    /// Takes the next frame. Times and orientations of the widest fall along gravity that it ends.
    pub(crate) fn push(&mut self, frame: &Frame) -> Option<[(f64, DQuat); POINTS]> {
        let point = (frame.time, frame.pose.position, frame.pose.orientation);
        let newest = self.frames;
        let mut widest = None;
        self.frames += 1;
        for (place, stride) in STRIDES.into_iter().enumerate() {
            // Whether the distance divides the number: without a division, as it is a power of two.
            if newest & (stride - 1) != 0 {
                break;
            }
            let recent = &mut self.recent[place];
            recent.push(point);
            if recent.points.len() < POINTS {
                continue;
            }
            let Some(acceleration) = parabola(|k| (recent.at(k).0, recent.at(k).1)) else { continue };
            let turns: [(f64, DQuat); POINTS] = std::array::from_fn(|k| (recent.at(k).0, recent.at(k).2));
            if self.note(acceleration, stride as u64, frame.row) == Some(FallsAlong::Gravity) {
                widest = Some(turns);
            }
        }
        widest
    }

    fn note(&mut self, acceleration: DVec3, frames: u64, row: u64) -> Option<FallsAlong> {
        let directions = [self.down, DVec3::NEG_Z, DVec3::Z];
        let is_along = |direction: &DVec3| {
            let along = acceleration.dot(*direction);
            along > 0.0 && (acceleration - *direction * along).length() <= ACROSS * along
        };
        let place = directions.iter().position(is_along)?;
        let size = acceleration.length();
        let found = &mut self.found[place];
        if found.classes.is_empty() {
            found.first_row = row;
        }
        let (count, sum) = found.classes.entry((size.ln() / CLASS).floor() as i32).or_default();
        *count += frames;
        *sum += frames as f64 * size;
        Some(FallsAlong::ALL[place])
    }

    /// The falls in a direction.
    pub(crate) fn along(&self, direction: FallsAlong) -> &FallSpeeds {
        &self.found[direction as usize]
    }
}

/// The constant acceleration of seven points [m/s²], if they have one and it bends their path; `point` gives
/// the time and the place of each.
fn parabola(point: impl Fn(usize) -> (f64, DVec3)) -> Option<DVec3> {
    let [(t0, x0), (t3, x3), (t6, x6)] = [0, 3, 6].map(&point);
    let size = x0.abs().max_element().max(x6.abs().max_element());
    let least = BENT.0.max(BENT.1 * size);
    // What rests or moves evenly, without a division.
    let bend = (x6 - x3) * (t3 - t0) - (x3 - x0) * (t6 - t3);
    if bend.length_squared() <= (least * (t6 - t0)).powi(2) {
        return None;
    }
    let (before, after) = ((x3 - x0) / (t3 - t0), (x6 - x3) / (t6 - t3));
    let half = (after - before) / (t6 - t0);
    let sagitta = half.length() * (t3 - t0) * (t6 - t3);
    if !sagitta.is_finite() {
        return None;
    }
    let lies_on = |(t, x): (f64, DVec3)| {
        let expected = x0 + before * (t - t0) + half * ((t - t0) * (t - t3));
        x.distance(expected) <= ON_PARABOLA * sagitta
    };
    [1, 2, 4, 5].into_iter().all(|k| lies_on(point(k))).then_some(2.0 * half)
}

impl FallSpeeds {
    /// Adds those of another body.
    pub(crate) fn extend(&mut self, other: &FallSpeeds) {
        for (class, (count, sum)) in &other.classes {
            let known = self.classes.entry(*class).or_default();
            known.0 += count;
            known.1 += sum;
        }
    }

    /// Frames in falls; one that several distances of frames see counts for each.
    pub(crate) fn frames(&self) -> u64 {
        self.classes.values().map(|(count, _)| count).sum()
    }

    /// Frames with an acceleration within a factor of another [m/s²], and the mean of theirs.
    pub(crate) fn near(&self, acceleration: f64, factor: f64) -> (u64, f64) {
        let class = |value: f64| (value.ln() / CLASS).floor() as i32;
        let near = self.classes.range(class(acceleration / factor)..=class(acceleration * factor));
        let (count, sum) = near.fold((0, 0.0), |(n, s), (_, (count, sum))| (n + count, s + sum));
        (count, sum / count.max(1) as f64)
    }

    /// The acceleration that this share of the frames does not reach [m/s²].
    pub(crate) fn quantile(&self, share: f64) -> Option<f64> {
        let wanted = share * self.frames() as f64;
        let mut below = 0.0;
        let reached = self.classes.iter().find(|(_, (count, _))| {
            below += *count as f64;
            below >= wanted
        });
        reached.map(|(_, (count, sum))| sum / (*count).max(1) as f64)
    }
}
