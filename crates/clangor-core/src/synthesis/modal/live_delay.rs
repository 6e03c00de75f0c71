//! Signal emitted along a path, in a ring buffer, received after a varying delay.
//!
//! Within a block the delay is linear in time: a body that accelerates by 10 m/s² is 26 ns off in a block of
//! 2.7 ms. A change of the delay by more than a quarter of the block is cross-faded instead. The signal
//! between samples is that of a Kaiser-windowed sinc of 16 samples: error 3e-4 below a third of the rate.

use std::sync::LazyLock;

use pulp::{Arch, Simd, WithSimd};

use super::delay::windowed_sinc;

/// Half the length of the sinc \[samples\]: reception needs the samples emitted until that much later.
pub(super) const HALF_TAPS: usize = 8;
const TAPS: usize = 2 * HALF_TAPS;
/// Fractions of a sample for which it is tabulated.
const PHASES: usize = 512;
/// Kaiser's β for 80 dB.
const BETA: f64 = 7.84;
/// Largest change of the delay in a block, over the block, that is interpolated instead of cross-faded.
const GLIDE: f64 = 0.25;

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct LiveDelay {
    /// The length is a power of two.
    samples: Vec<f32>,
    /// The longest delay \[samples\].
    longest: f64,
    /// Place after the last emitted sample, on a counter without jumps.
    end: i64,
    /// Index of a sample minus its place.
    shift: i64,
    heard: Heard,
}

/// Reception in the last block.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Heard {
    /// No last block: the signal begins without a fade.
    Nothing,
    /// Too far away, or no path: the signal fades in.
    Nowhere,
    /// With this delay at the end of the block \[samples\].
    After(f64),
}

impl LiveDelay {
    /// For delays and blocks of up to these lengths \[samples\].
    pub(super) fn new(longest: usize, block: usize) -> Self {
        let kept = (longest + 2 * block + 2 * TAPS).next_power_of_two();
        let (end, shift, heard) = (0, 0, Heard::Nothing);
        LiveDelay { samples: vec![0.0; kept], longest: longest as f64, end, shift, heard }
    }

    /// Restarts at a sample of this index, after silence of the longest delay and a block.
    pub(super) fn restart(&mut self, next: i64) {
        (self.shift, self.heard) = (next - self.end, Heard::Nothing);
    }

    /// Clears the signal.
    pub(super) fn silence(&mut self) {
        self.samples.fill(0.0);
        self.heard = Heard::Nothing;
    }

    /// Appends emitted samples.
    pub(super) fn send(&mut self, sent: &[f64]) {
        let mask = self.samples.len() - 1;
        for value in sent {
            self.samples[self.end as usize & mask] = *value as f32;
            self.end += 1;
        }
    }

    /// The received signal from index `first` on, for a delay of `delay` \[samples\] at the end of the block,
    /// or with nothing received at the end. Returns whether there is any signal.
    pub(super) fn listen(&mut self, first: i64, delay: Option<f64>, heard: &mut [f32]) -> bool {
        let now = match delay.filter(|delay| (0.0..=self.longest).contains(delay)) {
            Some(delay) => Heard::After(delay),
            None => Heard::Nowhere,
        };
        let (before, delay, fade) = match (std::mem::replace(&mut self.heard, now), now) {
            (Heard::After(before), Heard::After(delay)) => (before, delay, None),
            (Heard::Nothing, Heard::After(delay)) => (delay, delay, None),
            (Heard::Nowhere, Heard::After(delay)) => (delay, delay, Some([0.0, 1.0])),
            (Heard::After(before), _) => (before, before, Some([1.0, 0.0])),
            _ => return false,
        };
        let first = first - self.shift;
        Arch::new().dispatch(Listening { samples: &self.samples, first, before, delay, heard });
        if let Some([from, to]) = fade {
            let step = (to - from) / heard.len() as f32;
            heard.iter_mut().enumerate().for_each(|(frame, p)| *p *= from + step * (frame + 1) as f32);
        }
        true
    }
}

/// Reception of one block, with the vector instructions of the machine.
struct Listening<'a> {
    samples: &'a [f32],
    first: i64,
    /// Delay at the beginning and at the end of the block \[samples\].
    before: f64,
    delay: f64,
    heard: &'a mut [f32],
}

impl WithSimd for Listening<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Listening { samples, first, before, delay, heard } = self;
        let frames = heard.len() as f64;
        let glides = (delay - before).abs() <= GLIDE * frames;
        if delay == before {
            return still(samples, first as f64 - delay, heard);
        }
        let slope = if glides { (delay - before) / frames } else { 0.0 };
        let ago = |delay: f64| (first as f64 - delay, 1.0 - slope);
        let (begin, step) = ago(before + slope);
        for (frame, heard) in heard.iter_mut().enumerate() {
            *heard = between(samples, begin + step * frame as f64);
        }
        if !glides {
            let (begin, step) = ago(delay);
            for (frame, heard) in heard.iter_mut().enumerate() {
                let part = ((frame + 1) as f64 / frames) as f32;
                *heard += part * (between(samples, begin + step * frame as f64) - *heard);
            }
        }
    }
}

