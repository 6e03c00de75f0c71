//! How loud a pressure signal is: peak and RMS \[Pa\], dB SPL re 20 µPa, and loudness in LUFS (EBU R 128).
//!
//! Levels in dB SPL are of pressure; LUFS refers to a file's full scale, as a player sees it. Every channel
//! counts as a front loudspeaker.

use ebur128::{Channel, EbuR128, Mode};

/// Pressure of 0 dB SPL \[Pa\].
pub const REFERENCE_PRESSURE: f64 = 20e-6;

/// Level of a pressure in dB SPL; `None` for silence.
pub fn db_spl(pressure: f64) -> Option<f64> {
    (pressure > 0.0).then(|| 20.0 * (pressure / REFERENCE_PRESSURE).log10())
}

/// Levels of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelLevels {
    /// Largest magnitude of a sample \[Pa\].
    pub peak: f64,
    /// Frame at which the peak is first reached.
    pub peak_frame: u64,
    /// Root mean square over the whole signal \[Pa\].
    pub rms: f64,
}

/// Levels of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Frames measured.
    pub frames: u64,
    /// Each channel.
    pub channels: Vec<ChannelLevels>,
    /// Integrated loudness \[LUFS\] re full scale; `None` where it is undefined: less than 0.4 s, silence
    /// under the gate of −70 LUFS, or more channels than the standard's meter takes.
    pub loudness: Option<f64>,
}

/// Measures a signal as it streams by.
pub struct LevelMeter {
    full_scale: f64,
    frames: u64,
    sums: Vec<f64>,
    channels: Vec<ChannelLevels>,
    loudness: Option<EbuR128>,
    scaled: Vec<f32>,
}

impl LevelMeter {
    /// A meter for interleaved pressure of this many channels at `sample_rate` \[Hz\] and `full_scale`
    /// \[Pa\].
    pub fn new(channels: u16, sample_rate: u32, full_scale: f64) -> Self {
        let count = usize::from(channels);
        // Without a histogram, which ends at 30 LUFS: pressures of 30 times full scale are louder. An hour
        // has 36 000 blocks of 8 bytes.
        let mut loudness = EbuR128::new(channels.into(), sample_rate, Mode::I).ok();
        if let Some(meter) = &mut loudness
            && count > 2
        {
            let mapped = (0..u32::from(channels)).all(|c| meter.set_channel(c, Channel::Left).is_ok());
            loudness = loudness.filter(|_| mapped);
        }
        LevelMeter {
            full_scale,
            frames: 0,
            sums: vec![0.0; count],
            channels: vec![ChannelLevels::default(); count],
            loudness,
            scaled: Vec::new(),
        }
    }

    /// Takes whole frames of pressure \[Pa\].
    ///
    /// # Panics
    /// If `pressure` does not hold whole frames.
    pub fn add(&mut self, pressure: &[f32]) {
        let count = self.channels.len();
        assert!(count > 0 && pressure.len().is_multiple_of(count), "whole frames");
        for frame in pressure.chunks_exact(count) {
            for ((level, sum), p) in self.channels.iter_mut().zip(&mut self.sums).zip(frame) {
                let p = f64::from(*p);
                *sum += p * p;
                if p.abs() > level.peak {
                    level.peak = p.abs();
                    level.peak_frame = self.frames;
                }
            }
            self.frames += 1;
        }
        if let Some(meter) = &mut self.loudness {
            self.scaled.clear();
            let scale = 1.0 / self.full_scale;
            self.scaled.extend(pressure.iter().map(|p| (f64::from(*p) * scale) as f32));
            if meter.add_frames_f32(&self.scaled).is_err() {
                self.loudness = None;
            }
        }
    }

    /// What has been measured so far.
    pub fn levels(&self) -> Levels {
        let rms = |sum: &f64| if self.frames == 0 { 0.0 } else { (sum / self.frames as f64).sqrt() };
        let channels = self
            .channels
            .iter()
            .zip(&self.sums)
            .map(|(c, sum)| ChannelLevels { rms: rms(sum), ..*c })
            .collect();
        let loudness =
            self.loudness.as_ref().and_then(|m| m.loudness_global().ok()).filter(|l| l.is_finite());
        Levels { frames: self.frames, channels, loudness }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Two seconds of a sine \[Pa\].
    fn sine(rate: u32, frequency: f64, amplitude: f64, channels: usize) -> Vec<f32> {
        let sample = |i: u32| (amplitude * (TAU * frequency * f64::from(i) / f64::from(rate)).sin()) as f32;
        (0..2 * rate).flat_map(|i| std::iter::repeat_n(sample(i), channels)).collect()
    }

    #[test]
    fn one_pascal_rms_is_94_db_spl() {
        let mut meter = LevelMeter::new(1, 48_000, 1.0);
        for block in sine(48_000, 1000.0, 2f64.sqrt(), 1).chunks(1000) {
            meter.add(block);
        }
        let levels = meter.levels();
        // Seen: 93.9794 for the exact 1 Pa; the sine's f32 samples move it by 2e-9.
        assert!((db_spl(levels.channels[0].rms).unwrap() - 93.979_400_1).abs() < 1e-6);
        assert!((levels.channels[0].peak - 2f64.sqrt()).abs() < 1e-6);
        assert_eq!(levels.channels[0].peak_frame, 12);
        assert_eq!(db_spl(0.0), None);
    }

    #[test]
    fn loudness_of_the_standard_tone_at_every_rate() {
        // EBU Tech 3341: a stereo sine of 1 kHz at −23 dBFS peak per channel reads −23.0 LUFS, ±0.1.
        let full_scale = 20.0;
        let amplitude = full_scale * 10f64.powf(-23.0 / 20.0);
        for rate in [8_000, 44_100, 48_000, 192_000, 384_000] {
            let mut meter = LevelMeter::new(2, rate, full_scale);
            meter.add(&sine(rate, 1000.0, amplitude, 2));
            // Seen: within 0.05 LU at every rate.
            assert!(
                (meter.levels().loudness.unwrap() + 23.0).abs() < 0.1,
                "{rate}: {:?}",
                meter.levels().loudness
            );
        }
    }

    #[test]
    fn loudness_has_no_upper_end() {
        // The standard tone, 100 dB louder.
        let mut meter = LevelMeter::new(2, 48_000, 1.0);
        meter.add(&sine(48_000, 1000.0, 10f64.powf((100.0 - 23.0) / 20.0), 2));
        let loudness = meter.levels().loudness.expect("two seconds");
        // Seen: 0.0067.
        assert!((loudness - 77.0).abs() < 0.1, "{loudness}");
    }

    #[test]
    fn undefined_loudness_is_none() {
        let mut silent = LevelMeter::new(2, 48_000, 1.0);
        silent.add(&vec![0.0; 96_000]);
        assert_eq!(silent.levels().loudness, None);
        let mut short = LevelMeter::new(1, 48_000, 1.0);
        short.add(&[0.5; 100]);
        assert_eq!(short.levels().loudness, None);
        let mut many = LevelMeter::new(1000, 48_000, 1.0);
        many.add(&vec![0.5; 48_000_000 / 1000]);
        assert_eq!(many.levels().loudness, None);
        assert_eq!(LevelMeter::new(1, 48_000, 1.0).levels().channels[0].rms, 0.0);
    }
}
