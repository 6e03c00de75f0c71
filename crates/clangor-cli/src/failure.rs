//! Why a command ended without its result.

use std::fmt::Display;
use std::path::Path;

use clangor_core::scene::diagnostic::{Place, SceneErrors};
use clangor_pipeline::dataset::DatasetError;
use clangor_pipeline::interchange::body_files::InterchangeError;
use clangor_pipeline::session;
use clangor_pipeline::stages::load::LoadError;
use clangor_pipeline::stages::render::RenderError;
use clangor_pipeline::stages::simulate::SimulateError;
use clangor_pipeline::stages::sound_models::{ModelOptionsError, SoundModelError};
#[cfg(feature = "playback")]
use clangor_playback::PlaybackError;

use serde_json::{Value, json};

use crate::diagnostics::{draw_error, draw_errors, error_json, errors_json};

/// The end of a command that has no result.
pub(crate) enum Failure {
    /// Something is wrong; the text says what, where, and what to do.
    Error(String),
    /// The same, drawn at its place in a scene: free of what a terminal would obey, but for colours; and the
    /// list of errors for programs.
    Drawn { text: String, errors: Value },
    /// The person pressed Ctrl-C.
    Interrupted,
    /// The same; the text says what was kept.
    InterruptedWith(String),
}

impl Failure {
    /// A failure that is told in one line.
    pub(crate) fn new(error: impl Display) -> Self {
        Failure::Error(format!("error: {error}"))
    }

    /// The errors of a scene at `path` with this `text`.
    fn in_scene(path: &Path, text: &str, errors: &SceneErrors) -> Self {
        Failure::Drawn { text: draw_errors(path, text, errors), errors: errors_json(errors) }
    }

    /// What `--json` prints; nothing for an interruption.
    pub(crate) fn json(&self) -> Option<Value> {
        match self {
            Failure::Error(text) => {
                let problem = text.strip_prefix("error: ").unwrap_or(text).trim_end();
                Some(json!({ "errors": [error_json(&Place::default(), problem, None)] }))
            }
            Failure::Drawn { errors, .. } => Some(json!({ "errors": errors })),
            Failure::Interrupted | Failure::InterruptedWith(_) => None,
        }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        match error {
            LoadError::Scene { path, text, errors } => Failure::in_scene(&path, &text, &errors),
            other => Failure::new(other),
        }
    }
}

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Self {
        match error {
            SimulateError::Kept { .. } | SimulateError::Lost { .. } if error.is_interruption() => {
                Failure::InterruptedWith(error.to_string())
            }
            _ if error.is_interruption() => Failure::Interrupted,
            SimulateError::Start { path, text, place, source } => {
                let problem = source.to_string();
                let errors = json!([error_json(&place, &problem, None)]);
                Failure::Drawn { text: draw_error(&path, &text, &place, &problem, None), errors }
            }
            _ => Failure::new(error),
        }
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        if matches!(error, RenderError::Interrupted) { Failure::Interrupted } else { Failure::new(error) }
    }
}

impl From<InterchangeError> for Failure {
    fn from(error: InterchangeError) -> Self {
        if error.is_interruption() { Failure::Interrupted } else { Failure::new(error) }
    }
}

impl From<SoundModelError> for Failure {
    fn from(error: SoundModelError) -> Self {
        if matches!(error, SoundModelError::Interrupted) { Failure::Interrupted } else { Failure::new(error) }
    }
}

impl From<ModelOptionsError> for Failure {
    fn from(error: ModelOptionsError) -> Self {
        match error {
            ModelOptionsError::Accuracy { accuracy, least, most } => {
                Failure::new(format_args!("--accuracy {accuracy} is outside {least} to {most}"))
            }
            ModelOptionsError::MaxFrequency { hz, lowest, nyquist } => Failure::new(format_args!(
                "--max-frequency {hz} is outside {lowest} Hz to half the sample rate, {nyquist} Hz"
            )),
        }
    }
}

#[cfg(feature = "playback")]
impl From<PlaybackError> for Failure {
    fn from(error: PlaybackError) -> Self {
        match error {
            PlaybackError::NoDevice | PlaybackError::Unusable { .. } => {
                Failure::new(format_args!("{error}; `clangor render` writes the sound to a file instead"))
            }
            PlaybackError::UnknownDevice { .. } => {
                Failure::new(format_args!("{error}; --devices lists them"))
            }
            PlaybackError::Session(error) => error.into(),
            PlaybackError::Stopped => Failure::InterruptedWith(error.to_string()),
            other => Failure::new(other),
        }
    }
}

impl From<DatasetError> for Failure {
    fn from(error: DatasetError) -> Self {
        match error {
            DatasetError::Recipe { path: Some(path), text, errors } => {
                Failure::in_scene(&path, &text, &errors)
            }
            DatasetError::Options(error) => error.into(),
            error if error.is_interruption() => Failure::InterruptedWith(error.to_string()),
            other => Failure::new(other),
        }
    }
}

impl From<session::Error> for Failure {
    fn from(error: session::Error) -> Self {
        match error {
            session::Error::Load(error) => error.into(),
            session::Error::Simulate(error) => error.into(),
            session::Error::Render(error) => error.into(),
            session::Error::Models(error) => error.into(),
            session::Error::ModelOptions(error) => error.into(),
            session::Error::NoMaterial { name } => {
                Failure::new(format_args!("what is \"{name}\" made of? add --material NAME"))
            }
            session::Error::ModalMaterial => {
                Failure::new("ringing depends on the material: add --material NAME")
            }
            session::Error::NoCache => {
                Failure::new("this system has no folder for caches; name one with --cache DIR")
            }
            session::Error::Interrupted => Failure::Interrupted,
            other => Failure::new(other),
        }
    }
}
