//! Playback of an engine on the default output device.

use clangor_core::realtime::{Engine, EngineSettings, PlaybackLevel};
use clangor_core::synthesis::SampleRate;
use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};

/// Why there is no playback.
#[derive(Debug)]
pub enum PlaybackError {
    /// No device, or one that cannot play floating-point samples in stereo.
    Device(String),
}

impl std::fmt::Display for PlaybackError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let PlaybackError::Device(why) = self;
        write!(f, "there is nothing to play on: {why}")
    }
}

impl std::error::Error for PlaybackError {}

/// Settings of an engine for the default device, at its sample rate.
///
/// # Errors
/// [`PlaybackError`] without a device.
pub fn settings_for_device(settings: EngineSettings) -> Result<EngineSettings, PlaybackError> {
    let config = device()?.default_output_config().map_err(|e| PlaybackError::Device(e.to_string()))?;
    let sample_rate =
        SampleRate::try_new(config.sample_rate()).map_err(|e| PlaybackError::Device(e.to_string()))?;
    Ok(EngineSettings { sample_rate, receivers: 2, ..settings })
}

/// Plays until what it returns is dropped; `full_scale` is the pressure [Pa] of the loudest sample there is.
///
/// # Errors
/// [`PlaybackError`] if the device refuses.
pub fn play(mut engine: Engine, full_scale: f64) -> Result<cpal::Stream, PlaybackError> {
    let device = device()?;
    let failed = |e: cpal::Error| PlaybackError::Device(e.to_string());
    let config = device.default_output_config().map_err(failed)?.config();
    let channels = usize::from(config.channels);
    let level = PlaybackLevel { full_scale };
    let callback = move |samples: &mut [f32], _: &cpal::OutputCallbackInfo| {
        for chunk in samples.chunks_mut(4096 * channels) {
            let heard = engine.render(chunk.len() / channels);
            for (frame, samples) in chunk.chunks_mut(channels).enumerate() {
                for (channel, sample) in samples.iter_mut().enumerate() {
                    *sample = heard.get(channel).map_or(0.0, |heard| level.sample(heard[frame]));
                }
            }
        }
    };
    let stream = device
        .build_output_stream(config, callback, |error| eprintln!("playback: {error}"), None)
        .map_err(failed)?;
    stream.play().map_err(failed)?;
    Ok(stream)
}

fn device() -> Result<cpal::Device, PlaybackError> {
    cpal::default_host()
        .default_output_device()
        .ok_or_else(|| PlaybackError::Device("no output device".into()))
}
