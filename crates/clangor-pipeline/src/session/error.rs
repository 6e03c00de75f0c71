//! Why a session gave no sound.

use std::path::PathBuf;

use clangor_bake::reference::PanModelError;
use clangor_core::geometry::solid::MeshError;
use clangor_core::scene::diagnostic::SceneErrors;
use clangor_core::scene::instantiate::GeometryError;
use clangor_core::sound_model::acceleration::field_evaluator::FieldError;
use clangor_core::sound_model::files::tensor_file::TensorFileError;
use clangor_core::synthesis::SynthesisError;
use clangor_core::synthesis::modal::ModalError;
use clangor_core::synthesis::strike::StrikeError;

use super::compare_error::CompareError;
use crate::formats::atomic_file::OutputError;
use crate::formats::timeline_file::TimelineError;
use crate::formats::wav::WavError;
use crate::formats::web_replay::ReplayError;
use crate::interchange::audio_rigid_bodies::{AudioFileError, AudioUseError};
use crate::stages::load::LoadError;
use crate::stages::render::RenderError;
use crate::stages::simulate::SimulateError;
use crate::stages::sound_models::{ModelOptionsError, RequestError, SoundFileError, SoundModelError};

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
    /// Options that no model can be baked with.
    #[error(transparent)]
    ModelOptions(#[from] ModelOptionsError),
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
    /// A striker together with an impulse or a duration.
    #[error("impulse and duration follow from the striker: give either a striker or an impulse")]
    TwoForces,
    /// The modes cannot be played.
    #[error("the modes of \"{name}\" cannot be played: {source}")]
    Modes {
        /// The body.
        name: String,
        /// Why.
        source: ModalError,
    },
    /// A body without a material.
    #[error("what is \"{name}\" made of? give a material")]
    NoMaterial {
        /// The body.
        name: String,
    },
    /// The file of a sound model cannot be read.
    #[error(transparent)]
    SoundFile(#[from] SoundFileError),
    /// A soundbank in the place of a sound model.
    #[error("{} is a soundbank, not the model of one body", path.display())]
    Soundbank {
        /// The file.
        path: PathBuf,
    },
    /// The mesh in a sound model bounds no solid.
    #[error("{name}: {source}")]
    ModelSurface {
        /// The file.
        name: String,
        /// Why.
        source: MeshError,
    },
    /// The acceleration field in a sound model contradicts itself.
    #[error("{name}: {source}")]
    ModelField {
        /// The file.
        name: String,
        /// Why.
        source: FieldError,
    },
    /// A glTF file with the sound of its bodies cannot be read.
    #[error(transparent)]
    AudioFile(#[from] AudioFileError),
    /// No such body, or several, in a glTF file.
    #[error(transparent)]
    AudioBody(#[from] AudioUseError),
    /// The material of a body in a glTF file is unknown.
    #[error("\"{name}\" cannot be used: {source}")]
    AudioMaterial {
        /// The body.
        name: String,
        /// Why.
        source: AudioUseError,
    },
    /// A shape or mesh file cannot be baked.
    #[error("\"{name}\" cannot be baked: {source}")]
    BakeGeometry {
        /// The shape or file.
        name: String,
        /// Why.
        source: GeometryError,
    },
    /// A solid that has no sound model.
    #[error("\"{name}\" cannot be baked: {source}")]
    Unbakeable {
        /// The solid.
        name: String,
        /// Why.
        source: RequestError,
    },
    /// The modal part of a solid without material.
    #[error("ringing depends on the material: give one")]
    ModalMaterial,
    /// Neither the acceleration part nor the modal part is to be baked.
    #[error("a sound model without parts is nothing to bake")]
    NoParts,
    /// The system has no folder for caches.
    #[error("this system has no folder for caches; name one")]
    NoCache,
    /// A sound model cannot be stored.
    #[error(transparent)]
    Encode(#[from] TensorFileError),
    /// A sound model cannot be represented as in \[PAN\].
    #[error(transparent)]
    Pan(#[from] PanModelError),
    /// The ending of a file to write names no format.
    #[error("the output must end in .wav or .csv")]
    OutputEnding,
    /// The WAV file cannot be written.
    #[error(transparent)]
    Wav(#[from] WavError),
    /// The file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A recording cannot be compared with a model.
    #[error(transparent)]
    Compare(#[from] CompareError),
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
            Error::Interrupted => true,
            _ => false,
        }
    }
}
