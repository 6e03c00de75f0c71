//! Places of a body at the emission times of the sound received now.

use glam::DVec3;

/// Places of the recent past, at the ends of blocks.
#[derive(Clone, Debug)]
pub(super) struct LiveTrail {
    /// Sample and place, in a ring buffer.
    places: Vec<(f64, DVec3)>,
    /// The last one.
    last: usize,
}

impl LiveTrail {
    /// For this number of past samples, in blocks of at least a quarter of that; shorter blocks keep less.
    pub(super) fn new(longest: usize, block: usize) -> Self {
        let kept = (4 * longest).div_ceil(block.max(1)) + 2;
        LiveTrail { places: vec![(0.0, DVec3::ZERO); kept], last: 0 }
    }

    /// Sets the place for all past times.
    pub(super) fn restart(&mut self, sample: f64, place: DVec3) {
        self.places.fill((sample, place));
    }

    /// Appends the present place.
    pub(super) fn push(&mut self, sample: f64, place: DVec3) {
        self.last = (self.last + 1) % self.places.len();
        self.places[self.last] = (sample, place);
    }

    /// Place at a sample, linear between stored ones; before them the first.
    pub(super) fn at(&self, sample: f64) -> DVec3 {
        let count = self.places.len();
        let mut later = self.places[self.last];
        for k in 1..count {
            let earlier = self.places[(self.last + count - k) % count];
            if earlier.0 <= sample || earlier.0 > later.0 {
                let span = later.0 - earlier.0;
                let part = if span > 0.0 { ((sample - earlier.0) / span).clamp(0.0, 1.0) } else { 0.0 };
                return earlier.1 + (later.1 - earlier.1) * part;
            }
            later = earlier;
        }
        later.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_past_is_kept_as_long_as_it_was_asked_for() {
        let mut trail = LiveTrail::new(1000, 100);
        trail.restart(0.0, DVec3::ZERO);
        assert_eq!(trail.at(-50.0), DVec3::ZERO);
        for k in 1..200 {
            trail.push(25.0 * f64::from(k), f64::from(k) * DVec3::X);
        }
        let now = 25.0 * 199.0;
        for ago in [0.0, 10.0, 312.5, 1000.0] {
            let place = trail.at(now - ago);
            assert!((place - DVec3::X * ((now - ago) / 25.0)).length() < 1e-12, "{ago}: {place}");
        }
        assert_eq!(trail.at(now + 9.0), 199.0 * DVec3::X);
    }
}
