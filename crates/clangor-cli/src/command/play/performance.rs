//! From a scene to the device: everything is prepared as for `render`, and played once without being heard,
//! for its level.

use std::path::Path;
use std::time::{Duration, Instant};

use clangor_core::realtime::{Controller, Engine, PlaybackLevel, Report};
use clangor_core::synthesis::{Listener, SampleRate};
use clangor_pipeline::stages::event_schedule::EventSchedule;
use clangor_pipeline::stages::event_schedule::event_feeder::{EventFeeder, measure_peak};
use clangor_pipeline::stages::render::{Transfers, modal_sources};
use serde_json::json;

use super::super::render::{StageBars, open, prepare};
use super::device::Output;
use crate::arguments::{Global, Play, Render};
use crate::console::{Console, counted, four_digits};
use crate::failure::Failure;

/// Silence before the beginning \[s\], so that the first impact comes in time.
const LEAD: f64 = 0.1;
/// How often events are sent.
const FEED_EVERY: Duration = Duration::from_millis(10);
/// A device that takes nothing for so long does not work.
const PATIENCE: Duration = Duration::from_secs(10);

pub(super) fn run(input: &Path, options: &Play, global: &Global, console: &Console) -> Result<(), Failure> {
    // Who has no loudspeaker is told so before a long simulation.
    let output = Output::open(options.device.as_deref())?;
    let asked = Render {
        listener: options.listener.into_iter().collect(),
        sample_rate: Some(output.sample_rate()),
        quality: options.quality,
        duration: options.duration,
        from: options.from,
        to: options.to,
        full_scale: options.full_scale,
        ..Render::of(input)
    };
    let bars = StageBars::new(console);
    let mut session = open(&asked, global, console, &bars)?;
    prepare(&mut session, &asked, console, &bars)?;
    let (Some(models), Some(timeline)) = (session.models(), session.timeline()) else { return Ok(()) };
    let (bodies, how) = (session.bodies(), session.options());
    let Some(listener) = how.listeners.first() else { return Err(Failure::new("there is no listener")) };
    let ringing = modal_sources(bodies, &models.bodies, Transfers::Baked).map_err(Failure::new)?;
    let score = EventSchedule::new(bodies, &models.bodies, &ringing, timeline, how).map_err(Failure::new)?;
    let (from, to) = (how.synthesis.start, how.to);
    let rate = SampleRate::try_new(output.sample_rate()).map_err(Failure::new)?;
    let settings = score.engine_settings(how, listener, rate);
    let (mut controller, mut live) =
        score.engine(&models.bodies, &ringing, &settings).map_err(Failure::new)?;
    let full_scale = match options.full_scale {
        Some(pressure) => pressure,
        None => {
            let progress = console.progress("measure_peak", to);
            let mut on_progress = |time| progress.reached(time);
            let both = (&mut controller, &mut live);
            let loudest = measure_peak(&score, listener, (from, to), both, &mut on_progress)
                .ok_or(Failure::Interrupted)?;
            if loudest > 0.0 { 2.0 * loudest } else { 1.0 }
        }
    };
    let played = Performance { score: &score, listener, from, length: to - from + LEAD };
    let before = live.report();
    let latency = live.latency();
    console.say(format_args!(
        "{} s on \"{}\" at {} Hz, full scale {} Pa",
        four_digits(to - from),
        output.name(),
        output.sample_rate(),
        four_digits(full_scale),
    ));
    let begin = live.time() + LEAD;
    let heard = played.perform(&output, controller, live, PlaybackLevel { full_scale }, begin, console)?;
    let Performed { report, impacts, underruns, device_latency } = heard;
    console.say(format_args!(
        "{} played, {} late, {} left out; latency {:.1} ms and {:.1} ms of the device; {}",
        counted(impacts, "impact", "impacts"),
        report.late - before.late,
        left_out(&report) - left_out(&before),
        1e3 * latency,
        1e3 * device_latency,
        counted(underruns as usize, "underrun", "underruns"),
    ));
    console.json(&json!({
        "device": output.name(),
        "sample_rate_hz": output.sample_rate(),
        "full_scale_pa": full_scale,
        "from_s": from,
        "to_s": to,
        "impacts": impacts,
        "objects": score.objects.len(),
        "taken": report.taken - before.taken,
        "waves": report.waves - before.waves,
        "late": report.late - before.late,
        "lost": report.lost - before.lost,
        "refused": report.refused - before.refused,
        "left_out": left_out(&report) - left_out(&before),
        "engine_latency_s": latency,
        "device_latency_s": device_latency,
        "underruns": underruns,
    }));
    Ok(())
}

/// What there was no time for.
fn left_out(report: &Report) -> u64 {
    report.lost + report.shed + report.shed_voices + report.distant
}

/// A score, who hears it, and which part of it.
struct Performance<'a> {
    score: &'a EventSchedule,
    listener: &'a Listener,
    /// Beginning in the run \[s\].
    from: f64,
    /// Length with the silence before it \[s\].
    length: f64,
}

/// What a performance tells.
struct Performed {
    report: Report,
    impacts: usize,
    underruns: u64,
    device_latency: f64,
}

impl Performance<'_> {
    /// Plays to the end, in the time of the device; the run begins at `begin` \[s of the engine\].
    fn perform(
        &self,
        output: &Output,
        mut controller: Controller,
        live: Engine,
        level: PlaybackLevel,
        begin: f64,
        console: &Console,
    ) -> Result<Performed, Failure> {
        let rate = f64::from(output.sample_rate());
        let (first, latency) = (live.time(), live.latency());
        let mut feed = EventFeeder::new(self.score, self.listener, self.from, begin);
        feed.feed(&mut controller, first).map_err(Failure::new)?;
        let (stream, heard) = output.play(live, level)?;
        let progress = console.progress("play", self.length);
        let mut moved = (0, Instant::now());
        loop {
            let frames = heard.frames();
            let played = frames as f64 / rate;
            if played >= self.length + latency + heard.device_latency() {
                break;
            }
            if let Some(why) = heard.stopped() {
                return Err(Failure::new(format_args!(
                    "the audio device \"{}\" has stopped: {why}",
                    output.name()
                )));
            }
            if frames != moved.0 {
                moved = (frames, Instant::now());
            } else if moved.1.elapsed() > PATIENCE {
                return Err(Failure::new(format_args!(
                    "the audio device \"{}\" has taken no sound for {} s",
                    output.name(),
                    PATIENCE.as_secs()
                )));
            }
            feed.feed(&mut controller, first + played).map_err(Failure::new)?;
            if progress.reached(played).is_break() {
                return Err(Failure::InterruptedWith("stopped".into()));
            }
            std::thread::sleep(FEED_EVERY);
        }
        drop(stream);
        Ok(Performed {
            report: controller.report(),
            impacts: feed.impacts(),
            underruns: heard.underruns(),
            device_latency: heard.device_latency(),
        })
    }
}
