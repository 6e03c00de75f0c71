//! Poses of other instants than their times say: frames that a program takes at the nearest step of its
//! engine, and labels with even times.
//!
//! ```text
//! rₖ = (Δvₖ − g h)·v̂ / |v| = (τₖ₊₁ − 2 τₖ + τₖ₋₁)/h        τₖ: error of the time of pose k
//! ⟨r²⟩ = 6 ⟨τ²⟩/h²        ⟨rₖ rₖ₊₁⟩/⟨r²⟩ = −2/3        nothing across v
//! ```
//!
//! Noise of positions has as much across the way as along it; friction has one sign, and impacts are few.

use glam::DVec3;

/// Least speed at which a pose is looked at [m/s], and the largest r, beyond which it is an impact.
const MOVES: f64 = 1.0;
const LARGEST: f64 = 0.5;
/// Fewest poses, and the least error of a time, over the distance of the poses, that is reported.
const FEWEST: u64 = 40;
const LEAST: f64 = 0.01;
/// Largest correlation of neighbours, and least ratio of squares along and across the way.
const CORRELATION: f64 = -0.4;
const ALONG: f64 = 9.0;

/// What the flights of one body say of its times so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UnevenTimes {
    last: Option<f64>,
    count: u64,
    along: f64,
    across: f64,
    neighbours: f64,
    spans: f64,
}

impl UnevenTimes {
    /// Takes the mean velocities [m/s] before and after a pose, the mean of their times \[s\], and gravity
    /// [m/s²].
    pub(super) fn push(&mut self, [before, after]: [DVec3; 2], span: f64, gravity: DVec3) {
        let mean = 0.5 * (before + after);
        // Most poses rest, without a root.
        if mean.length_squared() < MOVES * MOVES {
            self.last = None;
            return;
        }
        let speed = mean.length();
        let (direction, jump) = (mean / speed, (after - before - gravity * span) / speed);
        if jump.length_squared() > LARGEST * LARGEST {
            self.last = None;
            return;
        }
        let r = jump.dot(direction);
        self.count += 1;
        self.along += r * r;
        self.across += (jump - direction * r).length_squared();
        self.neighbours += self.last.map_or(0.0, |last| last * r);
        self.spans += span;
        self.last = Some(r);
    }

    /// The deviation of the times \[s\], if they are uneven.
    pub(super) fn found(&self) -> Option<f64> {
        let count = self.count as f64;
        let share = (self.along / (6.0 * count)).sqrt();
        let is_found = self.count >= FEWEST
            && share > LEAST
            && self.along > ALONG * self.across
            && self.neighbours < CORRELATION * self.along;
        is_found.then(|| share * self.spans / count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);
    const RATE: f64 = 960.0;

    fn of(place: impl Fn(u32) -> DVec3) -> Option<f64> {
        let mut times = UnevenTimes::default();
        let velocity = |k: u32| (place(k) - place(k - 1)) * RATE;
        (2..400).for_each(|k| times.push([velocity(k - 1), velocity(k)], 1.0 / RATE, G));
        times.found()
    }

    #[test]
    fn steps_near_a_frame_are_seen_and_flights_noise_and_friction_are_not() {
        let flight = |t: f64| DVec3::new(2.0 * t, 1.0 + 0.5 * G.y * t * t, 0.0);
        let even = |k: u32| f64::from(k) / RATE;
        // The nearest of 4000 steps a second: even errors of up to half a step. Those of neighbours are a
        // little alike, which takes some off. Seen: 24 %.
        let deviation = of(|k| flight((even(k) * 4000.0).round() / 4000.0)).unwrap();
        let expected = 0.5 / 4000.0 / 3.0_f64.sqrt();
        assert!((deviation / expected - 1.0).abs() < 0.3, "{deviation}");
        assert_eq!(of(|k| flight(even(k))), None);
        let noise = |k: u32, axis: u32| f64::from((k * 7919 + axis * 104_729) % 1009) / 1009.0 * 1e-4;
        assert_eq!(of(|k| flight(even(k)) + DVec3::new(noise(k, 0), noise(k, 1), noise(k, 2))), None);
        assert_eq!(of(|k| DVec3::X * (3.0 * even(k) - 2.0 * even(k) * even(k))), None);
    }
}
