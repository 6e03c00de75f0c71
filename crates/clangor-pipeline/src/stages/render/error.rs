//! Why nothing was rendered.

use std::path::PathBuf;

use clangor_core::contact::ContactError;
use clangor_core::propagation::RoomError;
use clangor_core::synthesis::SynthesisError;
use clangor_core::synthesis::ground::GroundError;

use super::modal_sources::UnplayableModes;
use crate::formats::wav::WavError;

/// Why nothing was rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The contacts cannot be turned into forces.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The sound cannot be synthesised.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    /// A plane cannot sound.
    #[error("{0}; change the material, or use ground = \"none\"")]
    Ground(#[from] GroundError),
    /// The room cannot reflect.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// Modes cannot be played.
    #[error(transparent)]
    Modes(#[from] UnplayableModes),
    /// A file cannot be written.
    #[error(transparent)]
    Wav(#[from] WavError),
    /// No listener.
    #[error("there is no listener; add a [[listener]] to the scene, or use --listener X,Y,Z")]
    NoListener,
    /// Nothing between start and end.
    #[error("the sound would end at {to} s, not after its start at {from} s")]
    NothingToWrite {
        /// Start \[s\].
        from: f64,
        /// End \[s\].
        to: f64,
    },
    /// Two sounds of the same file name.
    #[error("{first} and {second} would both be written to {path}; rename one")]
    SameFile {
        /// What would be written first.
        first: String,
        /// What would replace it.
        second: String,
        /// Where.
        path: PathBuf,
    },
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}
