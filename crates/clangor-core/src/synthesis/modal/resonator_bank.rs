//! A bank of resonators: exact for any sample rate, and linear in the number of modes.
//!
//! A mode of pole λ = −ξω + iω_d, ω_d = ω√(1−ξ²), has the complex state w with ẇ = λw + Q, from which
//!
//! ```text
//! q = Im w / ω_d,   q̈ = Re A,   A = c (λw + Q),   c = −iλ/ω_d
//! ```
//!
//! and is received as Re{H A}, with H the transfer of the path. With Re c = 1 the real part of A is the modal
//! acceleration exactly, and free ringing follows H exactly. Under a constant force w = −Q/λ, so that A = 0
//! for any H.
//!
//! From sample to sample w is multiplied by e^{λT}, exactly: pitch and decay do not depend on the rate.
//! Forces are limited to the band and integrated over each sample; the feed-through Q is its value at the
//! samples. Between two settings of the transfers H is linear in time.

mod driving;
mod passes;

use std::sync::Arc;

use num_complex::Complex64;
use pulp::Arch;

use self::passes::Passing;
use super::drive::{ForceSamples, Shaper, TERMS, term_weights};
use super::modal_settings::ModalPressure;
use crate::contact::ForceShape;
use crate::reference::frac_coupling;
use crate::synthesis::{SampleRate, lowpass};

/// Modes that sleep and wake together: a multiple of two vectors of the widest kind.
const CHUNK: usize = 16;
/// Samples per pass over the modes, so that intermediate values stay in the cache.
const PASS: usize = 64;
/// Square of the ratio to its largest state below which a mode is put to rest: −160 dB.
const QUIET: f64 = 1e-16;
/// Modes damped more than this do not ring and are left out.
pub(super) const MAX_RATIO: f64 = 0.9;

/// Frequency and damping of a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance {
    /// ω/2π without damping \[Hz\].
    pub frequency: f64,
    /// ξ \[-\].
    pub damping_ratio: f64,
}

/// Resonators driven by pulses, with transfers along paths.
pub struct ResonatorBank {
    rate: f64,
    pressure: ModalPressure,
    shaper: Shaper,
    /// Modes given; those in the band are rendered.
    given: usize,
    voices: Vec<Voice>,
    state: Planes,
    step: Planes,
    weights: [Planes; TERMS],
    /// Largest |w|² since the mode was at rest.
    peaks: Vec<f64>,
    awake: Vec<bool>,
    /// Whether some woke since the last query.
    woken: bool,
    /// Chunk of each mode given, if it is rendered.
    chunks: Vec<Option<u32>>,
    paths: Vec<Path>,
    pulses: Vec<Pulse>,
    /// Forces that have ended, whose memory is reused.
    spare: Vec<Pulse>,
    /// Computes the band-limited forces.
    rest: Arc<ForceSamples>,
    next: i64,
    memory: Memory,
}

/// A rendered mode.
#[derive(Clone, Copy, Debug)]
struct Voice {
    /// Its index among the modes given.
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

/// Transfer of the modes along a path: pressure Re{G w} + F Q.
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
    /// Sample at which the force begins.
    first: i64,
    force: Arc<ForceSamples>,
    /// Share of each mode.
    amplitudes: Vec<f64>,
    /// Σ F × amplitude for each path: at the end of the last rendering, and of the next.
    feeds: Vec<[f64; 2]>,
}

/// Buffers passed from one loop to the next.
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
        self.first + self.force.values.len() as i64
    }
}

