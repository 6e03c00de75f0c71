//! The writing half: a header with room for RF64, samples a block at a time, sizes patched in at the end.
//!
//! Layout: `RIFF size WAVE`, `JUNK` (28 bytes, becomes `ds64` where a size outgrows 32 bits, as in EBU Tech
//! 3306), `fmt `, `fact` (frames, for float), `LIST INFO`, `data`.

use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use super::{SAMPLE_RATES, SampleFormat, WavError, WavSpec};
use crate::formats::atomic_file::AtomicFile;

/// Largest file size less 8 that a RIFF header can say; 0xFFFF_FFFF itself means "see ds64".
const RIFF_LIMIT: u64 = 0xFFFF_FFFE;
/// Tail of the sub-format identifiers of `WAVE_FORMAT_EXTENSIBLE`; the format tag goes before it.
pub(super) const SUBFORMAT_TAIL: [u8; 14] =
    [0x00, 0x00, 0x00, 0x00, 0x10, 0x00, 0x80, 0x00, 0x00, 0xAA, 0x00, 0x38, 0x9B, 0x71];
pub(super) const TAG_PCM: u16 = 1;
pub(super) const TAG_FLOAT: u16 = 3;
pub(super) const TAG_EXTENSIBLE: u16 = 0xFFFE;

/// What a finished file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WavSummary {
    /// Frames (samples of each channel).
    pub frames: u64,
    /// Samples of 24-bit files beyond full scale, written as full scale.
    pub clipped_samples: u64,
}

/// Writes one WAV file; it appears under its name when [`WavWriter::finish`] succeeds, and not at all
/// otherwise.
#[derive(Debug)]
pub struct WavWriter {
    out: BufWriter<AtomicFile>,
    spec: WavSpec,
    bytes: Vec<u8>,
    fact_at: Option<u64>,
    data_at: u64,
    summary: WavSummary,
    riff_limit: u64,
}

impl WavWriter {
    /// Starts a file. An existing one stays until the new one is finished.
    ///
    /// # Errors
    /// [`WavError`] for a rate, channel count or full scale that cannot be written, or a place that cannot.
    pub fn create(path: &Path, spec: WavSpec) -> Result<Self, WavError> {
        Self::create_with_limit(path, spec, RIFF_LIMIT)
    }

    fn create_with_limit(path: &Path, spec: WavSpec, riff_limit: u64) -> Result<Self, WavError> {
        if !SAMPLE_RATES.contains(&spec.sample_rate) {
            return Err(WavError::SampleRate { rate: spec.sample_rate });
        }
        let most = u16::MAX / spec.format.bytes() as u16;
        if spec.channels == 0 || spec.channels > most {
            return Err(WavError::Channels { channels: spec.channels, most });
        }
        if !(spec.full_scale.is_finite() && spec.full_scale > 0.0) {
            return Err(WavError::FullScale { full_scale: spec.full_scale });
        }
        let (header, fact_at) = header(&spec);
        let mut writer = WavWriter {
            out: BufWriter::with_capacity(1 << 16, AtomicFile::create(path)?),
            spec,
            bytes: Vec::new(),
            fact_at,
            data_at: header.len() as u64,
            summary: WavSummary { frames: 0, clipped_samples: 0 },
            riff_limit,
        };
        writer.put(&header)?;
        Ok(writer)
    }

    /// Appends pressures \[Pa\], interleaved: whole frames of one value per channel.
    ///
    /// # Errors
    /// [`WavError::NotFinite`] names the first sample that is NaN or infinite; nothing of the block is
    /// written then.
    pub fn write(&mut self, pressure: &[f32]) -> Result<(), WavError> {
        let channels = self.spec.channels;
        if !pressure.len().is_multiple_of(usize::from(channels)) {
            return Err(WavError::PartialFrame { samples: pressure.len(), channels });
        }
        let scale = 1.0 / self.spec.full_scale;
        let mut bytes = std::mem::take(&mut self.bytes);
        bytes.clear();
        let mut clipped = 0;
        for (i, p) in pressure.iter().enumerate() {
            let sample = f64::from(*p) * scale;
            if !(sample as f32).is_finite() {
                let frame = self.summary.frames + (i / usize::from(channels)) as u64;
                return Err(WavError::NotFinite { frame, channel: i % usize::from(channels) });
            }
            match self.spec.format {
                SampleFormat::Float32 => bytes.extend_from_slice(&(sample as f32).to_le_bytes()),
                SampleFormat::Pcm24 => {
                    let level = (sample * f64::from(1 << 23)).round_ties_even();
                    let kept = level.clamp(f64::from(-(1 << 23)), f64::from((1 << 23) - 1));
                    clipped += u64::from(kept != level);
                    bytes.extend_from_slice(&(kept as i32).to_le_bytes()[..3]);
                }
            }
        }
        self.put(&bytes)?;
        self.bytes = bytes;
        self.summary.frames += (pressure.len() / usize::from(channels)) as u64;
        self.summary.clipped_samples += clipped;
        Ok(())
    }

