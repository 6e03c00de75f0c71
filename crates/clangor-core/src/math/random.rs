//! Reproducible random numbers: shapes and placements made from a seed.

use std::f64::consts::TAU;

use glam::DVec3;

/// SplitMix64: Steele, Lea, Flood (2014), "Fast splittable pseudorandom number generators".
#[derive(Clone, Debug)]
pub struct SplitMix(u64);

impl SplitMix {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        SplitMix(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// A unit vector, even over all directions.
    pub fn direction(&mut self) -> DVec3 {
        let (z, turn) = (self.uniform(-1.0, 1.0), self.uniform(0.0, TAU));
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), z)
    }
}
