//! From a scene to the device: everything is prepared as for `render`, and played once without being heard, for its level.

use std::path::Path;
use std::time::{Duration, Instant};

use clangor::realtime::{Controller, Engine, EngineSettings, Event, PlaybackLevel, Report, engine};
use clangor::synthesis::{Listener, SampleRate};
use clangor_pipeline::live_score::LiveScore;
use clangor_pipeline::live_score::feed::Feed;
use clangor_pipeline::render::{Transfers, modal_sources};
use serde_json::json;

use super::super::render::{Prepared, prepare};
use super::device::Output;
use crate::arguments::{Global, Play, Render, Transfer};
use crate::console::{Console, counted, four_digits};
use crate::failure::Failure;

/// Silence before the beginning \[s\], so that the first blow comes in time.
const LEAD: f64 = 0.1;
/// How often events are sent.
const FEED_EVERY: Duration = Duration::from_millis(10);
/// A device that takes nothing for so long does not work.
const PATIENCE: Duration = Duration::from_secs(10);
/// Frames rendered at once where nobody listens.
const BLOCK: usize = 1024;

pub(super) fn run(input: &Path, options: &Play, global: &Global, console: &Console) -> Result<(), Failure> {
    // Who has no loudspeaker is told so before a long simulation.
    let output = Output::open(options.device.as_deref())?;
    let asked = rendering(input, options, output.sample_rate());
    let Prepared { bodies, options: how, sources, ringers, timeline, .. } =
        prepare(&asked, None, global, console)?;
    let Some(listener) = how.listeners.first() else { return Err(Failure::new("there is no listener")) };
    let ringing = modal_sources(&bodies, &ringers, Transfers::Baked).map_err(Failure::new)?;
    let score =
        LiveScore::new(&bodies, &sources.sources, &ringing, &timeline, &how.contact).map_err(Failure::new)?;
    let (from, to) = (how.synthesis.start, how.to);
    let places: Vec<_> = (0..listener.receivers.len())
        .flat_map(|receiver| [from, to].map(|time| listener.receiver_position(receiver, time)))
        .collect();
    let settings = EngineSettings {
        sample_rate: SampleRate::try_new(output.sample_rate()).map_err(Failure::new)?,
        medium: how.synthesis.medium,
        floor: how.synthesis.floor,
        room: how.room.clone(),
        air: how.air,
        profile: how.contact.profile,
        receivers: listener.receivers.len(),
        reach: EngineSettings::default().reach.max(1.5 * score.extent(&places)),
        objects: score.objects.len(),
        ..EngineSettings::default()
    };
    let (mut controller, mut live) = engine(&settings).map_err(Failure::new)?;
    for (slot, object) in score.sounding_objects(&sources.sources, &ringing, &settings).enumerate() {
        controller.put(slot, Some(object)).map_err(Failure::new)?;
        // A block takes what the ring holds.
        if slot % BLOCK == 0 {
            live.render(1);
        }
    }
    let mut played = Performance { score: &score, listener, from, length: to - from + LEAD };
    let full_scale = match options.full_scale {
        Some(pressure) => pressure,
        None => match 2.0 * played.rehearse(&mut controller, &mut live, console)? {
            silent if silent <= 0.0 => 1.0,
            loud => loud,
        },
    };
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
    let Performed { report, blows, underruns, device_latency } = heard;
    console.say(format_args!(
        "{} played, {} late, {} left out; latency {:.1} ms and {:.1} ms of the device; {}",
        counted(blows, "blow", "blows"),
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
        "blows": blows,
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

/// What `render` would be asked.
fn rendering(input: &Path, options: &Play, sample_rate: u32) -> Render {
    Render {
        input: input.into(),
        output: None,
        listener: options.listener.into_iter().collect(),
        timeline: None,
        sample_rate: Some(sample_rate),
        max_frequency: None,
        quality: options.quality,
        sound: None,
        parts: Vec::new(),
        transfer: Transfer::Baked,
        model: Vec::new(),
        bits: None,
        duration: options.duration,
        from: options.from,
        to: options.to,
        full_scale: options.full_scale,
        normalize: None,
        stems: false,
        explain: false,
        report: None,
        force: false,
    }
}

/// A score, who hears it, and which part of it.
struct Performance<'a> {
    score: &'a LiveScore,
    listener: &'a Listener,
    /// Beginning in the run \[s\].
    from: f64,
    /// Length with the silence before it \[s\].
    length: f64,
}

/// What a performance tells.
struct Performed {
    report: Report,
    blows: usize,
    underruns: u64,
    device_latency: f64,
}

impl Performance<'_> {
    /// The loudest pressure \[Pa\] of everything, played as fast as can be. What still sounds then is stopped.
    fn rehearse(
        &mut self,
        controller: &mut Controller,
        live: &mut Engine,
        console: &Console,
    ) -> Result<f64, Failure> {
        let begin = live.time();
        let end = begin + self.length + live.latency();
        let mut feed = Feed::new(self.score, self.listener, self.from, begin + LEAD);
        let progress = console.progress("rehearse", self.length);
        let mut peak = 0.0_f64;
        while live.time() < end {
            feed.feed(controller, live.time()).map_err(Failure::new)?;
            let channels = live.render(BLOCK);
            peak = channels.iter().flatten().fold(peak, |peak, p| peak.max(p.abs()));
            if progress.reached(live.time() - begin).is_break() {
                return Err(Failure::Interrupted);
            }
        }
        controller.send(Event::Silence).map_err(Failure::new)?;
        // It takes a millisecond to fall silent, and events to come are forgotten.
        live.render(BLOCK);
        Ok(peak)
    }

    /// Plays to the end, in the time of the device; the run begins at `begin` \[s of the engine\].
    fn perform(
        &mut self,
        output: &Output,
        mut controller: Controller,
        live: Engine,
        level: PlaybackLevel,
        begin: f64,
        console: &Console,
    ) -> Result<Performed, Failure> {
        let rate = f64::from(output.sample_rate());
        let (first, latency) = (live.time(), live.latency());
        let mut feed = Feed::new(self.score, self.listener, self.from, begin);
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
            blows: feed.blows(),
            underruns: heard.underruns(),
            device_latency: heard.device_latency(),
        })
    }
}
