//! A run that is ready to be played, and the loop that feeds the engine in the time of the device.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use clangor_core::realtime::{PlaybackLevel, Report};
use clangor_pipeline::session::{LevelledRun, Session};
use clangor_pipeline::stages::event_schedule::event_feeder::EventFeeder;
use clangor_pipeline::stages::event_schedule::scheduled_engine::ScheduledEngine;

use super::PlaybackOptions;
use super::device::PlaybackDevice;
use super::error::PlaybackError;
use super::report::PlaybackReport;

/// Silence before the beginning \[s\], so that the first impact comes in time.
const LEAD: f64 = 0.1;
/// Period of sending events.
const FEED_EVERY: Duration = Duration::from_millis(10);
/// A device that requests no samples for so long does not work.
const PATIENCE: Duration = Duration::from_secs(10);

/// An engine with the events of a run, and the device that it is to play on.
pub struct PreparedPlayback {
    run: LevelledRun,
    device: PlaybackDevice,
}

impl PreparedPlayback {
    /// All steps up to the moment before the first sample, for a caller that reports the device and the full
    /// scale first; else there is [`play`](super::play).
    ///
    /// # Errors
    /// [`PlaybackError::FullScale`] unless the full scale is above 0, [`PlaybackError::Session`] for the run,
    /// and for the default device those of [`PlaybackDevice::open`], before anything is simulated.
    pub fn new(session: &mut Session<'_>, options: PlaybackOptions) -> Result<Self, PlaybackError> {
        if let Some(pressure) = options.full_scale.filter(|pa| !(*pa > 0.0 && pa.is_finite())) {
            return Err(PlaybackError::FullScale { pressure });
        }
        let device = match options.device {
            Some(device) => device,
            None => PlaybackDevice::open(None)?,
        };
        let run = session.levelled_run(device.sample_rate(), options.full_scale)?;
        Ok(PreparedPlayback { run, device })
    }

    /// The device.
    pub fn device(&self) -> &PlaybackDevice {
        &self.device
    }

    /// Pressure of a full-scale sample \[Pa\].
    pub fn full_scale(&self) -> f64 {
        self.run.full_scale
    }

    /// Start and end of the played part, in the time of the run \[s\].
    pub fn window(&self) -> (f64, f64) {
        self.run.window
    }

    /// Duration of the playback with the silence before it \[s\].
    pub fn duration(&self) -> f64 {
        self.run.window.1 - self.run.window.0 + LEAD
    }

    /// Plays to the end, in the time of the device. `on_progress` gets the time played \[s\], up to
    /// [`duration`](Self::duration), and breaks to stop.
    ///
    /// # Errors
    /// [`PlaybackError::NotStarted`], [`PlaybackError::DeviceStopped`], [`PlaybackError::Stalled`] for the
    /// device; [`PlaybackError::Stopped`] for `on_progress`; [`PlaybackError::Engine`].
    pub fn play(
        self,
        on_progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<PlaybackReport, PlaybackError> {
        let length = self.duration();
        let PreparedPlayback { run: LevelledRun { run, full_scale, window: (from, to) }, device } = self;
        let ScheduledEngine { schedule, listener, mut controller, engine, .. } = run;
        let rate = f64::from(device.sample_rate());
        let (before, first, latency) = (engine.report(), engine.time(), engine.latency());
        let mut feed = EventFeeder::new(&schedule, &listener, from, first + LEAD);
        feed.feed(&mut controller, first)?;
        let (stream, status) = device.play(engine, PlaybackLevel { full_scale })?;
        let mut moved = (0, Instant::now());
        loop {
            let frames = status.frames();
            let played = frames as f64 / rate;
            if played >= length + latency + status.device_latency() {
                break;
            }
            if let Some(why) = status.stopped() {
                return Err(PlaybackError::DeviceStopped { device: device.name(), why });
            }
            if frames != moved.0 {
                moved = (frames, Instant::now());
            } else if moved.1.elapsed() > PATIENCE {
                return Err(PlaybackError::Stalled { device: device.name(), seconds: PATIENCE.as_secs() });
            }
            feed.feed(&mut controller, first + played)?;
            if on_progress(played).is_break() {
                return Err(PlaybackError::Stopped);
            }
            std::thread::sleep(FEED_EVERY);
        }
        drop(stream);
        let after = controller.report();
        Ok(PlaybackReport {
            device: device.name(),
            sample_rate: device.sample_rate(),
            full_scale,
            from,
            to,
            impacts: feed.impacts(),
            objects: schedule.objects.len(),
            taken: after.taken - before.taken,
            waves: after.waves - before.waves,
            late: after.late - before.late,
            lost: after.lost - before.lost,
            refused: after.refused - before.refused,
            left_out: left_out(&after) - left_out(&before),
            engine_latency: latency,
            device_latency: status.device_latency(),
            underruns: status.underruns(),
        })
    }
}

/// Events and waves that were not rendered.
fn left_out(report: &Report) -> u64 {
    report.lost + report.shed + report.shed_voices + report.distant
}
