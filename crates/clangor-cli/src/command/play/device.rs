//! The loudspeaker: which devices there are, and an engine that plays on one of them.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use clangor_core::realtime::{Engine, PlaybackLevel};
use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{
    BufferSize, Device, ErrorKind, FromSample, OutputCallbackInfo, SampleFormat, SizedSample, Stream,
    StreamConfig, SupportedStreamConfigRange,
};
use serde_json::json;

use crate::console::Console;
use crate::failure::Failure;

/// Formats in which samples are given to devices, best first.
const FORMATS: [SampleFormat; 4] =
    [SampleFormat::F32, SampleFormat::I32, SampleFormat::I16, SampleFormat::F64];
/// Rates of devices, best first \[Hz\].
const RATES: [u32; 4] = [48_000, 44_100, 96_000, 192_000];
/// Frames that the engine renders at once.
const BLOCK: usize = 1024;
/// How far a device may be ahead of time \[s\], less than events are: one that takes samples faster than they
/// can be heard, such as ALSA's `null`, is made to wait.
const HEADWAY: f64 = 0.3;

/// A device, and how it is played on.
pub(super) struct Output {
    device: Device,
    config: StreamConfig,
    format: SampleFormat,
}

/// What the audio thread tells.
#[derive(Default)]
pub(super) struct Heard {
    frames: AtomicU64,
    underruns: AtomicU64,
    device_latency_ns: AtomicU64,
    gone: AtomicBool,
    why: Mutex<String>,
}

/// Prints the devices that play.
pub(super) fn list(console: &Console) -> Result<(), Failure> {
    let devices = outputs()?;
    let mut info = Vec::new();
    for device in &devices {
        let (id, name) = names(device);
        console.say(format_args!("{id}  {name}"));
        info.push(json!({ "id": id, "name": name }));
    }
    if devices.is_empty() {
        console.say("there is no audio device that plays");
    }
    console.json(&json!({ "devices": info }));
    Ok(())
}

fn outputs() -> Result<Vec<Device>, Failure> {
    let devices = cpal::default_host().output_devices();
    devices
        .map(Iterator::collect)
        .map_err(|error| Failure::new(format_args!("the system tells no audio devices: {error}")))
}

/// Identifier and name.
fn names(device: &Device) -> (String, String) {
    let id = device.id().map_or_else(|_| "?".into(), |id| id.to_string());
    (id, device.to_string())
}

impl Output {
    /// The device of this name or identifier, or the system's.
    pub(super) fn open(name: Option<&str>) -> Result<Self, Failure> {
        let device = match name {
            None => cpal::default_host().default_output_device().ok_or_else(|| {
                Failure::new(
                    "there is no audio device to play on; `clangor render` writes the sound to a \
                    file instead",
                )
            })?,
            Some(wanted) => {
                let is_wanted = |device: &Device| {
                    let (id, name) = names(device);
                    let short = id.split_once(':').map_or(id.as_str(), |(_, short)| short);
                    [id.as_str(), short, name.as_str()].contains(&wanted)
                };
                outputs()?.into_iter().find(is_wanted).ok_or_else(|| {
                    Failure::new(format_args!("there is no audio device \"{wanted}\"; --devices lists them"))
                })?
            }
        };
        let unusable = |why: String| {
            Failure::new(format_args!(
                "the audio device \"{device}\" cannot be played on: {why}; `clangor render` writes the \
                 sound to a file instead"
            ))
        };
        let ranges: Vec<SupportedStreamConfigRange> =
            device.supported_output_configs().map_err(|error| unusable(error.to_string()))?.collect();
        let (config, format) = best(&ranges)
            .ok_or_else(|| unusable("it takes no format of samples that is known here".into()))?;
        Ok(Output { device, config, format })
    }

    pub(super) fn name(&self) -> String {
        self.device.to_string()
    }

    pub(super) fn sample_rate(&self) -> u32 {
        self.config.sample_rate
    }

    /// Lets an engine play from now on, until the stream is dropped.
    pub(super) fn play(&self, engine: Engine, level: PlaybackLevel) -> Result<(Stream, Arc<Heard>), Failure> {
        let heard = Arc::<Heard>::default();
        let player = Player {
            engine,
            level,
            channels: usize::from(self.config.channels),
            rate: f64::from(self.config.sample_rate),
            begun: None,
            heard: Arc::clone(&heard),
        };
        let stream = match self.format {
            SampleFormat::F64 => self.start::<f64>(player),
            SampleFormat::I32 => self.start::<i32>(player),
            SampleFormat::I16 => self.start::<i16>(player),
            _ => self.start::<f32>(player),
        };
        let stream = stream.and_then(|stream| stream.play().map(|()| stream));
        let failed =
            |error| Failure::new(format_args!("the audio device \"{}\" does not play: {error}", self.device));
        Ok((stream.map_err(failed)?, heard))
    }

