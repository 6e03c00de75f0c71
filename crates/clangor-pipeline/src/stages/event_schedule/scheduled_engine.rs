//! The real-time engine with the bodies of a run in its slots, the schedule of its events, and its level.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::realtime::{Controller, Engine};
use clangor_core::synthesis::SoundModel;
use clangor_core::synthesis::modal::ModalSource;
use clangor_core::synthesis::{Listener, SampleRate};
use clangor_core::timeline::Timeline;

use super::EventSchedule;
use super::event_feeder::measure_peak;
use crate::stages::render::{RenderError, RenderOptions, Transfers, modal_sources};

/// Full scale over the peak of a run, so that a second sound as loud still fits.
const HEADROOM: f64 = 2.0;
/// Full scale of a silent run \[Pa\].
const SILENT_FULL_SCALE: f64 = 1.0;

/// An engine for a run, and what is to be sent to it.
pub struct ScheduledEngine {
    /// The modal sources of the bodies that ring.
    pub ringing: BTreeMap<BodyId, Arc<ModalSource>>,
    /// The events of the run.
    pub schedule: EventSchedule,
    /// The listener, the first of the options.
    pub listener: Listener,
    /// The sender of events.
    pub controller: Controller,
    /// The engine.
    pub engine: Engine,
}

impl ScheduledEngine {
    /// The engine for the first listener of `options`; `bodies` are all that ever were, each with its model.
    ///
    /// # Errors
    /// [`RenderError::NoListener`], [`RenderError::Modes`], [`RenderError::Contact`] for a timeline that
    /// contradicts itself, [`RenderError::Synthesis`] for settings that the engine does not support.
    pub fn new(
        bodies: &[Body],
        models: &[SoundModel],
        timeline: &Timeline,
        options: &RenderOptions,
        sample_rate: SampleRate,
    ) -> Result<Self, RenderError> {
        let listener = options.listeners.first().ok_or(RenderError::NoListener)?.clone();
        let ringing = modal_sources(bodies, models, Transfers::Baked)?;
        let schedule = EventSchedule::new(bodies, models, &ringing, timeline, options)?;
        let settings = schedule.engine_settings(options, &listener, sample_rate);
        let (controller, engine) = schedule.engine(models, &ringing, &settings)?;
        Ok(ScheduledEngine { ringing, schedule, listener, controller, engine })
    }

    /// Renders a part of the run \[s\] as fast as possible. Returns a full scale of twice its peak \[Pa\],
    /// 1 Pa for silence. `on_progress` gets the time of the run \[s\] and breaks to stop. The engine is
    /// silent afterwards.
    ///
    /// # Errors
    /// [`RenderError::Interrupted`].
    pub fn full_scale(
        &mut self,
        window: (f64, f64),
        on_progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<f64, RenderError> {
        let both = (&mut self.controller, &mut self.engine);
        let peak = measure_peak(&self.schedule, &self.listener, window, both, on_progress)
            .ok_or(RenderError::Interrupted)?;
        Ok(if peak > 0.0 { HEADROOM * peak } else { SILENT_FULL_SCALE })
    }
}