/// The received signal from a place on with constant delay: the same weights at every sample.
#[inline(always)]
fn still(samples: &[f32], place: f64, heard: &mut [f32]) {
    let (start, weights) = weights(place);
    let mask = samples.len() - 1;
    heard.fill(0.0);
    // Runs without a break, except at the end of the ring.
    let (mut done, count) = (0, heard.len());
    while done < count {
        let begin = (start + done as i64) as usize & mask;
        let whole = (samples.len() - begin).saturating_sub(TAPS - 1).min(count - done);
        if whole == 0 {
            let wrapped = |k: usize| samples[(begin + k) & mask];
            heard[done] = weights.iter().enumerate().map(|(k, w)| w * wrapped(k)).sum();
            done += 1;
            continue;
        }
        let out = &mut heard[done..done + whole];
        for (k, weight) in weights.iter().enumerate() {
            let sent = &samples[begin + k..begin + k + whole];
            out.iter_mut().zip(sent).for_each(|(sum, x)| *sum += weight * x);
        }
        done += whole;
    }
}

/// The first of the samples around a place, and their weights.
#[inline(always)]
fn weights(place: f64) -> (i64, [f32; TAPS]) {
    let whole = place.floor();
    let phase = (place - whole) * PHASES as f64;
    let (row, part) = ((phase as usize).min(PHASES - 1), phase.fract() as f32);
    let (here, next) = (&SINC[row], &SINC[row + 1]);
    let weight = |tap: usize| here[tap] + part * (next[tap] - here[tap]);
    (whole as i64 - HALF_TAPS as i64 + 1, std::array::from_fn(weight))
}

/// The interpolated signal of a ring buffer.
#[inline(always)]
fn between(samples: &[f32], place: f64) -> f32 {
    let (start, weights) = weights(place);
    let mask = samples.len() - 1;
    let begin = start as usize & mask;
    let mut own = [0.0; TAPS];
    match samples.get(begin..begin + TAPS) {
        Some(samples) => own.copy_from_slice(samples),
        None => own.iter_mut().enumerate().for_each(|(k, x)| *x = samples[(begin + k) & mask]),
    }
    let mut sums = [0.0_f32; HALF_TAPS];
    for half in [0, HALF_TAPS] {
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += own[half + k] * weights[half + k];
        }
    }
    sums.iter().sum()
}

/// sinc(x) times the window, for each fraction of a sample.
static SINC: LazyLock<Vec<[f32; TAPS]>> = LazyLock::new(|| {
    windowed_sinc::<TAPS>(PHASES, BETA).into_iter().map(|row| row.map(|value| value as f32)).collect()
});

/// Computes the table, which takes time and memory, in advance.
pub(super) fn warm() {
    LazyLock::force(&SINC);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The received signal of a tone at this fraction of the rate, while the delay changes from one value to
    /// another in a block.
    fn heard(part: f64, from: f64, to: f64) -> Vec<f32> {
        let mut line = LiveDelay::new(300, 128);
        line.restart(0);
        let tone: Vec<f64> = (0..400).map(|i| (std::f64::consts::TAU * part * f64::from(i)).cos()).collect();
        line.send(&tone);
        line.heard = Heard::After(from);
        let mut heard = vec![0.0; 128];
        assert!(line.listen(260, Some(to), &mut heard));
        heard
    }

    #[test]
    fn a_tone_below_a_third_of_the_rate_is_late_and_nothing_else() {
        for part in [0.001, 0.1, 0.2, 0.3, 1.0 / 3.0] {
            for delay in [40.0, 57.25, 60.999, 199.47] {
                let values = heard(part, delay, delay);
                let error = values.iter().enumerate().map(|(i, p)| {
                    let left = 260.0 + i as f64 - delay;
                    (f64::from(*p) - (std::f64::consts::TAU * part * left).cos()).abs()
                });
                let error = error.fold(0.0, f64::max);
                assert!(error < 3e-4, "{part} {delay}: {error:e}");
            }
        }
    }

    #[test]
    fn a_delay_that_jumps_is_faded_over_to() {
        let values = heard(0.01, 150.0, 50.0);
        let step = values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
        // A tone of 1 % of the rate moves by 0.063 from sample to sample, the fade by 1/64.
        assert!(step < 0.063 + 0.016, "{step}");
    }

    #[test]
    fn what_is_too_far_is_silent_and_fades() {
        let mut line = LiveDelay::new(300, 128);
        line.restart(0);
        line.send(&[1.0; 600]);
        let mut heard = [0.0; 128];
        assert!(!line.listen(100, Some(1e6), &mut heard));
        assert!(!line.listen(100, Some(f64::NAN), &mut heard));
        // Fades in from no reception, and out to no reception.
        assert!(line.listen(300, Some(50.0), &mut heard));
        assert!(heard[0] < 0.02 && (heard[127] - 1.0).abs() < 1e-3, "{heard:?}");
        assert!(line.listen(428, Some(301.0), &mut heard));
        assert!(heard[0] > 0.98 && heard[127] < 1e-3, "{heard:?}");
    }
}
