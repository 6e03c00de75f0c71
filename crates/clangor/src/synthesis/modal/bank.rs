//! A bank of resonators: exact for any sample rate, and linear in the number of modes.
//!
//! A mode of pole λ = −ξω + iω_d, ω_d = ω√(1−ξ²), has the complex state w with ẇ = λw + Q, from which
//!
//! ```text
//! q = Im w / ω_d,   q̈ = Re A,   A = c (λw + Q),   c = −iλ/ω_d
//! ```
//!
//! and is heard as Re{H A}, H the transfer of the path. With Re c = 1 the real part of A is the modal acceleration
//! exactly, free ringing follows H exactly, and under a force at rest w = −Q/λ, so that A = 0 whatever H is.
//!
//! From sample to sample w turns by e^{λT}, exactly: pitch and decay do not depend on the rate. Forces are limited to the
//! band and integrated over each sample; the feed-through Q is that at the samples. Between two settings of the transfers
//! H runs on a straight line.

use std::sync::Arc;

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::ModalPressure;
use super::drive::{Course, Shaper, TERMS, pulse_at_pole, term_weights};
use crate::contact::ForceProfile;
use crate::synthesis::{SampleRate, lowpass};

/// Modes that sleep and wake together: a multiple of two of the widest vectors.
const CHUNK: usize = 16;
/// Samples between passes over the modes, so that what passes between them stays near the processor.
const PASS: usize = 64;
/// The square of the part of its largest state at which a mode is put to rest: −160 dB.
const QUIET: f64 = 1e-16;
/// Modes damped more than this do not ring and are left out.
const MAX_RATIO: f64 = 0.9;

/// Frequency and damping of a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// ω/2π without damping \[Hz\].
    pub frequency: f64,
    /// ξ \[-\].
    pub damping_ratio: f64,
}

/// Resonators that are driven by pulses and heard along paths.
pub struct ModalBank {
    rate: f64,
    pressure: ModalPressure,
    shaper: Shaper,
    /// Modes given, of which those in the band are played.
    given: usize,
    voices: Vec<Voice>,
    state: Planes,
    step: Planes,
    weights: [Planes; TERMS],
    /// Largest |w|² since the mode was at rest.
    peaks: Vec<f64>,
    awake: Vec<bool>,
    paths: Vec<Path>,
    pulses: Vec<Pulse>,
    next: i64,
    memory: Memory,
}

/// A mode that is played.
#[derive(Clone, Copy, Debug)]
struct Voice {
    /// Its place among the modes given.
    mode: usize,
    omega: f64,
    /// ξω [1/s], without what contacts add.
    decay: f64,
    pole: Complex64,
    /// Gain of the band limit at its frequency.
    gain: f64,
}

/// Complex numbers of all modes.
#[derive(Clone, Debug, Default)]
struct Planes {
    re: Vec<f64>,
    im: Vec<f64>,
}

/// How modes are heard along a path: pressure Re{G w} + F Q.
#[derive(Clone, Debug, Default)]
struct Path {
    /// G; its imaginary part has the opposite sign.
    now: Planes,
    target: Planes,
    /// Change per sample.
    slope: Planes,
    /// F.
    feed: Vec<f64>,
}

/// A force in progress.
#[derive(Clone, Debug, Default)]
struct Pulse {
    /// Sample at which the course begins.
    first: i64,
    course: Arc<Course>,
    /// Share of each mode.
    amplitudes: Vec<f64>,
    /// Σ F × amplitude for each path: at the end of the last rendering, and of the next.
    feeds: Vec<[f64; 2]>,
}

/// Passed from one loop to the next.
#[derive(Clone, Debug, Default)]
struct Memory {
    /// First b_k, then w_k, of two vectors of modes.
    run: Vec<f64>,
    /// Sums over modes, a vector for each sample of each path.
    sums: Vec<f64>,
    /// The samples of each path.
    samples: Vec<f64>,
}

impl Pulse {
    /// The sample after the last.
    fn end(&self) -> i64 {
        self.first + self.course.values.len() as i64
    }
}

impl Planes {
    fn zero(count: usize) -> Self {
        Planes { re: vec![0.0; count], im: vec![0.0; count] }
    }

    fn set(&mut self, i: usize, value: Complex64) {
        (self.re[i], self.im[i]) = (value.re, value.im);
    }
}

