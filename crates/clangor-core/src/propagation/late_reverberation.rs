//! Late reverberation of a room: a feedback delay network.
//!
//! The energy of a source with unit pressure at 1 m fills the room evenly and decays, so that the squared
//! response is
//!
//! ```text
//! h²(t) = (4π c/V) e^(−13.8 t/T(f))
//! T = (24 ln 10/c) V / (−S ln(1 − ᾱ) + 8 α_air V)          Eyring (1930), with the air
//! ```
//!
//! Sixteen delay lines of different lengths D_i feed one another through an orthogonal matrix, which
//! conserves energy. Each line attenuates by 60 D_i/T(f) decibels, so that every mode of the network decays
//! as the room does (J.-M. Jot and A. Chaigne 1991). The attenuation is a chain of octave filters.
//! Neighbouring filters overlap, so their gains are solved for together, to meet T at the middle of every
//! octave (S. J. Schlecht and E. A. P. Habets 2017, "Accurate reverberation time control in feedback delay
//! networks").
//!
//! The input is the pressure of the first-order reflections, times their distance: it contains the radiation
//! of the source in several directions. The output is pressure in pascals at the level that room statistics
//! predict. Each receiver has another sum of the lines, so both ears get different signals. Not covered: the
//! fine structure of a room, such as single late echoes of a long corridor or the flutter between two hard
//! walls.

use std::f64::consts::{LN_10, PI, TAU};

use super::{Air, Room, RoomError};
use crate::propagation::wall::OCTAVES;

/// Delay lines.
const LINES: usize = 16;
/// Octave filters: those of the walls, one below and one above.
const SECTIONS: usize = OCTAVES.len() + 2;
/// Centre frequency over bandwidth of a filter: wide enough for octaves to join without ripples.
const QUALITY: f64 = 1.0;
/// Centre frequencies of filters are below this fraction of the sample rate.
const HIGHEST_MIDDLE: f64 = 0.4;
/// Shortest line \[s\]: with a shorter one, the network rings.
const SHORTEST: f64 = 0.013;
/// Largest attenuation of one line \[dB\]; with perfectly absorbing walls nothing audible remains.
const SILENCE: f64 = 200.0;
/// The longest line over the shortest.
const SPREAD: f64 = 2.3;

/// Reverberation time of a room: the time for a decay by 60 dB.
#[derive(Clone, Debug)]
pub struct ReverberationTimes<'a> {
    room: &'a Room,
    air: Option<&'a Air>,
    sound_speed: f64,
}

impl<'a> ReverberationTimes<'a> {
    /// For a room filled with air that absorbs or not.
    pub fn new(room: &'a Room, air: Option<&'a Air>, sound_speed: f64) -> Self {
        ReverberationTimes { room, air, sound_speed }
    }

    /// T \[s\] at a `frequency` \[Hz\]; infinite where nothing absorbs.
    pub fn at(&self, frequency: f64) -> f64 {
        let areas = self.room.wall_areas();
        let all: f64 = areas.iter().sum();
        let absorbed = |(wall, area): (&crate::propagation::WallAbsorption, f64)| {
            area * (1.0 - wall.reflectance(frequency).powi(2))
        };
        let mean: f64 = self.room.walls.iter().zip(areas).map(absorbed).sum::<f64>() / all;
        let walls = -all * (-mean).ln_1p();
        let air = self.air.map_or(0.0, |air| 8.0 * air.attenuation(frequency) * self.room.volume());
        24.0 * LN_10 / self.sound_speed * self.room.volume() / (walls + air)
    }
}

/// The network and its state.
#[derive(Clone, Debug)]
pub struct LateReverberation {
    lines: [Line; LINES],
    filters: [Filter; SECTIONS],
    input_gain: f64,
}

/// Samples in a delay line.
#[derive(Clone, Debug)]
struct Line {
    samples: Vec<f64>,
    next: usize,
}

/// One octave filter of all lines: transposed direct form II, y = b₀ x + s₁.
#[derive(Clone, Debug)]
struct Filter {
    b: [[f64; LINES]; 3],
    a: [[f64; LINES]; 2],
    s: [[f64; LINES]; 2],
}

impl LateReverberation {
    /// Number of inputs, each of which enters the lines with other signs.
    pub const INPUTS: usize = 6;
    /// Largest number of outputs that differ from each other and from the inputs.
    pub const OUTPUTS: usize = LINES - Self::INPUTS;

