//! WAV files: what is written comes back, what is wrong is refused, what is unfinished leaves nothing.

use std::path::Path;

use clangor_pipeline::formats::wav::{Meaning, SampleFormat, WavError, WavReader, WavSpec, WavWriter};
use proptest::prelude::*;

fn spec(format: SampleFormat, channels: u16, full_scale: f64) -> WavSpec {
    WavSpec {
        sample_rate: 48_000,
        channels,
        format,
        full_scale,
        meaning: Meaning::Pressure,
        note: String::new(),
    }
}

fn read_all(path: &Path) -> Result<Vec<f32>, WavError> {
    let mut reader = WavReader::open(path)?;
    let mut samples = Vec::new();
    while reader.read(&mut samples, 1000)? > 0 {}
    Ok(samples)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn pascals_come_back_bit_exact(
        frames in prop::collection::vec(-1e6f32..1e6, 0..400),
        channels in 1u16..4,
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        let whole = frames.len() / usize::from(channels) * usize::from(channels);
        let mut writer = WavWriter::create(&path, spec(SampleFormat::Float32, channels, 1.0)).unwrap();
        writer.write(&frames[..whole]).unwrap();
        prop_assert_eq!(writer.finish().unwrap().frames, (whole / usize::from(channels)) as u64);
        prop_assert_eq!(read_all(&path).unwrap(), &frames[..whole]);
    }

    #[test]
    fn pcm_is_within_half_a_step_or_counted_as_clipped(p in prop::collection::vec(-30f32..30.0, 1..200)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        let mut writer = WavWriter::create(&path, spec(SampleFormat::Pcm24, 1, 20.0)).unwrap();
        writer.write(&p).unwrap();
        let summary = writer.finish().unwrap();
        let step = 20.0 / f64::from(1 << 23);
        let mut clipped = 0;
        for (p, s) in p.iter().zip(read_all(&path).unwrap()) {
            let (p, s) = (f64::from(*p), f64::from(s) * 20.0);
            if p.abs() < 19.999_99 {
                prop_assert!((p - s).abs() <= 0.5 * step * (1.0 + 1e-9), "{} {}", p, s);
            } else if p.abs() > 20.0 {
                clipped += 1;
                prop_assert!((s.abs() - 20.0).abs() <= 1.01 * step && s.signum() == p.signum());
            }
        }
        prop_assert_eq!(summary.clipped_samples, clipped);
    }

    #[test]
    fn damaged_files_are_errors_not_panics(cut in 0usize..400, at in 0usize..400, value: u8) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        let mut writer = WavWriter::create(&path, spec(SampleFormat::Pcm24, 2, 20.0)).unwrap();
        writer.write(&[1.0; 40]).unwrap();
        writer.finish().unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let length = bytes.len();
        bytes[at % length] = value;
        std::fs::write(&path, &bytes[..cut.min(length)]).unwrap();
        let read = read_all(&path);
        // A smaller size of the samples, in the four bytes before them, may be what is left.
        let samples = length - 2 * 20 * 3;
        let at = at % length;
        if cut < length && at >= 60 && !(samples - 4..samples).contains(&at) {
            prop_assert!(read.is_err());
        }
    }

    #[test]
    fn noise_is_no_wav(mut bytes in prop::collection::vec(any::<u8>(), 0..300), disguise: bool) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        if disguise && bytes.len() >= 24 {
            bytes[..4].copy_from_slice(b"RIFF");
            bytes[8..16].copy_from_slice(b"WAVEfmt ");
            bytes[16..20].copy_from_slice(&16u32.to_le_bytes());
        }
        std::fs::write(&path, &bytes).unwrap();
        let _ = read_all(&path);
    }
}

#[test]
fn nan_is_refused_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    for bad in [f32::NAN, f32::INFINITY] {
        let mut writer = WavWriter::create(&path, spec(SampleFormat::Float32, 2, 1.0)).unwrap();
        writer.write(&[0.0; 10]).unwrap();
        let error = writer.write(&[0.0, 0.0, 0.0, bad]).unwrap_err();
        assert_eq!(error.to_string(), "sample 6 of channel 1 is not finite");
        drop(writer);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    // Finite pressure, but not once divided by full scale.
    let mut writer = WavWriter::create(&path, spec(SampleFormat::Float32, 1, 1e-30)).unwrap();
    assert!(matches!(writer.write(&[1e20]), Err(WavError::NotFinite { frame: 0, channel: 0 })));
}

#[test]
fn impossible_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    let good = spec(SampleFormat::Pcm24, 2, 20.0);
    for rate in [0, 7_999, 384_001] {
        let wrong = WavSpec { sample_rate: rate, ..good.clone() };
        assert!(matches!(WavWriter::create(&path, wrong), Err(WavError::SampleRate { .. })));
    }
    for channels in [0, 60_000] {
        let wrong = WavSpec { channels, ..good.clone() };
        assert!(matches!(WavWriter::create(&path, wrong), Err(WavError::Channels { .. })));
    }
    for full_scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let wrong = WavSpec { full_scale, ..good.clone() };
        assert!(matches!(WavWriter::create(&path, wrong), Err(WavError::FullScale { .. })));
    }
    let mut writer = WavWriter::create(&path, good).unwrap();
    assert!(matches!(writer.write(&[0.0; 3]), Err(WavError::PartialFrame { .. })));
    drop(writer);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn comment_tells_what_a_sample_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    for (meaning, full_scale) in [(Meaning::Pressure, Some(0.1)), (Meaning::Processed, None)] {
        let note = "ball-drop, listener 1".into();
        let written = WavSpec { meaning, note, ..spec(SampleFormat::Float32, 2, 0.1) };
        WavWriter::create(&path, written.clone()).unwrap().finish().unwrap();
        let info = WavReader::open(&path).unwrap().info().clone();
        assert_eq!(info.comment.as_deref(), Some(written.comment().as_str()));
        assert_eq!(info.full_scale, full_scale);
        assert!(info.comment.unwrap().contains("0.1 Pa; ball-drop, listener 1"));
    }
}
