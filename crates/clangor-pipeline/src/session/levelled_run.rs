//! The step of a session that hands the run over in the real-time engine, with a level for playback.

use clangor_core::synthesis::SampleRate;

use super::Session;
use super::error::Error;
use super::progress::{Progress, Stage};
use crate::stages::event_schedule::scheduled_engine::ScheduledEngine;

/// A run in the real-time engine, for an audio device or any other reader of its samples.
pub struct LevelledRun {
    /// The engine, and the events that are to be sent to it.
    pub run: ScheduledEngine,
    /// Pressure of a full-scale sample \[Pa\].
    pub full_scale: f64,
    /// Start and end of the part that is heard, in the time of the run \[s\].
    pub window: (f64, f64),
}

impl Session<'_> {
    /// The run as the real-time engine plays it to the first listener at a sample rate \[Hz\]. Simulates and
    /// obtains models first. Without a full scale \[Pa\] it is twice the peak of the run, which is rendered
    /// once for it.
    ///
    /// # Errors
    /// [`Error::Render`] for a run that the engine cannot play; those of
    /// [`obtain_models`](Self::obtain_models).
    pub fn levelled_run(&mut self, sample_rate: u32, full_scale: Option<f64>) -> Result<LevelledRun, Error> {
        let rate = SampleRate::try_new(sample_rate)?;
        self.obtain_models()?;
        let (Some(motion), Some(models)) = (&self.motion, &self.models) else {
            return Err(Error::Interrupted);
        };
        let (bodies, how) = (&self.source.bodies, &self.options);
        let mut run = ScheduledEngine::new(bodies, &models.bodies, &motion.timeline, how, rate)?;
        let window = (how.synthesis.start, how.to);
        let on_progress = &mut self.on_progress;
        let full_scale = match full_scale {
            Some(pressure) => pressure,
            None => run.full_scale(window, &mut |time| {
                on_progress(&Progress::of_time(Stage::Level, "measure_peak", (time, how.to)))
            })?,
        };
        Ok(LevelledRun { run, full_scale, window })
    }
}