    /// Completes the header and puts the file in place.
    ///
    /// # Errors
    /// [`WavError`]; no file is left then.
    pub fn finish(mut self) -> Result<WavSummary, WavError> {
        let block = self.spec.format.bytes() as u64 * u64::from(self.spec.channels);
        let data_size = self.summary.frames * block;
        if data_size % 2 == 1 {
            self.put(&[0])?;
        }
        let riff_size = self.data_at + data_size + data_size % 2 - 8;
        let frames = self.summary.frames;
        if riff_size > self.riff_limit {
            self.patch(0, b"RF64\xFF\xFF\xFF\xFF")?;
            let mut ds64 = b"ds64".to_vec();
            ds64.extend_from_slice(&28_u32.to_le_bytes());
            for size in [riff_size, data_size, frames] {
                ds64.extend_from_slice(&size.to_le_bytes());
            }
            ds64.extend_from_slice(&0_u32.to_le_bytes());
            self.patch(12, &ds64)?;
            self.patch(self.data_at - 4, &[0xFF; 4])?;
            if let Some(at) = self.fact_at {
                self.patch(at, &[0xFF; 4])?;
            }
        } else {
            self.patch(4, &(riff_size as u32).to_le_bytes())?;
            self.patch(self.data_at - 4, &(data_size as u32).to_le_bytes())?;
            if let Some(at) = self.fact_at {
                self.patch(at, &(frames as u32).to_le_bytes())?;
            }
        }
        let path = self.out.get_ref().destination().to_path_buf();
        let file = self.out.into_inner().map_err(|e| WavError::Io {
            action: "write",
            path,
            source: e.into_error(),
        })?;
        file.commit()?;
        Ok(self.summary)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), WavError> {
        self.out.write_all(bytes).map_err(|source| self.io_error(source))
    }

    fn patch(&mut self, at: u64, bytes: &[u8]) -> Result<(), WavError> {
        self.out.seek(SeekFrom::Start(at)).map_err(|source| self.io_error(source))?;
        self.put(bytes)
    }

    fn io_error(&self, source: std::io::Error) -> WavError {
        WavError::Io { action: "write", path: self.out.get_ref().destination().into(), source }
    }
}

/// The header up to the first sample, sizes still zero, and where the frame count of `fact` belongs.
fn header(spec: &WavSpec) -> (Vec<u8>, Option<u64>) {
    let bytes = spec.format.bytes() as u32;
    let (tag, has_fact) = match spec.format {
        SampleFormat::Float32 => (TAG_FLOAT, true),
        SampleFormat::Pcm24 => (TAG_PCM, false),
    };
    // Microsoft requires the extensible form above 16 bits of PCM or 2 channels.
    let extensible = spec.format == SampleFormat::Pcm24 || spec.channels > 2;
    let mut out = b"RIFF\0\0\0\0WAVEJUNK".to_vec();
    out.extend_from_slice(&28_u32.to_le_bytes());
    out.extend_from_slice(&[0; 28]);

    let mut fmt = Vec::new();
    let block = spec.channels * bytes as u16;
    fmt.extend_from_slice(&(if extensible { TAG_EXTENSIBLE } else { tag }).to_le_bytes());
    fmt.extend_from_slice(&spec.channels.to_le_bytes());
    fmt.extend_from_slice(&spec.sample_rate.to_le_bytes());
    // A rate that overflows is nominal only: no reader of frames needs it.
    fmt.extend_from_slice(&spec.sample_rate.saturating_mul(u32::from(block)).to_le_bytes());
    fmt.extend_from_slice(&block.to_le_bytes());
    fmt.extend_from_slice(&(8 * bytes as u16).to_le_bytes());
    if extensible {
        fmt.extend_from_slice(&22_u16.to_le_bytes());
        fmt.extend_from_slice(&(8 * bytes as u16).to_le_bytes());
        // Front centre; front left and right; more receivers are no loudspeakers.
        let speakers: u32 = match spec.channels {
            1 => 0x4,
            2 => 0x3,
            _ => 0,
        };
        fmt.extend_from_slice(&speakers.to_le_bytes());
        fmt.extend_from_slice(&tag.to_le_bytes());
        fmt.extend_from_slice(&SUBFORMAT_TAIL);
    } else {
        fmt.extend_from_slice(&0_u16.to_le_bytes());
    }
    push_chunk(&mut out, b"fmt ", &fmt);

    let fact_at = has_fact.then(|| {
        push_chunk(&mut out, b"fact", &[0; 4]);
        out.len() as u64 - 4
    });

    let mut info = b"INFO".to_vec();
    push_chunk(&mut info, b"ICMT", &terminated(&spec.comment()));
    push_chunk(&mut info, b"ISFT", &terminated(concat!("Clangor ", env!("CARGO_PKG_VERSION"))));
    push_chunk(&mut out, b"LIST", &info);
    out.extend_from_slice(b"data\0\0\0\0");
    (out, fact_at)
}

