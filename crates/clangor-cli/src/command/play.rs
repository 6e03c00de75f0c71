//! `clangor play`: a scene or a timeline through the loudspeaker, as the real-time engine plays it.

#[cfg(feature = "playback")]
mod on_device;

use crate::arguments::{Global, Play};
use crate::console::Console;
use crate::failure::Failure;

#[cfg(feature = "playback")]
pub(crate) fn run(options: &Play, global: &Global, console: &Console) -> Result<(), Failure> {
    match &options.input {
        Some(input) if !options.devices => on_device::run(input, options, global, console),
        _ => on_device::list(console),
    }
}

#[cfg(not(feature = "playback"))]
pub(crate) fn run(_options: &Play, _global: &Global, _console: &Console) -> Result<(), Failure> {
    Err(Failure::new(
        "this program was built without playback: cargo build --release --features playback; on Linux \
         that needs ALSA's headers \
         (apt-get install libasound2-dev)",
    ))
}