impl ModalBank {
    /// Resonators at rest at sample 0, heard along so many paths, none of which hears anything yet.
    ///
    /// `centre`: half-amplitude frequency of the band limit \[Hz\], 0.45 of the rate or less. Modes above the end of
    /// the band, and those that hardly ring, are left out.
    pub fn new(
        resonances: &[Resonance],
        paths: usize,
        sample_rate: SampleRate,
        centre: f64,
        pressure: ModalPressure,
    ) -> Self {
        let rate = sample_rate.as_f64();
        let centre = centre.min(lowpass::CENTRE * rate);
        let gain = |frequency: f64| lowpass::gain((frequency - centre) / (lowpass::HALF_WIDTH * rate));
        let voices: Vec<Voice> = resonances
            .iter()
            .enumerate()
            .filter(|(_, r)| r.frequency > 0.0 && r.damping_ratio >= 0.0 && r.damping_ratio < MAX_RATIO)
            .map(|(mode, r)| {
                let omega = std::f64::consts::TAU * r.frequency;
                let decay = r.damping_ratio * omega;
                Voice { mode, omega, decay, pole: pole(omega, decay), gain: gain(r.frequency) }
            })
            .filter(|voice| voice.gain > 0.0)
            .collect();
        let padded = voices.len().next_multiple_of(CHUNK);
        let path = Path {
            now: Planes::zero(padded),
            target: Planes::zero(padded),
            slope: Planes::zero(padded),
            feed: vec![0.0; padded],
        };
        let mut bank = ModalBank {
            rate,
            pressure,
            shaper: Shaper::new(rate, centre, lowpass::HALF_WIDTH * rate),
            given: resonances.len(),
            state: Planes::zero(padded),
            step: Planes::zero(padded),
            weights: std::array::from_fn(|_| Planes::zero(padded)),
            peaks: vec![0.0; padded],
            awake: vec![false; padded / CHUNK],
            paths: vec![path; paths],
            pulses: Vec::new(),
            next: 0,
            memory: Memory {
                run: vec![0.0; PASS * 4 * CHUNK],
                sums: vec![0.0; PASS * CHUNK * paths],
                samples: vec![0.0; PASS * paths],
            },
            voices,
        };
        (0..bank.voices.len()).for_each(|i| bank.tune(i));
        bank
    }

    /// Index of the sample that is rendered next.
    pub fn position(&self) -> i64 {
        self.next
    }

    /// Modes that are played.
    pub fn played(&self) -> usize {
        self.voices.len()
    }

    /// Goes on from another sample, which must not be before a force in progress.
    pub fn seek(&mut self, sample: i64) {
        self.next = sample;
    }

    /// Whether nothing moves and no force is to come.
    pub fn is_silent(&self) -> bool {
        self.pulses.is_empty() && !self.awake.contains(&true)
    }

    /// The first sample at which a pulse of this `onset` \[samples\] is felt, because it is limited to the band.
    pub fn first_sample(onset: f64, duration: f64, profile: ForceProfile, sample_rate: SampleRate) -> i64 {
        (onset + profile.extent(duration).0 * sample_rate.as_f64()).floor() as i64 - lowpass::REACH as i64
    }

    /// Adds a force, limited to the band, that begins at `onset` \[samples\] and lasts `duration` \[s\]; `amplitudes` has
    /// the modal impulse ∫ Q dt of each mode given.
    ///
    /// What of it is before the next sample is not rendered: add it in time, see [`first_sample`](Self::first_sample).
    pub fn add_pulse(&mut self, profile: ForceProfile, onset: f64, duration: f64, amplitudes: &[f64]) {
        let (first, course) = self.shaper.pulse(profile, onset, duration);
        self.add_course(first, Arc::new(course), amplitudes);
    }

    /// Adds a force of any course that is limited to the band, from sample `first` on.
    pub(super) fn add_course(&mut self, first: i64, course: Arc<Course>, amplitudes: &[f64]) {
        debug_assert_eq!(amplitudes.len(), self.given);
        let mut own = vec![0.0; self.state.re.len()];
        for (i, voice) in self.voices.iter().enumerate() {
            own[i] = amplitudes[voice.mode];
            if own[i] != 0.0 {
                self.awake[i / CHUNK] = true;
            }
        }
        let feeds = self.paths.iter().map(|path| [dot(&path.feed, &own); 2]).collect();
        self.pulses.push(Pulse { first, course, amplitudes: own, feeds });
    }

