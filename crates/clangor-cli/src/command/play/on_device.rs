//! Playback of a scene or a timeline on an audio device, and the list of devices.

use std::path::Path;

use clangor_playback::{PlaybackDevice, PlaybackOptions, PlaybackReport, PreparedPlayback, devices};
use serde_json::json;

use super::super::session::{StageBars, check_simulated, open, prepare, settings, warn_of_plates};
use crate::arguments::{Device, Global, Play};
use crate::console::{Console, counted, four_digits};
use crate::failure::Failure;

/// Prints the output devices.
pub(super) fn list(console: &Console) -> Result<(), Failure> {
    let devices = devices()?;
    for device in &devices {
        console.say(format_args!("{}  {}", device.id, device.name));
    }
    if devices.is_empty() {
        console.say("there is no audio device that plays");
    }
    let info: Vec<_> = devices.iter().map(|d| json!({ "id": d.id, "name": d.name })).collect();
    console.json(&json!({ "devices": info }));
    Ok(())
}

pub(super) fn run(input: &Path, options: &Play, global: &Global, console: &Console) -> Result<(), Failure> {
    // Without an output device, ends before a long simulation.
    let device = PlaybackDevice::open(options.device.as_deref())?;
    check_simulated(input, &[("--seed", global.seed.is_some()), ("--duration", options.duration.is_some())])?;
    // `--device` is the loudspeaker here.
    let mut settings = settings(options.models.on(Device::Cpu), global)
        .sample_rate(device.sample_rate())
        .from(options.from.unwrap_or(0.0));
    if let Some(position) = options.listener {
        settings = settings.listener(position);
    }
    if let Some(seconds) = options.duration {
        settings = settings.duration(seconds);
    }
    if let Some(end) = options.to {
        settings = settings.to(end);
    }
    let bars = StageBars::new(console);
    let mut session = open(input, settings, console, &bars)?;
    prepare(&mut session, console, &bars)?;
    warn_of_plates(&session, console);
    let playback = PlaybackOptions { device: Some(device), full_scale: options.full_scale };
    let prepared = PreparedPlayback::new(&mut session, playback)?;
    bars.clear();
    let (from, to) = prepared.window();
    console.say(format_args!(
        "{} s on \"{}\" at {} Hz, full scale {} Pa",
        four_digits(to - from),
        prepared.device().name(),
        prepared.device().sample_rate(),
        four_digits(prepared.full_scale()),
    ));
    let progress = console.progress("play", prepared.duration());
    let report = prepared.play(&mut |time| progress.reached(time))?;
    drop(progress);
    print(&report, console);
    Ok(())
}

fn print(report: &PlaybackReport, console: &Console) {
    console.say(format_args!(
        "{} played, {} late, {} left out; latency {:.1} ms and {:.1} ms of the device; {}",
        counted(report.impacts, "impact", "impacts"),
        report.late,
        report.left_out,
        1e3 * report.engine_latency,
        1e3 * report.device_latency,
        counted(report.underruns as usize, "underrun", "underruns"),
    ));
    console.json(&json!({
        "device": report.device,
        "sample_rate_hz": report.sample_rate,
        "full_scale_pa": report.full_scale,
        "from_s": report.from,
        "to_s": report.to,
        "impacts": report.impacts,
        "objects": report.objects,
        "taken": report.taken,
        "waves": report.waves,
        "late": report.late,
        "lost": report.lost,
        "refused": report.refused,
        "left_out": report.left_out,
        "engine_latency_s": report.engine_latency,
        "device_latency_s": report.device_latency,
        "underruns": report.underruns,
    }));
}