impl Path {
    /// Sets the transfer to its target.
    fn arrive(&mut self) {
        self.now.re.copy_from_slice(&self.target.re);
        self.now.im.copy_from_slice(&self.target.im);
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

impl ResonatorBank {
    /// Resonators at rest at sample 0, with this number of paths, whose transfers are all zero.
    ///
    /// `centre`: half-amplitude frequency of the band limit \[Hz\], 0.45 of the rate or less. Modes above the
    /// end of the band, and overdamped modes, are left out.
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
        let mut chunks = vec![None; resonances.len()];
        voices.iter().enumerate().for_each(|(i, voice)| chunks[voice.mode] = Some((i / CHUNK) as u32));
        let padded = voices.len().next_multiple_of(CHUNK);
        let path = Path {
            now: Planes::zero(padded),
            target: Planes::zero(padded),
            slope: Planes::zero(padded),
            feed: vec![0.0; padded],
        };
        let mut bank = ResonatorBank {
            rate,
            pressure,
            shaper: Shaper::new(rate, centre, lowpass::HALF_WIDTH * rate),
            given: resonances.len(),
            state: Planes::zero(padded),
            step: Planes::zero(padded),
            weights: std::array::from_fn(|_| Planes::zero(padded)),
            peaks: vec![0.0; padded],
            awake: vec![false; padded / CHUNK],
            woken: false,
            chunks,
            paths: vec![path; paths],
            pulses: Vec::new(),
            spare: Vec::new(),
            rest: Arc::default(),
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

    /// Index of the next rendered sample.
    pub fn position(&self) -> i64 {
        self.next
    }

    /// Number of rendered modes.
    pub fn played(&self) -> usize {
        self.voices.len()
    }

    /// Continues from another sample, which must not be before a force in progress.
    pub fn seek(&mut self, sample: i64) {
        self.next = sample;
    }

    /// Puts everything to rest.
    pub(super) fn silence(&mut self) {
        for values in [&mut self.state.re, &mut self.state.im, &mut self.peaks] {
            values.fill(0.0);
        }
        self.awake.fill(false);
        self.retire(|_| true);
    }

    /// Reserves memory for this number of simultaneous forces, so that adding one allocates nothing.
    pub(super) fn reserve(&mut self, pulses: usize) {
        let (modes, paths) = (self.state.re.len(), self.paths.len());
        self.pulses.reserve(pulses);
        self.spare.reserve(pulses);
        self.spare.resize_with(pulses, || Pulse {
            first: 0,
            force: Arc::clone(&self.rest),
            amplitudes: Vec::with_capacity(modes),
            feeds: Vec::with_capacity(paths),
        });
    }

    /// Number of forces in progress or to come.
    pub(super) fn forces(&self) -> usize {
        self.pulses.len()
    }

    /// Number of modes that are not at rest, or in a chunk with such a mode.
    pub(super) fn awake_modes(&self) -> usize {
        CHUNK * self.awake.iter().filter(|awake| **awake).count()
    }

    /// Removes forces that have ended.
    fn retire(&mut self, over: impl Fn(&Pulse) -> bool) {
        for mut pulse in self.pulses.extract_if(.., |pulse| over(pulse)) {
            pulse.force = Arc::clone(&self.rest);
            self.spare.push(pulse);
        }
    }

    /// Whether nothing moves and no force is to come.
    pub fn is_silent(&self) -> bool {
        self.pulses.is_empty() && !self.awake.contains(&true)
    }

    /// Whether a mode, or another mode of its chunk, is not at rest.
    pub fn rings(&self, mode: usize) -> bool {
        self.chunks[mode].is_some_and(|chunk| self.awake[chunk as usize])
    }

    /// Whether modes woke since the last query, so that their transfers must be set.
    pub(super) fn take_woken(&mut self) -> bool {
        std::mem::take(&mut self.woken)
    }

    /// First sample affected by a pulse of this `onset` \[samples\], with the reach of the band limit.
    pub fn first_sample(onset: f64, duration: f64, shape: &ForceShape, sample_rate: SampleRate) -> i64 {
        (onset + shape.extent(duration).0 * sample_rate.as_f64()).floor() as i64 - lowpass::REACH as i64
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

    /// Sets the transfers H of all modes given along a path, at the end of the next rendering.
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
                ModalPressure::Reference => (frac_coupling(voice.omega, damped, transfer), 0.0),
            };
            heard.target.set(i, coupling.conj());
            heard.feed[i] = feed;
        }
        for pulse in &mut self.pulses {
            pulse.feeds[path][1] = dot(&heard.feed, &pulse.amplitudes);
        }
    }

    /// Applies the transfers last set at once.
    pub fn jump_to_transfers(&mut self) {
        for (p, path) in self.paths.iter_mut().enumerate() {
            path.arrive();
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
            // The exact target instead of the accumulated sum, so that rounding does not grow.
            path.arrive();
            self.pulses.iter_mut().for_each(|pulse| pulse.feeds[p][0] = pulse.feeds[p][1]);
        }
        let next = self.next;
        self.retire(|pulse| pulse.end() <= next);
        self.rest();
    }

    /// Adds F Q of the forces in progress to the samples.
    fn feed_through(&mut self, samples: usize, done: usize, count: usize) {
        for pulse in &self.pulses {
            let begin = pulse.first.max(self.next);
            let end = pulse.end().min(self.next + samples as i64);
            for at in begin..end {
                let k = (at - self.next) as usize;
                let value = pulse.force.values[(at - pulse.first) as usize];
                let part = (done + k) as f64 / count as f64;
                for (p, [now, then]) in pulse.feeds.iter().enumerate() {
                    self.memory.samples[p * PASS + k] += value * (now + part * (then - now));
                }
            }
        }
    }

    /// Puts modes that have decayed to rest.
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

    /// Values derived from the pole of a mode.
    fn tune(&mut self, i: usize) {
        let pole = self.voices[i].pole;
        self.step.set(i, (pole / self.rate).exp());
        for (plane, weight) in self.weights.iter_mut().zip(term_weights(pole, 1.0 / self.rate)) {
            plane.set(i, weight);
        }
    }
}

/// λ of a mode that decays at ξω [1/s].
pub(super) fn pole(omega: f64, decay: f64) -> Complex64 {
    Complex64::new(-decay, (omega * omega - decay * decay).sqrt())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
