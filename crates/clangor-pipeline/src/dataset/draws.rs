//! Random numbers of one strike: each quantity has a sequence of its own, given by seed, number and quantity.
//!
//! So a strike depends on no other strike, and a quantity on no other quantity of the same strike.

use clangor_core::math::random::SplitMix;

/// What is drawn. The numbers belong to the format of data sets: a new quantity gets a new one.
#[derive(Clone, Copy, Debug)]
pub(super) enum Quantity {
    Object = 1,
    Material = 2,
    Point = 3,
    Striker = 4,
    Listener = 5,
    Room = 6,
}

/// Odd factors that keep seeds, strikes and quantities apart before they are mixed.
const STRIKE_FACTOR: u64 = 0xd1b5_4a32_d192_ed03;
const QUANTITY_FACTOR: u64 = 0x8cb9_2ba7_2f3d_8dd7;

/// The numbers of a quantity of a strike.
pub(super) struct Draws(SplitMix);

impl Draws {
    pub(super) fn of(seed: u64, number: u64, quantity: Quantity) -> Self {
        let of_strike = mix(mix(seed) ^ number.wrapping_mul(STRIKE_FACTOR));
        Draws(SplitMix::new(mix(of_strike ^ (quantity as u64).wrapping_mul(QUANTITY_FACTOR))))
    }

    /// Even in [0, 1).
    pub(super) fn share(&mut self) -> f64 {
        self.0.uniform(0.0, 1.0)
    }

    /// One of `count` with equal chances; 0 where there is only one.
    pub(super) fn choice(&mut self, count: usize) -> usize {
        ((self.share() * count as f64) as usize).min(count.saturating_sub(1))
    }
}

/// The finaliser of SplitMix64: a bijection in which every bit depends on all.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_neighbouring_strikes_and_quantities_are_uncorrelated() {
        const COUNT: usize = 20_000;
        let sequence = |seed, quantity| -> Vec<f64> {
            (0..=COUNT as u64).map(|i| Draws::of(seed, i, quantity).share() - 0.5).collect()
        };
        let (a, b, c) =
            (sequence(7, Quantity::Object), sequence(7, Quantity::Material), sequence(8, Quantity::Object));
        let correlation =
            |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() * 12.0 / COUNT as f64;
        // Standard deviation 1/√20000 = 0.0071; residuals seen: below 0.012.
        for r in [correlation(&a, &b), correlation(&a, &c), correlation(&a[1..], &a)] {
            assert!(r.abs() < 0.03, "{r}");
        }
        assert!((correlation(&a, &a) - 1.0).abs() < 0.03);
    }
}