    /// Adds what rings after a pulse that is over when the next sample comes: no look ahead, for sound in real time. The
    /// pulse itself is not heard.
    pub fn add_past_pulse(&mut self, profile: ForceProfile, onset: f64, duration: f64, amplitudes: &[f64]) {
        let elapsed = (self.next as f64 - onset) / self.rate;
        for (i, voice) in self.voices.iter().enumerate() {
            let amplitude = amplitudes[voice.mode] * voice.gain;
            if amplitude != 0.0 {
                let ring =
                    amplitude * (voice.pole * elapsed).exp() * pulse_at_pole(profile, voice.pole, duration);
                self.state.re[i] += ring.re;
                self.state.im[i] += ring.im;
                self.awake[i / CHUNK] = true;
            }
        }
    }

    /// Adds damping: `decay` gives ½ c (n·U)² [1/s] for each mode given, 0 without contact.
    pub fn set_added_damping(&mut self, decay: impl Fn(usize) -> f64) {
        for i in 0..self.voices.len() {
            let voice = &mut self.voices[i];
            let total = (voice.decay + decay(voice.mode).max(0.0)).min(MAX_RATIO * voice.omega);
            if total != -voice.pole.re {
                voice.pole = pole(voice.omega, total);
                self.tune(i);
            }
        }
    }

    /// The transfers H of all modes given that a path has at the end of the next rendering.
    pub fn set_transfers(&mut self, path: usize, transfers: &[Complex64]) {
        debug_assert_eq!(transfers.len(), self.given);
        let heard = &mut self.paths[path];
        for (i, voice) in self.voices.iter().enumerate() {
            let transfer = transfers[voice.mode];
            let damped = voice.pole.im;
            let (coupling, feed) = match self.pressure {
                ModalPressure::Acceleration => {
                    let acceleration = transfer * Complex64::new(0.0, -1.0 / damped) * voice.pole;
                    (acceleration * voice.pole, acceleration.re)
                }
                ModalPressure::PublishedMagnitude => {
                    (Complex64::new(0.0, -voice.omega.powi(2) * transfer.norm() / damped), 0.0)
                }
            };
            heard.target.set(i, coupling.conj());
            heard.feed[i] = feed;
        }
        for pulse in &mut self.pulses {
            pulse.feeds[path][1] = dot(&heard.feed, &pulse.amplitudes);
        }
    }

    /// Takes the transfers last set at once.
    pub fn jump_to_transfers(&mut self) {
        for (p, path) in self.paths.iter_mut().enumerate() {
            path.now.clone_from(&path.target);
            self.pulses.iter_mut().for_each(|pulse| pulse.feeds[p][0] = pulse.feeds[p][1]);
        }
    }

    /// Appends the next `count` samples of each path \[Pa\] to `outputs`.
    pub fn render(&mut self, count: usize, outputs: &mut [Vec<f64>]) {
        if count == 0 {
            return;
        }
        let per_sample = 1.0 / count as f64;
        for path in &mut self.paths {
            let parts = [(&mut path.slope.re, &path.target.re, &path.now.re)];
            let others = [(&mut path.slope.im, &path.target.im, &path.now.im)];
            for (slope, target, now) in parts.into_iter().chain(others) {
                for ((slope, target), now) in slope.iter_mut().zip(target).zip(now) {
                    *slope = (target - now) * per_sample;
                }
            }
        }
        let mut done = 0;
        while done < count {
            let samples = PASS.min(count - done);
            Arch::new().dispatch(Passing { bank: self, samples });
            self.feed_through(samples, done, count);
            for (p, output) in outputs.iter_mut().enumerate() {
                output.extend_from_slice(&self.memory.samples[p * PASS..p * PASS + samples]);
            }
            done += samples;
            self.next += samples as i64;
        }
        for (p, path) in self.paths.iter_mut().enumerate() {
            // Not what the steps summed up to, so that rounding does not grow.
            path.now.re.copy_from_slice(&path.target.re);
            path.now.im.copy_from_slice(&path.target.im);
            self.pulses.iter_mut().for_each(|pulse| pulse.feeds[p][0] = pulse.feeds[p][1]);
        }
        let next = self.next;
        self.pulses.retain(|pulse| pulse.end() > next);
        self.rest();
    }

