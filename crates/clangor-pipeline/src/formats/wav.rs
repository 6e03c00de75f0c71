//! Sound pressure in WAV files: 32-bit float or 24-bit PCM, RF64 past 4 GB, streamed both ways.
//!
//! A sample is pressure / full scale. The header's comment (`LIST INFO ICMT`) says what full scale is, so
//! that a file can be turned back into pascals. Not a general audio library: no compressed formats, no
//! resampling, no dither (24-bit rounding noise lies 149 dB under full scale: −29 dB SPL at the default of 20
//! Pa).
//!
//! * [`WavWriter`] writes one file atomically, a block at a time.
//! * [`WavReader`] reads ours and most others' PCM and float files.

mod reader;
mod writer;

pub use reader::{WavEncoding, WavInfo, WavReader};
pub use writer::{WavSummary, WavWriter};

use std::io;
use std::path::PathBuf;

use crate::formats::atomic_file::OutputError;

/// Sample rates that can be written \[Hz\].
pub const SAMPLE_RATES: std::ops::RangeInclusive<u32> = 8_000..=384_000;

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SampleFormat {
    /// IEEE float, 32 bits.
    #[default]
    Float32,
    /// Signed integer, 24 bits, rounded to nearest.
    Pcm24,
}

impl SampleFormat {
    /// Bytes of a sample.
    pub fn bytes(self) -> usize {
        match self {
            SampleFormat::Float32 => 4,
            SampleFormat::Pcm24 => 3,
        }
    }
}

/// What the samples are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Meaning {
    /// Sound pressure: sample × full scale is in pascals.
    #[default]
    Pressure,
    /// Sound pressure that has been through a compressor or limiter: levels no longer mean anything physical.
    Processed,
}

/// A WAV file to write.
#[derive(Clone, Debug, PartialEq)]
pub struct WavSpec {
    /// Sample rate \[Hz\], within [`SAMPLE_RATES`].
    pub sample_rate: u32,
    /// Channels: one per receiver.
    pub channels: u16,
    /// How samples are stored.
    pub format: SampleFormat,
    /// Pressure of a sample of 1.0 \[Pa\].
    pub full_scale: f64,
    /// What the samples are.
    pub meaning: Meaning,
    /// More for the comment: the scene, the listener.
    pub note: String,
}

impl WavSpec {
    /// Full scale where none is chosen \[Pa\]: samples of a float file are pascals; 20 Pa (120 dB SPL) fits
    /// PCM.
    pub fn default_full_scale(format: SampleFormat) -> f64 {
        match format {
            SampleFormat::Float32 => 1.0,
            SampleFormat::Pcm24 => 20.0,
        }
    }

    /// The comment written into the header.
    pub fn comment(&self) -> String {
        let meaning = match self.meaning {
            Meaning::Pressure => COMMENT_PRESSURE,
            Meaning::Processed => COMMENT_PROCESSED,
        };
        let note = self.note.replace('\0', " ");
        let separator = if note.is_empty() { "" } else { "; " };
        format!("{meaning}{} Pa{separator}{note}", self.full_scale)
    }
}

const COMMENT_PRESSURE: &str = "sound pressure, a sample of 1.0 is ";
const COMMENT_PROCESSED: &str =
    "dynamics were compressed, no longer sound pressure; before, a sample of 1.0 was ";

/// Full scale \[Pa\] from a comment that [`WavSpec::comment`] wrote; `None` for foreign and for processed
/// files.
fn full_scale_in(comment: &str) -> Option<f64> {
    let number = comment.strip_prefix(COMMENT_PRESSURE)?.split(" Pa").next()?;
    number.parse().ok().filter(|f: &f64| f.is_finite() && *f > 0.0)
}

/// Why a WAV file could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum WavError {
    /// The rate is outside [`SAMPLE_RATES`].
    #[error("a sample rate of {rate} Hz cannot be written; choose 8000 to 384000 Hz")]
    SampleRate {
        /// The rate \[Hz\].
        rate: u32,
    },
    /// No channel, or more than a frame can hold.
    #[error("{channels} channels cannot be written; choose 1 to {most}")]
    Channels {
        /// The number asked for.
        channels: u16,
        /// The most that fit.
        most: u16,
    },
    /// Full scale must be a positive number.
    #[error("full scale must be a positive pressure, not {full_scale} Pa")]
    FullScale {
        /// The pressure \[Pa\].
        full_scale: f64,
    },
    /// A block that does not hold whole frames.
    #[error("{samples} samples are no whole number of frames of {channels} channels")]
    PartialFrame {
        /// Samples in the block.
        samples: usize,
        /// Channels of the file.
        channels: u16,
    },
    /// A sample is NaN or infinite.
    #[error("sample {frame} of channel {channel} is not finite")]
    NotFinite {
        /// Index of the frame in the file.
        frame: u64,
        /// Channel, from 0.
        channel: usize,
    },
    /// The file could not be put in place.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The operating system refused.
    #[error("cannot {action} {path}: {source}")]
    Io {
        /// What was attempted.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The bytes are not a WAV file that can be read.
    #[error("{path} is not a readable WAV file: at byte {at}, {reason}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where \[bytes\].
        at: u64,
        /// What is wrong.
        reason: &'static str,
    },
    /// The file is shorter than its header says.
    #[error("{path} is truncated: its header promises {promised} bytes of samples, {present} are there")]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Bytes that the header promises.
        promised: u64,
        /// Bytes that follow.
        present: u64,
    },
    /// A way of storing samples that is not read.
    #[error(
        "{path} stores samples as format {tag:#06x} with {bits} bits; convert it to PCM of 16, 24 or 32 \
         bits or to float"
    )]
    Encoding {
        /// The file.
        path: PathBuf,
        /// Format tag.
        tag: u16,
        /// Bits of a sample.
        bits: u16,
    },
}
