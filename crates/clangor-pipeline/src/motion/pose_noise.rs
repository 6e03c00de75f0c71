//! Noise of recorded positions, measured from the frames of one body as they come.
//!
//! ```text
//! Δvₖ = vₖ − vₖ₋₁ − g h        eₖ = |Δvₖ − Δvₖ₋₁|
//! noise σ of a coordinate:      Δv has √6 σ/h, Δvₖ − Δvₖ₋₁ has √20 σ/h on each axis
//! ```
//!
//! Free flight, and a steady force, leave e to the noise alone, and a force that changes adds to it. The
//! lowest tenth of all e that are not zero is therefore taken for noise: of normal noise on three axes, it is
//! 0.764 times the deviation of one. Frames that repeat their velocity exactly tell nothing, nor do fewer
//! than fifty others. A recording without any steady moment has its fluctuations of force taken for noise,
//! which errs towards silence.

use glam::DVec3;

/// Value below which a tenth of the lengths of normal vectors lie, in deviations of one axis.
const LOWEST_TENTH: f64 = 0.764;
/// Deviation of Δv over that of its difference, √(6/20).
const OF_DIFFERENCE: f64 = 0.547_722_557_505_166_1;
/// Fewest frames that tell of noise.
const FEWEST: u64 = 50;
/// Classes of e², two for each power of two, from 2⁻⁸⁰ (e = 9e-13 m/s) on.
const CLASSES: usize = 240;
const MANTISSA_BITS: u32 = 51;
const LOWEST: u64 = (1023 - 80) << (52 - MANTISSA_BITS);

/// What the frames of a body tell about their noise.
#[derive(Clone, Debug)]
pub(super) struct PoseNoise {
    /// Last velocity [m/s] and the length of its interval \[s\].
    velocity: Option<(DVec3, f64)>,
    jump: Option<DVec3>,
    counts: Vec<u32>,
}

impl PoseNoise {
    pub(super) fn new() -> Self {
        PoseNoise { velocity: None, jump: None, counts: vec![0; CLASSES] }
    }

    /// Takes the mean velocity [m/s] of the next interval of a length \[s\], under gravity [m/s²].
    pub(super) fn push(&mut self, velocity: DVec3, length: f64, gravity: DVec3) {
        let Some((before, earlier)) = self.velocity.replace((velocity, length)) else { return };
        let jump = velocity - before - gravity * (0.5 * (length + earlier));
        let Some(last) = self.jump.replace(jump) else { return };
        let square = (jump - last).length_squared();
        let class = (square.to_bits() >> MANTISSA_BITS).saturating_sub(LOWEST);
        if square > 0.0
            && let Some(count) = self.counts.get_mut(class as usize)
        {
            *count = count.saturating_add(1);
        }
    }

    /// Deviation of Δv on one axis that is noise [m/s]; 0 if none was seen.
    pub(super) fn of_jumps(&self) -> f64 {
        let all: u64 = self.counts.iter().map(|count| u64::from(*count)).sum();
        let mut below = 0;
        let reached = self.counts.iter().position(|count| {
            below += u64::from(*count);
            below * 10 > all
        });
        let Some(class) = reached.filter(|_| all >= FEWEST) else { return 0.0 };
        // The middle of the class.
        let bits = ((LOWEST + class as u64) << MANTISSA_BITS) + (1 << (MANTISSA_BITS - 1));
        f64::from_bits(bits).sqrt() / LOWEST_TENTH * OF_DIFFERENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly spread numbers in −1 … 1 (Lehmer's generator).
    fn noise(state: &mut u64) -> f64 {
        *state = *state * 48271 % 0x7fff_ffff;
        2.0 * (*state as f64 / f64::from(0x7fff_ffff)) - 1.0
    }

    #[test]
    fn the_noise_of_positions_is_measured_beside_a_fall_and_bounces() {
        let (h, g, mut seed) = (1.0 / 240.0, DVec3::NEG_Y * 9.81, 7);
        let deviation = 1e-4;
        let mut place = |k: u32| {
            let t = (f64::from(k) * h).rem_euclid(0.2);
            let mut jitter = || noise(&mut seed) * deviation * 3.0_f64.sqrt();
            DVec3::new(jitter(), t - 0.5 * 9.81 * t * t + jitter(), jitter())
        };
        let places: Vec<DVec3> = (0..4000).map(&mut place).collect();
        let mut measured = PoseNoise::new();
        places.windows(2).for_each(|pair| measured.push((pair[1] - pair[0]) / h, h, g));
        let expected = 6.0_f64.sqrt() * deviation / h;
        // Seen: 0.99.
        let ratio = measured.of_jumps() / expected;
        assert!((0.8..1.25).contains(&ratio), "{ratio}");
    }

    #[test]
    fn what_stands_still_or_moves_evenly_has_no_noise() {
        for velocity in [DVec3::ZERO, DVec3::X] {
            let mut measured = PoseNoise::new();
            (0..100).for_each(|_| measured.push(velocity, 0.01, DVec3::NEG_Y * 9.81));
            assert_eq!(measured.of_jumps(), 0.0);
        }
    }
}
