//! The step of a session that writes a recorded run for the page.

use std::ops::ControlFlow;
use std::path::Path;

use clangor_core::body::Body;
use clangor_core::sound_model::acceleration::model::AccelerationModel;

use super::Session;
use super::error::Error;
use super::progress::{Progress, Stage};
use super::source::Motion;
use crate::formats::soundbank::default_bank;
use crate::formats::web_replay::{Replay, ReplaySummary, write_replay};
use crate::stages::event_schedule::scheduled_engine::ScheduledEngine;
use crate::stages::sound_models::{AccelerationBake, SoundModelRequest, obtain};

/// A scene of nothing: still air, no room.
const EMPTY_SCENE: &str = "version = 1\n";

/// A run written for the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportedReplay {
    /// Pressure of a full-scale sample with which the page begins \[Pa\]: twice the peak of the run.
    pub full_scale: f64,
    /// What the file holds.
    pub summary: ReplaySummary,
}

impl Session<'_> {
    /// Writes a recorded run as a `.replay` file for the page; see
    /// [`web_replay`](crate::formats::web_replay). The session is one of a timeline folder, which holds all
    /// poses. Obtains models first.
    ///
    /// # Errors
    /// [`Error::NotRecorded`] for a scene, [`Error::Timeline`], [`Error::Render`] for a run that the
    /// real-time engine cannot play, [`Error::Replay`], and those of
    /// [`obtain_models`](Self::obtain_models). The file appears only once it is complete.
    pub fn export_web(&mut self, output: impl AsRef<Path>) -> Result<ExportedReplay, Error> {
        if let Motion::Scene(_) = self.source.motion {
            return Err(Error::NotRecorded);
        }
        self.obtain_models()?;
        let Motion::Timeline(reader) = &self.source.motion else { return Err(Error::NotRecorded) };
        let Some(models) = &self.models else { return Err(Error::Interrupted) };
        let (bodies, options) = (&self.source.bodies, &self.options);
        let timeline = reader.read_all()?;
        let rate = options.synthesis.sample_rate;
        let mut run = ScheduledEngine::new(bodies, &models.bodies, &timeline, options, rate)?;
        let on_progress = &mut self.on_progress;
        let full_scale = run.full_scale((0.0, options.to), &mut |time| {
            on_progress(&Progress::of_time(Stage::Level, "measure_peak", (time, options.to)))
        })?;
        let bank = default_bank();
        let replay = Replay {
            bodies,
            ringing: &run.ringing,
            timeline: &timeline,
            clicks: options.parts.acceleration,
            models: &models.bodies,
            own_model: &|id| self.own_model(&bodies[id.index()]),
            bank: bank.as_ref(),
            max_wavenumber: options.synthesis.max_wavenumber(),
            contact: &options.contact,
            listeners: &options.listeners,
            scene: reader.header().scene.as_deref().unwrap_or(EMPTY_SCENE),
            duration: options.to,
            full_scale,
        };
        let summary = write_replay(&replay, output.as_ref())?;
        Ok(ExportedReplay { full_scale, summary })
    }

    /// The model of a body that clicks by a field of its own: what [`obtain_models`](Self::obtain_models) has
    /// put into the cache.
    fn own_model(&self, body: &Body) -> Option<AccelerationModel> {
        let settings = self.model_options.acceleration(self.options.synthesis.max_wavenumber());
        let request = SoundModelRequest::of_body(body, AccelerationBake(settings.options)).ok()?;
        let found = obtain(&request, self.cache.as_ref(), &mut |_| ControlFlow::Continue(()));
        found.ok().map(|found| found.file.acceleration)
    }
}
