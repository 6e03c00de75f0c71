//! Why a run was not played to its end.

use clangor_core::realtime::SendError;
use clangor_pipeline::session;

/// Why a run was not played to its end.
#[derive(Debug, thiserror::Error)]
pub enum PlaybackError {
    /// The system does not list its devices.
    #[error("the system tells no audio devices: {why}")]
    NoList {
        /// The system's message.
        why: String,
    },
    /// The system has no output device.
    #[error("there is no audio device to play on")]
    NoDevice,
    /// No output device has this name or identifier.
    #[error("there is no audio device \"{name}\"")]
    UnknownDevice {
        /// The name.
        name: String,
    },
    /// The device has no format of samples that the engine can write.
    #[error("the audio device \"{device}\" cannot be played on: {why}")]
    Unusable {
        /// Name of the device.
        device: String,
        /// The reason.
        why: String,
    },
    /// The device does not start.
    #[error("the audio device \"{device}\" does not play: {why}")]
    NotStarted {
        /// Name of the device.
        device: String,
        /// The system's message.
        why: String,
    },
    /// The device stopped during playback, for example because it was unplugged.
    #[error("the audio device \"{device}\" has stopped: {why}")]
    DeviceStopped {
        /// Name of the device.
        device: String,
        /// The system's message.
        why: String,
    },
    /// The device requested no samples.
    #[error("the audio device \"{device}\" has taken no sound for {seconds} s")]
    Stalled {
        /// Name of the device.
        device: String,
        /// Time without a request \[s\].
        seconds: u64,
    },
    /// A full scale that is not above 0.
    #[error("a full scale of {pressure} Pa is not above 0")]
    FullScale {
        /// The full scale \[Pa\].
        pressure: f64,
    },
    /// The session gave no run that the engine can play.
    #[error(transparent)]
    Session(#[from] session::Error),
    /// The engine has ended.
    #[error(transparent)]
    Engine(#[from] SendError),
    /// The caller stopped playback.
    #[error("stopped")]
    Stopped,
}