    /// An empty room, for samples at a `rate` \[Hz\].
    ///
    /// # Errors
    /// [`RoomError`].
    pub fn new(room: &Room, air: Option<&Air>, sound_speed: f64, rate: f64) -> Result<Self, RoomError> {
        room.check()?;
        let times = ReverberationTimes::new(room, air, sound_speed);
        if let Some(octave) = OCTAVES.into_iter().find(|f| !times.at(*f).is_finite()) {
            return Err(RoomError::Undamped { octave });
        }
        // The mean free path is 4 V/S. The inputs have met one wall, the first output a second.
        let free_path = 4.0 * room.volume() / room.wall_areas().iter().sum::<f64>();
        let shortest = (free_path / sound_speed).max(SHORTEST) * rate;
        let mut lengths = [0; LINES];
        for (i, length) in lengths.iter_mut().enumerate() {
            *length = prime_from((shortest * SPREAD.powf(i as f64 / (LINES - 1) as f64)) as usize);
        }
        for i in 1..LINES {
            if lengths[i] <= lengths[i - 1] {
                lengths[i] = prime_from(lengths[i - 1] + 1);
            }
        }
        let mut filters = std::array::from_fn(|_| Filter::through());
        for (line, length) in lengths.iter().enumerate() {
            let decibels = |f: f64| (-60.0 * *length as f64 / (rate * times.at(f))).max(-SILENCE);
            for (filter, section) in filters.iter_mut().zip(sections(decibels, rate)) {
                filter.set(line, &section);
            }
        }
        // Energy β² in ΣD samples gives N β²/ΣD at each sample, which is to be 4π c/(V rate).
        let total: usize = lengths.iter().sum();
        let wanted = 4.0 * PI * sound_speed / (room.volume() * rate);
        let energy = wanted * total as f64 / LINES as f64;
        Ok(LateReverberation {
            lines: lengths.map(|length| Line { samples: vec![0.0; length], next: 0 }),
            filters,
            // Each input has the level for a single one: they share the energy.
            input_gain: (energy / (LINES * Self::INPUTS) as f64).sqrt(),
        })
    }

    /// Clears all delay lines and filters.
    pub fn silence(&mut self) {
        self.lines.iter_mut().for_each(|line| line.samples.fill(0.0));
        self.filters.iter_mut().for_each(|filter| filter.s = [[0.0; LINES]; 2]);
    }

    /// Takes the next sample of each input, pressure times distance \[Pa m\], and adds to each output \[Pa\].
    ///
    /// Outputs beyond [`OUTPUTS`](Self::OUTPUTS) repeat the first.
    pub fn step(&mut self, inputs: &[f64; Self::INPUTS], outputs: &mut [f64]) {
        let mut passing: [f64; LINES] = std::array::from_fn(|i| self.lines[i].samples[self.lines[i].next]);
        for filter in &mut self.filters {
            filter.step(&mut passing);
        }
        for (k, output) in outputs.iter_mut().enumerate() {
            let row = Self::INPUTS + k % Self::OUTPUTS;
            *output += (0..LINES).map(|i| sign(row, i) * passing[i]).sum::<f64>();
        }
        hadamard(&mut passing);
        for (i, line) in self.lines.iter_mut().enumerate() {
            let entering: f64 = inputs.iter().enumerate().map(|(k, u)| sign(k, i) * u).sum();
            line.samples[line.next] = passing[i] + self.input_gain * entering;
            line.next = (line.next + 1) % line.samples.len();
        }
    }
}

