//! The step of a session that plays on an audio device.

use clangor_core::synthesis::SampleRate;

use super::Session;
use super::error::Error;
use super::progress::{Progress, Stage};
use crate::playback::{PlaybackDevice, PlaybackOptions, PlaybackReport, PreparedPlayback};
use crate::stages::event_schedule::scheduled_engine::ScheduledEngine;

impl Session<'_> {
    /// Plays the run to its first listener on an audio device, by the real-time engine; returns at its end.
    /// Simulates and obtains models first. The part that is played is that from
    /// [`from`](super::SessionBuilder::from) to [`to`](super::SessionBuilder::to) \[s\].
    ///
    /// The engine has the sample rate of the device. The sound models cover the band of the session: give
    /// [`sample_rate`](super::SessionBuilder::sample_rate) that of the device where the two differ.
    ///
    /// ```no_run
    /// use clangor_pipeline::playback::{PlaybackDevice, PlaybackOptions};
    /// use clangor_pipeline::session::Session;
    ///
    /// let device = PlaybackDevice::open(None)?;
    /// let mut session = Session::builder().sample_rate(device.sample_rate()).open("scenes/ball-drop.toml")?;
    /// let full_scale = Some(20.0); // Pa
    /// let report = session.play(PlaybackOptions { device: Some(device), full_scale })?;
    /// println!("{} impacts, {} of them late", report.impacts, report.late);
    /// # Ok::<(), clangor_pipeline::session::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Playback`] for the device, without one before anything is simulated, and once the progress
    /// callback breaks during playback; [`Error::Render`] for a run that the engine cannot play; those of
    /// [`obtain_models`](Self::obtain_models).
    pub fn play(&mut self, options: PlaybackOptions) -> Result<PlaybackReport, Error> {
        let prepared = self.prepare_playback(options)?;
        let length = prepared.duration();
        let on_progress = &mut self.on_progress;
        let mut reached =
            |time: f64| on_progress(&Progress::of_time(Stage::Playback, "play", (time, length)));
        Ok(prepared.play(&mut reached)?)
    }

    /// The steps of [`play`](Self::play) up to the moment before the first sample: for a caller that reports
    /// the device and the full scale first.
    ///
    /// # Errors
    /// As [`play`](Self::play).
    pub fn prepare_playback(&mut self, options: PlaybackOptions) -> Result<PreparedPlayback, Error> {
        let device = match options.device {
            Some(device) => device,
            None => PlaybackDevice::open(None)?,
        };
        let rate = SampleRate::try_new(device.sample_rate())?;
        self.obtain_models()?;
        let (Some(motion), Some(models)) = (&self.motion, &self.models) else {
            return Err(Error::Interrupted);
        };
        let (bodies, how) = (&self.source.bodies, &self.options);
        let mut run = ScheduledEngine::new(bodies, &models.bodies, &motion.timeline, how, rate)?;
        let (from, to) = (how.synthesis.start, how.to);
        let on_progress = &mut self.on_progress;
        let full_scale = match options.full_scale {
            Some(pressure) => pressure,
            None => run.full_scale((from, to), &mut |time| {
                on_progress(&Progress::of_time(Stage::Level, "measure_peak", (time, to)))
            })?,
        };
        Ok(PreparedPlayback::new(run, device, full_scale, (from, to))?)
    }
}
