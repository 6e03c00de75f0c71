//! The output devices of the system, and an engine that plays on one of them.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use clangor_core::realtime::{Engine, PlaybackLevel};
use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{
    BufferSize, Device, ErrorKind, FromSample, OutputCallbackInfo, SampleFormat, SizedSample, Stream,
    StreamConfig, SupportedStreamConfigRange,
};

use super::error::PlaybackError;

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

/// Identifier and name of an output device; either selects it in [`PlaybackDevice::open`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceName {
    /// Identifier, with that of the system's audio interface before a colon.
    pub id: String,
    /// Name for people.
    pub name: String,
}

/// The output devices of the system.
///
/// # Errors
/// [`PlaybackError::NoList`].
pub fn devices() -> Result<Vec<DeviceName>, PlaybackError> {
    Ok(outputs()?.iter().map(DeviceName::of).collect())
}

fn outputs() -> Result<Vec<Device>, PlaybackError> {
    let devices = cpal::default_host().output_devices();
    devices.map(Iterator::collect).map_err(|error| PlaybackError::NoList { why: error.to_string() })
}

impl DeviceName {
    fn of(device: &Device) -> Self {
        let id = device.id().map_or_else(|_| "?".into(), |id| id.to_string());
        DeviceName { id, name: device.to_string() }
    }

    /// Whether a device is called so: by its name, or by its identifier with or without the interface.
    fn is(&self, wanted: &str) -> bool {
        let short = self.id.split_once(':').map_or(self.id.as_str(), |(_, short)| short);
        [self.id.as_str(), short, self.name.as_str()].contains(&wanted)
    }
}

/// An output device with a format and a rate of samples that it supports.
pub struct PlaybackDevice {
    device: Device,
    config: StreamConfig,
    format: SampleFormat,
}

/// State of a device during playback, written by the audio thread.
#[derive(Default)]
pub(super) struct DeviceStatus {
    frames: AtomicU64,
    underruns: AtomicU64,
    device_latency_ns: AtomicU64,
    gone: AtomicBool,
    why: Mutex<String>,
}

impl PlaybackDevice {
    /// The device of this name or identifier; without one, the system's default device.
    ///
    /// # Errors
    /// [`PlaybackError::NoDevice`], [`PlaybackError::UnknownDevice`], [`PlaybackError::NoList`], and
    /// [`PlaybackError::Unusable`] for a device without a known format of samples.
    pub fn open(name: Option<&str>) -> Result<Self, PlaybackError> {
        let device = match name {
            None => cpal::default_host().default_output_device().ok_or(PlaybackError::NoDevice)?,
            Some(wanted) => outputs()?
                .into_iter()
                .find(|device| DeviceName::of(device).is(wanted))
                .ok_or_else(|| PlaybackError::UnknownDevice { name: wanted.into() })?,
        };
        let unusable = |why: String| PlaybackError::Unusable { device: device.to_string(), why };
        let ranges: Vec<SupportedStreamConfigRange> =
            device.supported_output_configs().map_err(|error| unusable(error.to_string()))?.collect();
        let (config, format) = best(&ranges)
            .ok_or_else(|| unusable("it takes no format of samples that is known here".into()))?;
        Ok(PlaybackDevice { device, config, format })
    }

    /// Name of the device.
    pub fn name(&self) -> String {
        self.device.to_string()
    }

    /// Sample rate at which the device plays \[Hz\].
    pub fn sample_rate(&self) -> u32 {
        self.config.sample_rate
    }

    /// Plays an engine until the stream is dropped.
    ///
    /// # Errors
    /// [`PlaybackError::NotStarted`].
    pub(super) fn play(
        &self,
        engine: Engine,
        level: PlaybackLevel,
    ) -> Result<(Stream, Arc<DeviceStatus>), PlaybackError> {
        let status = Arc::<DeviceStatus>::default();
        let player = AudioCallback {
            engine,
            level,
            channels: usize::from(self.config.channels),
            rate: f64::from(self.config.sample_rate),
            begun: None,
            status: Arc::clone(&status),
        };
        let stream = match self.format {
            SampleFormat::F64 => self.start::<f64>(player),
            SampleFormat::I32 => self.start::<i32>(player),
            SampleFormat::I16 => self.start::<i16>(player),
            _ => self.start::<f32>(player),
        };
        let stream = stream.and_then(|stream| stream.play().map(|()| stream));
        let failed = |error: cpal::Error| PlaybackError::NotStarted {
            device: self.device.to_string(),
            why: error.to_string(),
        };
        Ok((stream.map_err(failed)?, status))
    }

    fn start<T: SizedSample + FromSample<f32>>(
        &self,
        mut player: AudioCallback,
    ) -> Result<Stream, cpal::Error> {
        let status = Arc::clone(&player.status);
        let render = move |samples: &mut [T], info: &OutputCallbackInfo| player.render(samples, info);
        let failed = move |error: cpal::Error| match error.kind() {
            ErrorKind::Xrun => _ = status.underruns.fetch_add(1, Ordering::Relaxed),
            ErrorKind::RealtimeDenied | ErrorKind::DeviceChanged => {}
            _ => {
                if let Ok(mut why) = status.why.lock() {
                    *why = error.to_string();
                }
                status.gone.store(true, Ordering::Release);
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

impl DeviceStatus {
    /// Frames that the device has taken.
    pub(super) fn frames(&self) -> u64 {
        self.frames.load(Ordering::Acquire)
    }

    /// How often the device ran out of samples.
    pub(super) fn underruns(&self) -> u64 {
        self.underruns.load(Ordering::Relaxed)
    }

    /// Longest time from the rendering of a sample until it is heard, as the device reports it \[s\].
    pub(super) fn device_latency(&self) -> f64 {
        1e-9 * self.device_latency_ns.load(Ordering::Relaxed) as f64
    }

    /// The system's message, once the device has stopped.
    pub(super) fn stopped(&self) -> Option<String> {
        let why = || self.why.lock().map(|why| why.clone()).unwrap_or_default();
        self.gone.load(Ordering::Acquire).then(why)
    }
}

/// The callback on the audio thread, which renders the samples that the device requests.
struct AudioCallback {
    engine: Engine,
    level: PlaybackLevel,
    channels: usize,
    rate: f64,
    begun: Option<Instant>,
    status: Arc<DeviceStatus>,
}

impl AudioCallback {
    fn render<T: SizedSample + FromSample<f32>>(&mut self, samples: &mut [T], info: &OutputCallbackInfo) {
        let timestamp = info.timestamp();
        let ahead = timestamp.playback.saturating_duration_since(timestamp.callback);
        self.status.device_latency_ns.fetch_max(ahead.as_nanos() as u64, Ordering::Relaxed);
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
            self.status.frames.fetch_add(count as u64, Ordering::Release);
        }
        let begun = *self.begun.get_or_insert_with(Instant::now);
        let ahead = self.status.frames() as f64 / self.rate - begun.elapsed().as_secs_f64();
        if ahead > HEADWAY {
            std::thread::sleep(Duration::from_secs_f64(ahead - HEADWAY));
        }
    }
}
