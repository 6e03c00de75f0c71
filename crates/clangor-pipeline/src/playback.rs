//! Playback of a run on an audio device, by the real-time engine.
//!
//! ```text
//! events of the run ─► EventFeeder ─► Controller ─► Engine (audio thread) ─► device
//! ```
//!
//! The events are sent ahead of their time, by
//! [`AHEAD`](crate::stages::event_schedule::event_feeder::AHEAD); the engine renders them in the callback of
//! the device. A sample of the device is the pressure at a receiver over the full scale \[Pa\].
//!
//! Differs from offline rendering by what [`event_schedule`](crate::stages::event_schedule) leaves out, and
//! by what the engine leaves out for lack of time, which [`PlaybackReport`] counts.
//!
//! [`Session::play`](crate::session::Session::play) runs all steps from a scene to the device.

mod device;
mod error;
mod prepared;
mod report;

pub use self::device::{DeviceName, PlaybackDevice, devices};
pub use self::error::PlaybackError;
pub use self::prepared::PreparedPlayback;
pub use self::report::PlaybackReport;

/// Where and how loudly a run is played.
#[derive(Default)]
pub struct PlaybackOptions {
    /// The device. Default: that of the system.
    pub device: Option<PlaybackDevice>,
    /// Pressure of a full-scale sample \[Pa\], above 0. Default: twice the peak of the run, which is rendered
    /// once for it.
    pub full_scale: Option<f64>,
}
