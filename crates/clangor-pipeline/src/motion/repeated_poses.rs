//! Poses that repeat the one before while a body moves: an animation on twos, or dropped frames that a
//! program has filled in.
//!
//! ```text
//! vₖ = (xₖ₊₁ − xₖ)/h      v, 0, …, 0, w      |v|, |w| > 0.5 m/s,  v·w > ½ |v| |w|,  at most 8 zeros
//! ```
//!
//! A body that stops for a moment, as at the top of its flight, goes on in another direction or slowly. One
//! that rests and is hit stands still for longer.

use glam::DVec3;

/// Least speed beside repeated poses [m/s], and the least cosine between both velocities.
const MOVES: f64 = 0.5;
const SAME_DIRECTION: f64 = 0.5;
/// Most repeated poses in a row.
const MOST: u64 = 8;
/// Fewest repeated poses that are told, and their least share of those in motion.
const FEWEST: u64 = 5;
const SHARE: f64 = 0.05;

/// The repeated poses of one body so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RepeatedPoses {
    /// Last velocity in motion [m/s], and the poses since that repeat it.
    velocity: DVec3,
    still: u64,
    /// Row of the first that still counts.
    row: u64,
    count: u64,
    first_row: u64,
    moving: u64,
}

impl RepeatedPoses {
    /// Takes the mean velocity [m/s] up to the pose in a row.
    pub(super) fn push(&mut self, velocity: DVec3, row: u64) {
        if velocity == DVec3::ZERO {
            self.row = if self.still == 0 { row } else { self.row };
            self.still += 1;
            return;
        }
        let still = std::mem::take(&mut self.still);
        let before = std::mem::replace(&mut self.velocity, velocity);
        let [one, two] = [before, velocity].map(DVec3::length);
        self.moving += u64::from(two > MOVES);
        let goes_on = one.min(two) > MOVES && before.dot(velocity) > SAME_DIRECTION * one * two;
        if (1..=MOST).contains(&still) && goes_on {
            self.first_row = if self.count == 0 { self.row } else { self.first_row };
            self.count += still;
        }
    }

    /// How many there are, and the row of the first, if they are a good share of the poses in motion.
    pub(super) fn found(&self) -> Option<(u64, u64)> {
        let is_share = self.count as f64 > SHARE * (self.moving + self.count) as f64;
        (self.count >= FEWEST && is_share).then_some((self.count, self.first_row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Repeated poses of a height at 48 poses a second, of which each `on` stand.
    fn of(height: impl Fn(f64) -> f64, on: u32) -> Option<(u64, u64)> {
        let mut repeated = RepeatedPoses::default();
        let at = |k: u32| DVec3::Y * height(f64::from(k - k % on) / 48.0);
        (1..96).for_each(|k| repeated.push((at(k) - at(k - 1)) * 48.0, u64::from(k)));
        repeated.found()
    }

    #[test]
    fn motion_on_twos_repeats_and_bounces_rests_and_walks_do_not() {
        let bounces = |t: f64| (t % 0.5) * (0.5 - t % 0.5) * 4.9;
        assert_eq!(of(bounces, 1), None);
        assert!(of(bounces, 2).is_some_and(|(count, row)| count > 20 && row < 10));
        assert!(of(bounces, 3).is_some());
        // It rests for half a second and is hit, again and again.
        assert_eq!(of(|t| (t % 1.0 - 0.5).max(0.0), 1), None);
        assert_eq!(of(|_| 0.0, 2), None);
    }
}
