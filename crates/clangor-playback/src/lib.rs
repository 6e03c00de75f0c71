//! Playback of a run on an audio device, by the real-time engine.
//!
//! ```text
//! events of the run ─► EventFeeder ─► Controller ─► Engine (audio thread) ─► device
//! ```
//!
//! The events are sent ahead of their time, by [`AHEAD`]; the engine renders them in the callback of the
//! device. A sample of the device is the pressure at a receiver over the full scale \[Pa\].
//!
//! Differs from offline rendering by what [`event_schedule`] leaves out, and by what the engine leaves out
//! for lack of time, which [`PlaybackReport`] counts.
//!
//! [`AHEAD`]: clangor_pipeline::stages::event_schedule::event_feeder::AHEAD
//! [`event_schedule`]: clangor_pipeline::stages::event_schedule
//!
//! [`play`] runs all steps from a scene to the device:
//!
#![cfg_attr(feature = "device", doc = "```no_run")]
#![cfg_attr(not(feature = "device"), doc = "```text")]
//! use clangor_pipeline::session::Session;
//! use clangor_playback::{PlaybackDevice, PlaybackOptions, play};
//!
//! let device = PlaybackDevice::open(None)?;
//! let mut session = Session::builder().sample_rate(device.sample_rate()).open("scenes/ball-drop.toml")?;
//! let full_scale = Some(20.0); // Pa
//! let report = play(&mut session, PlaybackOptions { device: Some(device), full_scale })?;
//! println!("{} impacts, {} of them late", report.impacts, report.late);
//! # Ok::<(), clangor_playback::PlaybackError>(())
//! ```
#![cfg(feature = "device")]

use clangor_pipeline::session::{Progress, Session, Stage};

mod device;
mod error;
mod prepared;
mod report;

pub use device::{DeviceName, PlaybackDevice, devices};
pub use error::PlaybackError;
pub use prepared::PreparedPlayback;
pub use report::PlaybackReport;

/// Where and how loudly a run is played.
#[derive(Default)]
pub struct PlaybackOptions {
    /// The device. Default: that of the system.
    pub device: Option<PlaybackDevice>,
    /// Pressure of a full-scale sample \[Pa\], above 0. Default: twice the peak of the run, which is rendered
    /// once for it.
    pub full_scale: Option<f64>,
}

/// Plays the run of a session to its first listener on an audio device, by the real-time engine; returns at
/// its end. Simulates and obtains models first. The part that is played is that from
/// [`from`](clangor_pipeline::session::SessionBuilder::from) to
/// [`to`](clangor_pipeline::session::SessionBuilder::to) \[s\].
///
/// The engine has the sample rate of the device. The sound models cover the band of the session: give
/// [`sample_rate`](clangor_pipeline::session::SessionBuilder::sample_rate) that of the device where the two
/// differ. The session's progress callback gets the time played, and breaks to stop.
///
/// # Errors
/// [`PlaybackError`]; without a device, before anything is simulated.
pub fn play(session: &mut Session<'_>, options: PlaybackOptions) -> Result<PlaybackReport, PlaybackError> {
    let prepared = PreparedPlayback::new(session, options)?;
    let length = prepared.duration();
    prepared.play(&mut |time| session.report(&Progress::of_time(Stage::Playback, "play", (time, length))))
}
