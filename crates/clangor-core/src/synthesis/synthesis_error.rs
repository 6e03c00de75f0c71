//! Errors in sound synthesis.

use crate::body::BodyId;
use crate::propagation::PlanesError;
use crate::propagation::room::RoomError;
use crate::reference::PanError;

/// Lowest sample rate \[Hz\].
pub(super) const LOWEST_RATE_HZ: u32 = 8_000;
/// Highest sample rate \[Hz\].
pub(super) const HIGHEST_RATE_HZ: u32 = 384_000;

/// Error in sound synthesis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SynthesisError {
    /// A sample rate outside the range that is supported.
    #[error(
        "a sample rate of {hz} Hz is outside {min} to {max} Hz",
        min = LOWEST_RATE_HZ,
        max = HIGHEST_RATE_HZ
    )]
    SampleRate {
        /// The rate asked for \[Hz\].
        hz: u32,
    },
    /// A band limit that is not positive.
    #[error("a highest frequency of {hz} Hz leaves nothing to hear")]
    MaxFrequency {
        /// The frequency asked for \[Hz\].
        hz: f64,
    },
    /// A listener without receivers.
    #[error("listener \"{listener}\" has no receivers")]
    NoReceivers {
        /// The listener.
        listener: String,
    },
    /// A listener below the rigid floor.
    #[error(
        "listener \"{listener}\" is at y = {y} m at t = {time} s, below the rigid floor at y = {floor} m; \
         move it up or use floor = \"none\""
    )]
    BelowFloor {
        /// The listener.
        listener: String,
        /// Height of the receiver \[m\].
        y: f64,
        /// Height of the floor \[m\].
        floor: f64,
        /// Time \[s\].
        time: f64,
    },
    /// A number that is not finite, or not positive where it must be.
    #[error("{what} of the click of body {body} at t = {time} s is {value}", body = body.0)]
    BadPulse {
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The body.
        body: BodyId,
        /// Time \[s\].
        time: f64,
    },
    /// The medium cannot carry sound.
    #[error("a medium of density {density} kg/m³ and speed of sound {sound_speed} m/s carries no sound")]
    BadMedium {
        /// Density [kg/m³].
        density: f64,
        /// Speed of sound [m/s].
        sound_speed: f64,
    },
    /// A click pushed after the time for which its block was handed out.
    #[error("the click of body {body} at t = {time} s comes after its block was rendered", body = body.0)]
    Late {
        /// The body.
        body: BodyId,
        /// Time \[s\].
        time: f64,
    },
    /// An invalid room.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// Reflecting planes that cannot be rendered.
    #[error(transparent)]
    Planes(#[from] PlanesError),
    /// A click that a paper's representation cannot render.
    #[error(transparent)]
    Reference(#[from] PanError),
    /// A click too long for the longest block.
    #[error(
        "the click of body {body} at t = {time} s lasts {seconds:.3e} s (radius {radius} m), longer than the \
         renderer's longest block; are the body's size in metres and its contact in seconds?",
        body = body.0
    )]
    TooLong {
        /// The body.
        body: BodyId,
        /// Time \[s\].
        time: f64,
        /// Duration \[s\].
        seconds: f64,
        /// Radius of its sphere \[m\].
        radius: f64,
    },
}
