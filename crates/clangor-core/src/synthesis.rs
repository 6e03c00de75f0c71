//! From impacts to sound pressure at listeners, offline and exact below the band limit.
//!
//! Every accelerated body is a [`AccelerationPulse`]. A click's spectrum at a receiver is known in closed
//! form: the force profile times the transfer of what sounds times a delay. It is band-limited by
//! [`lowpass`], added to the spectrum of its time block, and one inverse FFT per block gives the samples,
//! which overlap-add to the signal:
//!
//! ```text
//! clicks ─► Renderer::push ─► Renderer::take_ready ─► BlockJob::render ─► OverlapAdd::add ─► samples \[Pa\]
//!           delays, blocks     whole spans of time    pure: any thread    in order
//! ```
//!
//! Nothing is sampled before it is band-limited, so there is no aliasing, and an onset between two samples is
//! as exact as one on a sample. Blocks depend on nothing but their clicks and are added in a fixed order: the
//! samples have the same bits for any number of threads and any segmentation in time.
//!
//! What sounds is the [`source`] of a body: its own field, that of an ellipsoid, a sphere, or a published
//! model. The listener and the body stand still during a click, at the places where they are when it is heard
//! and made.

pub mod acceleration_pulse;
mod field_interpolation;
mod field_spectrum;
pub mod ground;
pub mod listener;
pub mod live_pulses;
pub mod lowpass;
pub mod modal;
pub mod overlap_add;
pub mod propagation_paths;
mod received_wave;
pub mod render_settings;
pub mod renderer;
pub mod source;
pub mod source_rule;
pub(crate) mod spectrum;
pub mod strike;

pub use crate::reference::pan_sound::PanSource;
pub use acceleration_pulse::{AccelerationPulse, clicks_of};
pub use listener::Listener;
pub use overlap_add::OverlapAdd;
pub use render_settings::RenderSettings;
pub use renderer::{BlockJob, BlockMemory, RenderReport, RenderedBlock, Renderer};
pub use source::{FieldSource, SoundSource};
pub use source_rule::SoundRule;

use crate::body::BodyId;
use crate::propagation::room::RoomError;
use crate::reference::pan_representation::PanError;

/// Why sound cannot be synthesised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SynthesisError {
    /// A sample rate outside the range that is supported.
    #[error("a sample rate of {hz} Hz is outside {min} to {max} Hz", min = SampleRate::MIN_HZ, max = SampleRate::MAX_HZ)]
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
        /// When \[s\].
        time: f64,
    },
    /// A number that is not finite, or not positive where it must be.
    #[error("{what} of the click of body {body} at t = {time} s is {value}", body = body.0)]
    BadPulse {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The body that clicks.
        body: BodyId,
        /// When \[s\].
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
        /// The body that clicks.
        body: BodyId,
        /// When \[s\].
        time: f64,
    },
    /// A room that is none.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// A click that the published representation cannot play.
    #[error(transparent)]
    Pan(#[from] PanError),
    /// A click too long for the longest block.
    #[error(
        "the click of body {body} at t = {time} s lasts {seconds:.3e} s (radius {radius} m), longer than the \
         renderer's longest block; are the body's size in metres and its contact in seconds?",
        body = body.0
    )]
    TooLong {
        /// The body that clicks.
        body: BodyId,
        /// When \[s\].
        time: f64,
        /// How long \[s\].
        seconds: f64,
        /// Radius of its sphere \[m\].
        radius: f64,
    },
}

/// Samples per second, 8 to 384 kHz.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SampleRate(u32);

impl SampleRate {
    /// Lowest rate \[Hz\].
    pub const MIN_HZ: u32 = 8_000;
    /// Highest rate \[Hz\].
    pub const MAX_HZ: u32 = 384_000;
    /// 48 kHz.
    pub const HZ_48000: SampleRate = SampleRate(48_000);

    /// A rate in hertz.
    ///
    /// # Errors
    /// [`SynthesisError::SampleRate`] outside 8 to 384 kHz.
    pub fn try_new(hz: u32) -> Result<Self, SynthesisError> {
        let supported = (Self::MIN_HZ..=Self::MAX_HZ).contains(&hz);
        supported.then_some(SampleRate(hz)).ok_or(SynthesisError::SampleRate { hz })
    }

    /// The rate \[Hz\].
    pub fn hz(self) -> u32 {
        self.0
    }

    /// The rate \[Hz\] as a real number.
    pub fn as_f64(self) -> f64 {
        f64::from(self.0)
    }
}

impl Default for SampleRate {
    fn default() -> Self {
        SampleRate::HZ_48000
    }
}