    fn start<T: SizedSample + FromSample<f32>>(&self, mut player: Player) -> Result<Stream, cpal::Error> {
        let heard = Arc::clone(&player.heard);
        let render = move |samples: &mut [T], info: &OutputCallbackInfo| player.render(samples, info);
        let failed = move |error: cpal::Error| match error.kind() {
            ErrorKind::Xrun => _ = heard.underruns.fetch_add(1, Ordering::Relaxed),
            ErrorKind::RealtimeDenied | ErrorKind::DeviceChanged => {}
            _ => {
                if let Ok(mut why) = heard.why.lock() {
                    *why = error.to_string();
                }
                heard.gone.store(true, Ordering::Release);
            }
        };
        self.device.build_output_stream(self.config, render, failed, None)
    }
}

/// Two channels in a format and at a rate that come early in the lists; else what is next to that.
fn best(ranges: &[SupportedStreamConfigRange]) -> Option<(StreamConfig, SampleFormat)> {
    let candidates = ranges.iter().filter_map(|range| {
        let format = FORMATS.iter().position(|format| *format == range.sample_format())?;
        let (least, most) = (range.min_sample_rate(), range.max_sample_rate());
        let rate = RATES.iter().position(|rate| (least..=most).contains(rate))?;
        let channels = range.channels();
        // One channel is worse than more than two.
        Some(((channels.abs_diff(2) + 100 * u16::from(channels < 2), rate, format), channels))
    });
    let ((_, rate, format), channels) = candidates.min_by_key(|(rank, _)| *rank)?;
    let config = StreamConfig { channels, sample_rate: RATES[rate], buffer_size: BufferSize::Default };
    Some((config, FORMATS[format]))
}

impl Heard {
    /// Frames that the device has taken.
    pub(super) fn frames(&self) -> u64 {
        self.frames.load(Ordering::Acquire)
    }

    /// How often the device ran dry.
    pub(super) fn underruns(&self) -> u64 {
        self.underruns.load(Ordering::Relaxed)
    }

    /// Longest time from a sample's rendering until it is heard, as the device tells \[s\].
    pub(super) fn device_latency(&self) -> f64 {
        1e-9 * self.device_latency_ns.load(Ordering::Relaxed) as f64
    }

    /// Why the device has stopped, if it has.
    pub(super) fn stopped(&self) -> Option<String> {
        let why = || self.why.lock().map(|why| why.clone()).unwrap_or_default();
        self.gone.load(Ordering::Acquire).then(why)
    }
}

/// What runs on the audio thread.
struct Player {
    engine: Engine,
    level: PlaybackLevel,
    channels: usize,
    rate: f64,
    begun: Option<Instant>,
    heard: Arc<Heard>,
}

impl Player {
    fn render<T: SizedSample + FromSample<f32>>(&mut self, samples: &mut [T], info: &OutputCallbackInfo) {
        let timestamp = info.timestamp();
        let ahead = timestamp.playback.saturating_duration_since(timestamp.callback);
        self.heard.device_latency_ns.fetch_max(ahead.as_nanos() as u64, Ordering::Relaxed);
        for part in samples.chunks_mut(BLOCK * self.channels) {
            let count = part.len() / self.channels;
            let heard = self.engine.render(count);
            for (index, frame) in part.chunks_exact_mut(self.channels).enumerate() {
                let ear = |receiver: usize| heard.get(receiver).or(heard.first()).map_or(0.0, |p| p[index]);
                match frame {
                    [only] => *only = T::from_sample(self.level.sample(0.5 * (ear(0) + ear(1)))),
                    [left, right, rest @ ..] => {
                        *left = T::from_sample(self.level.sample(ear(0)));
                        *right = T::from_sample(self.level.sample(ear(1)));
                        rest.fill(T::EQUILIBRIUM);
                    }
                    [] => {}
                }
            }
            self.heard.frames.fetch_add(count as u64, Ordering::Release);
        }
        let begun = *self.begun.get_or_insert_with(Instant::now);
        let ahead = self.heard.frames() as f64 / self.rate - begun.elapsed().as_secs_f64();
        if ahead > HEADWAY {
            std::thread::sleep(Duration::from_secs_f64(ahead - HEADWAY));
        }
    }
}
