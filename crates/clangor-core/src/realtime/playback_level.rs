//! From pressure to the samples of an output device, which end at 1.

/// The pressure of full scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaybackLevel {
    /// Pressure of a sample of 1 \[Pa\].
    pub full_scale: f64,
}

impl PlaybackLevel {
    /// The sample of a pressure \[Pa\]: proportional up to one half, then compressed so that it never exceeds
    /// 1. For playback only: a compressed sample is no longer a pressure.
    pub fn sample(&self, pressure: f64) -> f32 {
        let x = pressure / self.full_scale;
        let size = x.abs();
        let bent = if size <= 0.5 { size } else { 0.5 + 0.5 * (1.0 - (1.0 - 2.0 * size).exp()) };
        bent.copysign(x) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_straight_smooth_and_bounded() {
        let level = PlaybackLevel { full_scale: 2.0 };
        assert_eq!(level.sample(0.8), 0.4);
        assert_eq!(level.sample(-0.8), -0.4);
        let slope = |x: f64| f64::from(level.sample(x + 1e-3) - level.sample(x)) / 1e-3;
        assert!((slope(0.998) - slope(1.0)).abs() < 2e-3);
        assert!(level.sample(1e9) <= 1.0 && level.sample(-1e9) >= -1.0);
    }
}