/// Element of a matrix of signs with orthogonal rows (Hadamard).
fn sign(row: usize, column: usize) -> f64 {
    if (row & column).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// x → H x/√N, in place.
fn hadamard(x: &mut [f64; LINES]) {
    let mut half = 1;
    while half < LINES {
        for start in (0..LINES).step_by(2 * half) {
            for i in start..start + half {
                (x[i], x[i + half]) = (x[i] + x[i + half], x[i] - x[i + half]);
            }
        }
        half *= 2;
    }
    let scale = (LINES as f64).sqrt().recip();
    x.iter_mut().for_each(|x| *x *= scale);
}

/// The smallest prime from `n` on.
fn prime_from(n: usize) -> usize {
    let is_prime = |n: usize| n > 1 && (2..).take_while(|d| d * d <= n).all(|d| !n.is_multiple_of(d));
    (n..).find(|n| is_prime(*n)).unwrap_or(n)
}

impl Filter {
    fn through() -> Self {
        let zero = [0.0; LINES];
        Filter { b: [[1.0; LINES], zero, zero], a: [zero; 2], s: [zero; 2] }
    }

    fn set(&mut self, line: usize, section: &Section) {
        (0..3).for_each(|k| self.b[k][line] = section.b[k]);
        (0..2).for_each(|k| self.a[k][line] = section.a[k]);
    }

    fn step(&mut self, x: &mut [f64; LINES]) {
        let Filter { b: [b0, b1, b2], a: [a1, a2], s: [s1, s2] } = self;
        for (i, x) in x.iter_mut().enumerate() {
            let y = b0[i] * *x + s1[i];
            s1[i] = b1[i] * *x - a1[i] * y + s2[i];
            s2[i] = b2[i] * *x - a2[i] * y;
            *x = y;
        }
    }
}

/// A filter of the second order: (b₀ + b₁ z⁻¹ + b₂ z⁻²)/(1 + a₁ z⁻¹ + a₂ z⁻²).
#[derive(Clone, Copy, Debug)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

impl Section {
    /// Raises or lowers an octave around `middle` \[Hz\] by so many decibels: R. Bristow-Johnson, "Cookbook
    /// formulae for audio equalizer biquad filter coefficients".
    fn peak(middle: f64, decibels: f64, rate: f64) -> Self {
        let (sin, cos) = (TAU * middle / rate).sin_cos();
        let root = 10.0_f64.powf(decibels / 40.0);
        let alpha = sin / (2.0 * QUALITY);
        let a0 = 1.0 + alpha / root;
        let b1 = -2.0 * cos / a0;
        Section {
            b: [(1.0 + alpha * root) / a0, b1, (1.0 - alpha * root) / a0],
            a: [b1, (1.0 - alpha / root) / a0],
        }
    }

    /// Raises or lowers all below (`up` −1) or above (1) `middle` \[Hz\]; same source, slope 1.
    fn shelf(middle: f64, up: f64, decibels: f64, rate: f64) -> Self {
        let (sin, cos) = (TAU * middle / rate).sin_cos();
        let cos = -up * cos;
        let root = 10.0_f64.powf(decibels / 40.0);
        let bend = 2.0 * root.sqrt() * sin * std::f64::consts::FRAC_1_SQRT_2;
        let (sum, difference) = (root + 1.0, root - 1.0);
        let a0 = sum + difference * cos + bend;
        Section {
            b: [
                root * (sum - difference * cos + bend) / a0,
                -up * 2.0 * root * (difference - sum * cos) / a0,
                root * (sum - difference * cos - bend) / a0,
            ],
            a: [up * 2.0 * (difference + sum * cos) / a0, (sum + difference * cos - bend) / a0],
        }
    }

    /// The filter of this index in a chain, with its centre frequency \[Hz\]; `None` above the range of the
    /// sample rate.
    fn of_chain(number: usize, decibels: f64, rate: f64) -> Option<(f64, Self)> {
        const EDGE: f64 = std::f64::consts::SQRT_2;
        let last = OCTAVES.len() - 1;
        let (middle, section) = match number.checked_sub(1) {
            None => (0.5 * OCTAVES[0], Section::shelf(OCTAVES[0] / EDGE, -1.0, decibels, rate)),
            Some(k) if k <= last => (OCTAVES[k], Section::peak(OCTAVES[k], decibels, rate)),
            Some(_) => (2.0 * OCTAVES[last], Section::shelf(OCTAVES[last] * EDGE, 1.0, decibels, rate)),
        };
        (middle < HIGHEST_MIDDLE * rate).then_some((middle, section))
    }

    /// |H| \[dB\].
    fn decibels(&self, frequency: f64, rate: f64) -> f64 {
        let angle = TAU * frequency / rate;
        let size = |c0: f64, c1: f64, c2: f64| {
            let re = c0 + c1 * angle.cos() + c2 * (2.0 * angle).cos();
            let im = c1 * angle.sin() + c2 * (2.0 * angle).sin();
            re * re + im * im
        };
        10.0 * (size(self.b[0], self.b[1], self.b[2]) / size(1.0, self.a[0], self.a[1])).log10()
    }
}

/// A chain of filters with the `wanted` decibels at the middle of every octave.
///
/// The part common to all octaves is a plain factor; filters in its place would ripple between their centre
/// frequencies.
fn sections(wanted: impl Fn(f64) -> f64, rate: f64) -> [Section; SECTIONS] {
    const THROUGH: Section = Section { b: [1.0, 0.0, 0.0], a: [0.0; 2] };
    let common = OCTAVES.map(&wanted).iter().sum::<f64>() / OCTAVES.len() as f64;
    let mut gains = [0.0; SECTIONS];
    let chain = |gains: &[f64; SECTIONS]| -> [Section; SECTIONS] {
        std::array::from_fn(|k| Section::of_chain(k, gains[k], rate).map_or(THROUGH, |(_, section)| section))
    };
    // Gauss–Seidel iteration: each filter in turn compensates the remainder of the others. They overlap by
    // less than half, so that thirty rounds leave 1e-6 dB.
    for _ in 0..30 {
        for k in 0..SECTIONS {
            let Some((middle, _)) = Section::of_chain(k, 0.0, rate) else { continue };
            let has: f64 = chain(&gains).iter().map(|section| section.decibels(middle, rate)).sum();
            gains[k] += wanted(middle) - common - has;
        }
    }
    let mut chain = chain(&gains);
    chain[0].b.iter_mut().for_each(|b| *b *= 10.0_f64.powf(0.05 * common));
    chain
}
