//! `clangor plot spectrogram`.

use std::path::Path;

use clangor_core::timeline::FractureRow;
use clangor_pipeline::analysis::spectrogram::Spectrogram;
use clangor_pipeline::formats::atomic_file::write_atomically;
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::plots::spectrogram::{self, SpectrogramPlot};
use serde_json::json;

use super::{canvas, one_channel};
use crate::console::{Console, counted};
use crate::failure::Failure;

/// What part of a sound to draw, and how.
pub(super) struct Wanted<'a> {
    pub(super) timeline: Option<&'a Path>,
    pub(super) max_frequency: Option<f64>,
    /// In seconds of the sound.
    pub(super) from: Option<f64>,
    pub(super) to: Option<f64>,
    /// Length of the window [s].
    pub(super) window: f64,
    /// Time in the timeline at which the sound begins [s].
    pub(super) start: f64,
    pub(super) channel: usize,
}

/// How a spectrum changes, with births and deaths.
pub(super) fn draw(
    sound: &Path,
    output: &Path,
    wanted: &Wanted<'_>,
    console: &Console,
) -> Result<(), Failure> {
    let mut canvas = canvas(output, spectrogram::WIDTH, spectrogram::HEIGHT)?;
    let failure = |e: &dyn std::fmt::Display| Failure::new(format_args!("{}: {e}", sound.display()));
    let (samples, rate) = one_channel(sound, wanted.channel)?;
    let half = 0.5 * rate;
    let max_frequency = wanted.max_frequency.unwrap_or(half.min(20_000.0));
    if max_frequency > half {
        return Err(failure(&format_args!(
            "it ends at {half} Hz, half its sample rate; {max_frequency} Hz is beyond"
        )));
    }
    let length = samples.len() as f64 / rate;
    let (from, to) = (wanted.from.unwrap_or(0.0), wanted.to.unwrap_or(length).min(length));
    if from >= to {
        return Err(failure(&format_args!(
            "it lasts {length} s, and nothing of it is between {from} and {to} s"
        )));
    }
    let [first, last] = [from, to].map(|t| ((t * rate).round() as usize).min(samples.len()));
    let columns = spectrogram::COLUMNS;
    let part = &samples[first..last];
    let spectrogram =
        Spectrogram::of(part, rate, columns, max_frequency, wanted.window).map_err(|e| failure(&e))?;
    let fractures: Option<Vec<FractureRow>> = match wanted.timeline {
        Some(folder) => Some(TimelineReader::open(folder).map_err(Failure::new)?.fractures().to_vec()),
        None => None,
    };
    let name = sound.file_name().unwrap_or_default().to_string_lossy();
    let plot = SpectrogramPlot {
        title: match wanted.channel {
            1 => format!("Spectrogram of {name}"),
            channel => format!("Spectrogram of {name}, channel {channel}"),
        },
        time: [from + wanted.start, to + wanted.start],
        max_frequency,
        fractures: fractures.as_deref(),
    };
    plot.draw(&spectrogram, canvas.as_mut());
    write_atomically(output, &canvas.encode().map_err(Failure::new)?).map_err(Failure::new)?;
    let shown = plot.shown();
    let births: u32 = shown.iter().map(|row| row.children).sum();
    let marked = match wanted.timeline {
        Some(_) => format!(", {} and {births} births", counted(shown.len(), "death", "deaths")),
        None => String::new(),
    };
    console.say(format_args!("{}: {from} to {to} s, to {max_frequency:.0} Hz{marked}", output.display()));
    console.json(&json!({
        "picture": output.display().to_string(),
        "max_frequency_hz": max_frequency,
        "deaths": wanted.timeline.map(|_| shown.len()),
        "births": wanted.timeline.map(|_| births),
    }));
    Ok(())
}