    /// Adds F Q of the forces in progress to the samples.
    fn feed_through(&mut self, samples: usize, done: usize, count: usize) {
        for pulse in &self.pulses {
            let begin = pulse.first.max(self.next);
            let end = pulse.end().min(self.next + samples as i64);
            for at in begin..end {
                let k = (at - self.next) as usize;
                let value = pulse.course.values[(at - pulse.first) as usize];
                let part = (done + k) as f64 / count as f64;
                for (p, [now, then]) in pulse.feeds.iter().enumerate() {
                    self.memory.samples[p * PASS + k] += value * (now + part * (then - now));
                }
            }
        }
    }

    /// Puts modes that have died away to rest.
    fn rest(&mut self) {
        for (chunk, awake) in self.awake.iter_mut().enumerate().filter(|(_, awake)| **awake) {
            let own = chunk * CHUNK..(chunk + 1) * CHUNK;
            let driven = self.pulses.iter().any(|p| p.amplitudes[own.clone()].iter().any(|a| *a != 0.0));
            if driven {
                continue;
            }
            let mut quiet = true;
            for i in own {
                let size = self.state.re[i].powi(2) + self.state.im[i].powi(2);
                self.peaks[i] = self.peaks[i].max(size);
                if size <= QUIET * self.peaks[i] {
                    self.state.set(i, Complex64::ZERO);
                    self.peaks[i] = 0.0;
                } else {
                    quiet = false;
                }
            }
            *awake = !quiet;
        }
    }

    /// What follows from the pole of a mode.
    fn tune(&mut self, i: usize) {
        let pole = self.voices[i].pole;
        self.step.set(i, (pole / self.rate).exp());
        for (plane, weight) in self.weights.iter_mut().zip(term_weights(pole, 1.0 / self.rate)) {
            plane.set(i, weight);
        }
    }
}

/// λ of a mode that decays at ξω [1/s].
fn pole(omega: f64, decay: f64) -> Complex64 {
    Complex64::new(-decay, (omega * omega - decay * decay).sqrt())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Advances all modes by some samples, with the vector instructions of the machine.
struct Passing<'a> {
    bank: &'a mut ModalBank,
    samples: usize,
}

impl WithSimd for Passing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Passing { bank, samples } = self;
        let ModalBank { state, step, weights, awake, paths, pulses, next, memory, .. } = bank;
        let Memory { run, sums, samples: outputs } = memory;
        let run = &mut S::as_mut_simd_f64s(run).0.as_chunks_mut::<4>().0[..samples];
        let sums = S::as_mut_simd_f64s(sums).0;
        sums.fill(simd.splat_f64s(0.0));
        let width = 2 * S::F64_LANES;
        for chunk in (0..awake.len()).filter(|chunk| awake[*chunk]) {
            for at in (chunk * CHUNK..(chunk + 1) * CHUNK).step_by(width) {
                let own = at..at + width;
                let driven = drive(simd, run, weights, pulses, *next, own.clone());
                rotate(simd, run, state, step, driven, own.clone());
                for (path, sums) in paths.iter_mut().zip(sums.chunks_exact_mut(PASS)) {
                    listen(simd, run, path, &mut sums[..samples], own.clone());
                }
            }
        }
        for (sums, outputs) in sums.chunks_exact(PASS).zip(outputs.chunks_exact_mut(PASS)) {
            for (sum, output) in sums.iter().zip(outputs) {
                *output = simd.reduce_sum_f64s(*sum);
            }
        }
    }
}

/// Two vectors.
type Two<S> = [<S as Simd>::f64s; 2];

#[inline(always)]
fn two<S: Simd>(values: &[f64]) -> Two<S> {
    let vectors = S::as_simd_f64s(values).0;
    [vectors[0], vectors[1]]
}

