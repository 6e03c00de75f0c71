//! Positions that were rounded to so many decimals, and the noise that this is.
//!
//! ```text
//! x = n q    for all coordinates of all frames, q = 10⁻¹ … 10⁻⁵ m        |δΔv| ≤ 2 q/h
//! ```
//!
//! The error of a jump has a bound, which normal noise has not: the noise is that of which five deviations
//! are the bound.
//!
//! A body that mostly rests shows its noise at few frames, where it leaps by a whole q. Coordinates that lie
//! on a grid without having been rounded belong to motion that is even between a few events; how many frames
//! are uneven is therefore asked too.

use glam::DVec3;

use super::jump_windows::CLEAR_OF_NOISE;

/// Finest grid that is looked for, as a number of decimals.
const FINEST: u32 = 5;
/// Largest distance from the grid, over its spacing, of numbers in 64 bits; ones in 32 have other digits.
const ON_GRID: f64 = 1e-4;
/// Fewest frames that leave the even motion of those before, and by how much at least \[m\].
const FEWEST: u64 = 20;
const UNEVEN: f64 = 5e-6;

/// The grid on which the positions of one body lie so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CoordinateRounding {
    decimals: u32,
    uneven: u64,
}

impl CoordinateRounding {
    /// Takes the position \[m\] of the next frame, and how far it is from where the last two lead \[m\].
    pub(super) fn push(&mut self, position: DVec3, beyond: f64) {
        while self.decimals <= FINEST {
            let units = position * 10_f64.powi(self.decimals as i32);
            if (units - units.round()).abs().max_element() < ON_GRID {
                break;
            }
            self.decimals += 1;
        }
        self.uneven += u64::from(beyond > UNEVEN);
    }

    /// Deviation of Δv times the length of a frame that stands for rounding \[m\]; 0 if none was seen.
    pub(super) fn deviation(&self) -> f64 {
        let is_rounded = self.decimals > 0 && self.decimals <= FINEST && self.uneven >= FEWEST;
        if is_rounded { 2.0 / CLEAR_OF_NOISE * 10_f64.powi(-(self.decimals as i32)) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(height: impl Fn(f64) -> f64) -> f64 {
        let mut rounding = CoordinateRounding::default();
        let at = |k: i32| height(f64::from(k) / 1000.0);
        for k in 2..500 {
            rounding.push(DVec3::Y * at(k), (at(k) - 2.0 * at(k - 1) + at(k - 2)).abs());
        }
        rounding.deviation()
    }

    #[test]
    fn rounded_falls_are_seen_and_even_motion_is_not() {
        let rounded = |x: f64| (x * 1e3).round() / 1e3;
        let q = 0.4e-3;
        assert!((of(|t| rounded(0.5 - 4.9 * t * t)) / q - 1.0).abs() < 1e-9);
        // One that nearly rests.
        assert!((of(|t| rounded(0.02 + 0.0012 * (40.0 * t).sin())) / q - 1.0).abs() < 1e-9);
        assert_eq!(of(|t| 0.5 - 4.9 * t * t), 0.0);
        // A millimetre in each frame, there and back.
        assert_eq!(of(|t| (t - 0.25).abs()), 0.0);
    }
}
