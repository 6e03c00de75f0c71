//! Dynamic range compression, after which a signal is no longer pressure.
//!
//! Feed-forward, one gain for all channels. With x the largest magnitude of a frame over full scale and T, R
//! threshold and ratio, the static gain is −max(0, 20 lg x − T)(1 − 1/R) dB. It is followed by a one-pole
//! filter in decibels, with the attack time constant while gain must fall and the release time constant while
//! it recovers. No look-ahead, so a click shorter than the attack passes; no knee.

use crate::scene::render_description;

/// A compressor at work: its gain carries over from one stretch of signal to the next.
#[derive(Clone, Debug)]
pub struct Compressor {
    settings: render_description::Compressor,
    full_scale: f64,
    attack: f64,
    release: f64,
    gain_db: f64,
}

impl Compressor {
    /// A compressor for a signal at `sample_rate` \[Hz\] whose full scale is `full_scale` \[Pa\].
    pub fn new(settings: &render_description::Compressor, sample_rate: f64, full_scale: f64) -> Self {
        // Share of the distance to the static gain that is left after one sample; a time of 0 leaves none.
        let left = |time: f64| (-1.0 / (time * sample_rate)).exp();
        Compressor {
            settings: *settings,
            full_scale,
            attack: left(settings.attack),
            release: left(settings.release),
            gain_db: 0.0,
        }
    }

    /// Compresses the next stretch of all channels, which are of equal length, in place.
    pub fn process(&mut self, channels: &mut [Vec<f64>]) {
        let frames = channels.iter().map(Vec::len).min().unwrap_or(0);
        for frame in 0..frames {
            let peak = channels.iter().map(|channel| channel[frame].abs()).fold(0.0, f64::max);
            let gain = self.next_gain(peak);
            channels.iter_mut().for_each(|channel| channel[frame] *= gain);
        }
    }

    /// Gain factor for a frame whose largest magnitude is `peak` \[Pa\].
    fn next_gain(&mut self, peak: f64) -> f64 {
        let render_description::Compressor { threshold_db, ratio, makeup_db, .. } = self.settings;
        // Silence has no level; −∞ dB is below every threshold.
        let excess = (20.0 * (peak / self.full_scale).log10() - threshold_db).max(0.0);
        let target = -excess * (1.0 - 1.0 / ratio);
        let left = if target < self.gain_db { self.attack } else { self.release };
        self.gain_db = target + left * (self.gain_db - target);
        10f64.powf((self.gain_db + makeup_db) / 20.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: render_description::Compressor = render_description::Compressor {
        threshold_db: -20.0,
        ratio: 4.0,
        attack: 0.001,
        release: 0.05,
        makeup_db: 0.0,
    };

    #[test]
    fn settles_on_the_static_curve_with_the_attack_time() {
        let mut compressor = Compressor::new(&SETTINGS, 48_000.0, 2.0);
        // 0 dB re full scale is 20 dB over the threshold: 5 dB over it in the end, a gain of −15 dB.
        let mut channels = vec![vec![2.0; 4800], vec![0.02; 4800]];
        compressor.process(&mut channels);
        let gain_db = |frame: usize| 20.0 * (channels[0][frame] / 2.0).log10();
        // Residual seen: 1e-14 dB.
        assert!((gain_db(4799) + 15.0).abs() < 1e-12);
        // After one time constant, the 48th sample, 1/e of the way is left. Residual seen: 1e-14 dB.
        assert!((gain_db(47) + 15.0 * (1.0 - (-1.0f64).exp())).abs() < 1e-12);
        assert_eq!(channels[1][4799] / 0.02, channels[0][4799] / 2.0, "one gain for all channels");
    }

    #[test]
    fn leaves_what_is_below_the_threshold_and_recovers() {
        let mut compressor = Compressor::new(&SETTINGS, 48_000.0, 1.0);
        let quiet = vec![0.09; 100];
        let mut channels = vec![quiet.clone()];
        compressor.process(&mut channels);
        assert_eq!(channels[0], quiet);
        compressor.process(&mut [vec![1.0; 1000]]);
        compressor.process(&mut [vec![0.0; 48_000]]);
        // 20 release times: 15 dB e^−20 are left.
        assert!(compressor.gain_db > -1e-7 && compressor.gain_db <= 0.0);
    }

    #[test]
    fn stretches_do_not_matter() {
        let signal: Vec<f64> = (0..3000).map(|i| (0.01 * f64::from(i)).sin()).collect();
        let mut whole = vec![signal.clone()];
        Compressor::new(&SETTINGS, 48_000.0, 1.0).process(&mut whole);
        let mut compressor = Compressor::new(&SETTINGS, 48_000.0, 1.0);
        let mut pieces = Vec::new();
        for piece in signal.chunks(777) {
            let mut channels = [piece.to_vec()];
            compressor.process(&mut channels);
            pieces.extend_from_slice(&channels[0]);
        }
        assert_eq!(pieces, whole[0]);
    }
}