fn push_chunk(out: &mut Vec<u8>, id: &[u8; 4], content: &[u8]) {
    out.extend_from_slice(id);
    out.extend_from_slice(&(content.len() as u32).to_le_bytes());
    out.extend_from_slice(content);
    if content.len() % 2 == 1 {
        out.push(0);
    }
}

fn terminated(text: &str) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.push(0);
    bytes
}

#[cfg(test)]
mod tests {
    use super::super::{Meaning, WavEncoding, WavReader};
    use super::*;

    fn spec(format: SampleFormat, channels: u16) -> WavSpec {
        WavSpec {
            sample_rate: 48_000,
            channels,
            format,
            full_scale: 20.0,
            meaning: Meaning::Pressure,
            note: "a test".into(),
        }
    }

    #[test]
    fn outgrown_header_becomes_rf64() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("long.wav");
        let pressure: Vec<f32> = (0..301).map(|i| i as f32 * 0.05).collect();
        for (format, channels) in [(SampleFormat::Float32, 1), (SampleFormat::Pcm24, 7)] {
            for limit in [10, RIFF_LIMIT] {
                let mut writer = WavWriter::create_with_limit(&path, spec(format, channels), limit).unwrap();
                writer.write(&pressure[..7 * 13]).unwrap();
                writer.write(&pressure[7 * 13..]).unwrap();
                writer.finish().unwrap();
                let bytes = std::fs::read(&path).unwrap();
                assert_eq!(&bytes[..4], if limit == 10 { b"RF64" } else { b"RIFF" });
                assert_eq!(&bytes[12..16], if limit == 10 { b"ds64" } else { b"JUNK" });
                if limit == 10 {
                    assert_eq!(&bytes[4..8], &[0xFF; 4]);
                    let riff_size = u64::from_le_bytes(bytes[20..28].try_into().unwrap());
                    assert_eq!(riff_size, bytes.len() as u64 - 8);
                    let frames = u64::from_le_bytes(bytes[36..44].try_into().unwrap());
                    assert_eq!(frames, 301 / u64::from(channels));
                }
                let mut reader = WavReader::open(&path).unwrap();
                assert_eq!(reader.info().frames, 301 / u64::from(channels));
                let mut back = Vec::new();
                while reader.read(&mut back, 5).unwrap() > 0 {}
                for (p, s) in pressure.iter().zip(&back) {
                    // Half a step of 24 bits at 20 Pa is 1.2e-6 Pa; floats of 15 Pa / 20 round to 9e-7 Pa.
                    assert!((p - s * 20.0).abs() < 2.2e-6, "{p} {s}");
                }
            }
        }
    }

    #[test]
    fn form_of_the_header_follows_the_samples() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        for (format, channels, tag) in [
            (SampleFormat::Float32, 2, TAG_FLOAT),
            (SampleFormat::Float32, 3, TAG_EXTENSIBLE),
            (SampleFormat::Pcm24, 1, TAG_EXTENSIBLE),
        ] {
            WavWriter::create(&path, spec(format, channels)).unwrap().finish().unwrap();
            let bytes = std::fs::read(&path).unwrap();
            assert_eq!(u16::from_le_bytes([bytes[56], bytes[57]]), tag);
            let info = WavReader::open(&path).unwrap().info().clone();
            assert_eq!(info.full_scale, Some(20.0));
            assert_eq!(info.encoding == WavEncoding::Float32, format == SampleFormat::Float32);
        }
    }
}
