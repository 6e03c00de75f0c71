//! Why a session gave no sound.

use std::path::PathBuf;

use clangor_core::scene::diagnostic::SceneErrors;
use clangor_core::scene::instantiate::GeometryError;
use clangor_core::synthesis::SynthesisError;
use clangor_core::synthesis::modal::ModalError;
use clangor_core::synthesis::strike::StrikeError;

use crate::formats::timeline_file::TimelineError;
use crate::formats::web_replay::ReplayError;
#[cfg(feature = "playback")]
use crate::playback::PlaybackError;
use crate::stages::load::LoadError;
use crate::stages::render::RenderError;
use crate::stages::simulate::SimulateError;
use crate::stages::sound_models::SoundModelError;

/// Why a session gave no sound.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene cannot be used.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The timeline cannot be read.
    #[error(transparent)]
    Timeline(#[from] TimelineError),
    /// The scene inside a timeline has errors.
    #[error("{}: the scene in timeline.json is wrong:\n{errors}", path.display())]
    StoredScene {
        /// The timeline.
        path: PathBuf,
        /// All of them.
        errors: SceneErrors,
    },
    /// A setting of the simulation for a timeline, which is simulated already.
    #[error("{} is simulated already, so {setting} has no meaning", path.display())]
    AlreadySimulated {
        /// The timeline.
        path: PathBuf,
        /// The setting.
        setting: &'static str,
    },
    /// A highest frequency out of range.
    #[error("the highest frequency {hz} Hz is outside {lowest} Hz to half the sample rate, {nyquist} Hz")]
    MaxFrequency {
        /// Asked for \[Hz\].
        hz: f64,
        /// Least \[Hz\].
        lowest: f64,
        /// Half the sample rate \[Hz\].
        nyquist: f64,
    },
    /// Settings that no sound can be synthesised with.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    /// The dynamics failed.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// The sound models cannot be had.
    #[error(transparent)]
    Models(#[from] SoundModelError),
    /// The sound cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A replay for the page of a scene that is not recorded in a timeline folder.
    #[error("a scene has no recorded poses; simulate it into a timeline and open that")]
    NotRecorded,
    /// The replay for the page cannot be written.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// The run was not played to its end.
    #[cfg(feature = "playback")]
    #[error(transparent)]
    Playback(#[from] PlaybackError),
    /// A shape or mesh file cannot be used.
    #[error("\"{name}\" cannot be used: {source}")]
    Geometry {
        /// The shape or file.
        name: String,
        /// Why.
        source: GeometryError,
    },
    /// No preset of this name.
    #[error("there is no material \"{name}\"; known: {known}")]
    Material {
        /// The name.
        name: String,
        /// The names of all presets.
        known: String,
    },
    /// The impact gives no sound.
    #[error(transparent)]
    Strike(#[from] StrikeError),
    /// The modes cannot be played.
    #[error(transparent)]
    Modes(#[from] ModalError),
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Whether the progress callback asked to stop.
    pub fn is_interruption(&self) -> bool {
        match self {
            Error::Simulate(error) => error.is_interruption(),
            Error::Models(error) => matches!(error, SoundModelError::Interrupted),
            Error::Render(error) => matches!(error, RenderError::Interrupted),
            #[cfg(feature = "playback")]
            Error::Playback(error) => matches!(error, PlaybackError::Stopped),
            Error::Interrupted => true,
            _ => false,
        }
    }
}