/// b_k of the forces in progress, as (re, re, im, im) for each sample; whether there are any.
#[inline(always)]
fn drive<S: Simd>(
    simd: S,
    run: &mut [[S::f64s; 4]],
    weights: &[Planes; TERMS],
    pulses: &[Pulse],
    next: i64,
    own: std::ops::Range<usize>,
) -> bool {
    let mut driven = false;
    for pulse in pulses {
        let begin = pulse.first.max(next);
        let end = pulse.end().min(next + run.len() as i64);
        if begin >= end {
            continue;
        }
        if !driven {
            run.fill([simd.splat_f64s(0.0); 4]);
            driven = true;
        }
        let amplitude = two::<S>(&pulse.amplitudes[own.clone()]);
        let mut scaled = [[simd.splat_f64s(0.0); 4]; TERMS];
        for (scaled, weights) in scaled.iter_mut().zip(weights) {
            let (re, im) = (two::<S>(&weights.re[own.clone()]), two::<S>(&weights.im[own.clone()]));
            for v in 0..2 {
                scaled[v] = simd.mul_f64s(re[v], amplitude[v]);
                scaled[2 + v] = simd.mul_f64s(im[v], amplitude[v]);
            }
        }
        let terms = &pulse.course.terms[(begin - pulse.first) as usize..(end - pulse.first) as usize];
        let run = &mut run[(begin - next) as usize..(end - next) as usize];
        for (sums, terms) in run.iter_mut().zip(terms) {
            for (term, scaled) in terms.iter().zip(&scaled) {
                let term = simd.splat_f64s(*term);
                for v in 0..4 {
                    sums[v] = simd.mul_add_e_f64s(term, scaled[v], sums[v]);
                }
            }
        }
    }
    driven
}

/// Turns two vectors of modes through all samples and leaves w_k where b_k was.
#[inline(always)]
fn rotate<S: Simd>(
    simd: S,
    run: &mut [[S::f64s; 4]],
    state: &mut Planes,
    step: &Planes,
    driven: bool,
    own: std::ops::Range<usize>,
) {
    let (step_re, step_im) = (two::<S>(&step.re[own.clone()]), two::<S>(&step.im[own.clone()]));
    let minus_im = step_im.map(|x| simd.neg_f64s(x));
    let (mut re, mut im) = (two::<S>(&state.re[own.clone()]), two::<S>(&state.im[own.clone()]));
    if driven {
        for sample in run {
            let forced = *sample;
            *sample = [re[0], re[1], im[0], im[1]];
            for v in 0..2 {
                let across = simd.mul_add_e_f64s(minus_im[v], im[v], forced[v]);
                let along = simd.mul_add_e_f64s(step_im[v], re[v], forced[2 + v]);
                re[v] = simd.mul_add_e_f64s(step_re[v], re[v], across);
                im[v] = simd.mul_add_e_f64s(step_re[v], im[v], along);
            }
        }
    } else {
        for sample in run {
            *sample = [re[0], re[1], im[0], im[1]];
            for v in 0..2 {
                let across = simd.mul_f64s(minus_im[v], im[v]);
                let along = simd.mul_f64s(step_im[v], re[v]);
                re[v] = simd.mul_add_e_f64s(step_re[v], re[v], across);
                im[v] = simd.mul_add_e_f64s(step_re[v], im[v], along);
            }
        }
    }
    S::as_mut_simd_f64s(&mut state.re[own.clone()]).0.copy_from_slice(&re);
    S::as_mut_simd_f64s(&mut state.im[own]).0.copy_from_slice(&im);
}

/// Adds Re{G w} of two vectors of modes to the samples of a path.
#[inline(always)]
fn listen<S: Simd>(
    simd: S,
    run: &[[S::f64s; 4]],
    path: &mut Path,
    sums: &mut [S::f64s],
    own: std::ops::Range<usize>,
) {
    let (mut re, mut im) = (two::<S>(&path.now.re[own.clone()]), two::<S>(&path.now.im[own.clone()]));
    let (slope_re, slope_im) = (two::<S>(&path.slope.re[own.clone()]), two::<S>(&path.slope.im[own.clone()]));
    for (sample, sum) in run.iter().zip(sums) {
        for v in 0..2 {
            *sum = simd.mul_add_e_f64s(re[v], sample[v], *sum);
            *sum = simd.mul_add_e_f64s(im[v], sample[2 + v], *sum);
            re[v] = simd.add_f64s(re[v], slope_re[v]);
            im[v] = simd.add_f64s(im[v], slope_im[v]);
        }
    }
    S::as_mut_simd_f64s(&mut path.now.re[own.clone()]).0.copy_from_slice(&re);
    S::as_mut_simd_f64s(&mut path.now.im[own]).0.copy_from_slice(&im);
}
