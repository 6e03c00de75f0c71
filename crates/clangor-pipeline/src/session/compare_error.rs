//! Reasons why a recording cannot be compared with a model.

use std::path::PathBuf;

use crate::analysis::decaying_tones::ToneError;
use crate::formats::wav::WavError;

/// Why a recording cannot be compared with a model.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The recording cannot be read.
    #[error(transparent)]
    Wav(#[from] WavError),
    /// A recording of several channels, none of which is chosen.
    #[error("{} has {count} channels; choose one of them, from 1 to {count}", path.display())]
    Channels {
        /// The file.
        path: PathBuf,
        /// Its channels.
        count: u16,
    },
    /// A channel that the recording lacks.
    #[error("{} has no channel {channel}; it has {count}, from 1 on", path.display())]
    Channel {
        /// The file.
        path: PathBuf,
        /// The channel that was asked for.
        channel: u16,
        /// Its channels.
        count: u16,
    },
    /// The recording has no decaying tones.
    #[error("{}: {source}", path.display())]
    Tones {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ToneError,
    },
    /// A sound model without modes.
    #[error("{} has no modal part; bake one, or name a shape or a mesh", path.display())]
    NoModalPart {
        /// The file.
        path: PathBuf,
    },
    /// The model has no modes in the band.
    #[error("\"{name}\" has no modes below {max_frequency:.0} Hz; raise the highest frequency")]
    NoModes {
        /// The model.
        name: String,
        /// Highest frequency \[Hz\].
        max_frequency: f64,
    },
}
