//! Poses on straight lines between keys: a program that samples keys at a higher rate and joins them by
//! lines. Each key then is a jump, and an impact that lies between two keys is cut in two.
//!
//! ```text
//! Δvₖ = vₖ − vₖ₋₁ = 0 but at every n-th pose, while the body moves        n ≥ 2, at least eight keys
//! ```
//!
//! A body that slides or flies without gravity is straight as well, but does not jump at even intervals.

use glam::DVec3;

/// Least speed of a body in motion [m/s].
const MOVES: f64 = 0.1;
/// Jump that is none, over the last one and over the speed: positions have so many digits.
const STRAIGHT: (f64, f64) = (0.02, 1e-5);
/// Fewest keys that are reported, and the longest distance of two \[poses\].
const FEWEST: u64 = 8;
const LONGEST: u64 = 60;

/// The straight lines of one body so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StraightKeys {
    /// Square of the last jump [m²/s²].
    jump: f64,
    /// Straight poses since the last key, and whether the body moved at all of them.
    straight: u64,
    is_moving: bool,
    /// Distance of the last two keys \[poses\], how many keys in a row have it, and the row of the first.
    every: u64,
    keys: u64,
    row: u64,
    found: Option<(u64, u64)>,
}

impl StraightKeys {
    /// Takes the mean velocities [m/s] before and after the pose in a row.
    pub(super) fn push(&mut self, [before, after]: [DVec3; 2], row: u64) {
        // Squares, without roots.
        let jump = before.distance_squared(after);
        let speed = before.length_squared().min(after.length_squared());
        if jump <= (STRAIGHT.0.powi(2) * self.jump).max(STRAIGHT.1.powi(2) * speed) {
            self.straight += 1;
            self.is_moving &= speed > MOVES * MOVES;
            return;
        }
        let every = std::mem::take(&mut self.straight) + 1;
        let is_moving = std::mem::replace(&mut self.is_moving, true);
        self.jump = jump;
        if !(2..=LONGEST).contains(&every) || !is_moving || every != self.every {
            (self.every, self.keys, self.row) = (every, 1, row);
            return;
        }
        self.keys += 1;
        if self.keys >= FEWEST && self.found.is_none() {
            self.found = Some((every, self.row));
        }
    }

    /// The distance of the keys \[poses\], and the row of the first.
    pub(super) fn found(&self) -> Option<(u64, u64)> {
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(height: impl Fn(f64) -> f64) -> Option<(u64, u64)> {
        let mut keys = StraightKeys::default();
        let at = |k: u32| DVec3::Y * height(f64::from(k) / 240.0);
        let velocity = |k: u32| (at(k) - at(k - 1)) * 240.0;
        (2..240).for_each(|k| keys.push([velocity(k - 1), velocity(k)], u64::from(k)));
        keys.found()
    }

    #[test]
    fn lines_between_keys_are_seen_and_flights_and_slides_are_not() {
        let bounces = |t: f64| (t % 0.5) * (0.5 - t % 0.5) * 4.9;
        let lines = |t: f64| {
            let key = (t * 60.0 + 1e-9).floor() / 60.0;
            bounces(key) + (t - key) * 60.0 * (bounces(key + 1.0 / 60.0) - bounces(key))
        };
        let (every, row) = of(lines).unwrap();
        assert!(every == 4 && row < 20, "{every}, {row}");
        assert_eq!(of(bounces), None);
        assert_eq!(of(|t| 0.3 * t), None);
        // It slides to and fro.
        assert_eq!(of(|t| 0.5 * ((t * 4.0) % 2.0 - 1.0).abs()), None);
        assert_eq!(of(|_| 0.0), None);
    }
}
