//! `clangor plot`: pictures.

mod bank_use;
mod spectrogram;

use std::path::Path;

use clangor_core::medium::Medium;
use clangor_core::sound_model::files::modal_file::ModalPart;
use clangor_pipeline::analysis::spectrum::Spectrum;
use clangor_pipeline::formats::atomic_file::write_atomically;
use clangor_pipeline::formats::wav::WavReader;
use clangor_pipeline::plots::field::{self, FieldPlot};
use clangor_pipeline::plots::modes::{self, ModePlot};
use clangor_pipeline::plots::picture::{Canvas, Raster, Svg};
use clangor_pipeline::plots::spectrum::{self, SpectrumPlot};
use clangor_pipeline::stages::sound_models::{SoundFile, read_model, read_sound_file};
use serde_json::json;

use super::refuse_overwriting;
use crate::arguments::{Degree, Picture, Plot};
use crate::console::{Console, counted};
use crate::failure::Failure;

pub(crate) fn run(options: &Plot, console: &Console) -> Result<(), Failure> {
    let (input, output) = match &options.picture {
        Picture::Modes { model: input, output, .. }
        | Picture::Field { model: input, output, .. }
        | Picture::Spectrum { sound: input, output, .. }
        | Picture::Spectrogram { sound: input, output, .. }
        | Picture::BankUse { report: input, output, .. } => (input, output),
    };
    refuse_overwriting(input, output)?;
    match &options.picture {
        Picture::Field { model, output, degree, frequency } => {
            field(model, output, *degree, *frequency, console)
        }
        Picture::Modes { model, output, first } => modes(model, output, *first, console),
        Picture::Spectrum { sound, output, modes, max_frequency, channel } => {
            spectrum(sound, output, modes.as_deref(), *max_frequency, *channel, console)
        }
        Picture::Spectrogram { sound, output, timeline, max_frequency, from, to, window, start, channel } => {
            let wanted = spectrogram::Wanted {
                timeline: timeline.as_deref(),
                max_frequency: *max_frequency,
                from: *from,
                to: *to,
                window: *window,
                start: *start,
                channel: *channel,
            };
            spectrogram::draw(sound, output, &wanted, console)
        }
        Picture::BankUse { report, output, bank } => bank_use::draw(report, output, bank.as_deref(), console),
    }
}

/// Something to draw on, by the ending of its name.
fn canvas(output: &Path, width: usize, height: usize) -> Result<Box<dyn Canvas>, Failure> {
    match output.extension().and_then(|e| e.to_str()) {
        Some("png") => Ok(Box::new(Raster::new(width, height))),
        Some("svg") => Ok(Box::new(Svg::new(width, height))),
        _ => Err(Failure::new("the output must end in .png or .svg")),
    }
}

/// Shapes of modes.
fn modes(path: &Path, output: &Path, first: usize, console: &Console) -> Result<(), Failure> {
    let mut canvas = canvas(output, modes::WIDTH, modes::HEIGHT)?;
    let (name, part) = modal_part(path)?;
    let plot = ModePlot { name: format!("{name}, {}", part.origin.material), first };
    let drawn = plot
        .draw(&part.model, part.origin.first_frequency, canvas.as_mut())
        .map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))?;
    write_atomically(output, &canvas.encode().map_err(Failure::new)?).map_err(Failure::new)?;
    let last = first + drawn - 1;
    console.say(format_args!("{}: modes {first} to {last} of {}", output.display(), part.model.modes.len()));
    let modes = part.model.modes.len();
    let picture = output.to_string_lossy();
    console.json(&json!({ "picture": picture, "first": first, "last": last, "modes": modes }));
    Ok(())
}

/// The name of a body and its modes.
fn modal_part(path: &Path) -> Result<(String, ModalPart), Failure> {
    let (name, part) = match read_sound_file(path).map_err(Failure::new)? {
        SoundFile::Modal(file) => (file.solid.name, Some(file.modal)),
        SoundFile::Model(file) => (file.solid.name, file.modal),
        SoundFile::Pan(file) => (file.solid.name, None),
        SoundFile::Bank(_) | SoundFile::ModalSoundbank(_) => (String::new(), None),
    };
    let part = part.ok_or_else(|| Failure::new(format_args!("{}: {NO_MODES}", path.display())))?;
    Ok((name, part))
}

/// The spectrum of a sound.
fn spectrum(
    sound: &Path,
    output: &Path,
    model: Option<&Path>,
    max_frequency: Option<f64>,
    channel: usize,
    console: &Console,
) -> Result<(), Failure> {
    let mut canvas = canvas(output, spectrum::WIDTH, spectrum::HEIGHT)?;
    let failure = |e: &dyn std::fmt::Display| Failure::new(format_args!("{}: {e}", sound.display()));
    let (samples, rate) = one_channel(sound, channel)?;
    let half = 0.5 * rate;
    let end = max_frequency.unwrap_or(half.min(20_000.0));
    if end > half {
        return Err(failure(&format_args!("it ends at {half} Hz, half its sample rate; {end} Hz is beyond")));
    }
    let spectrum = Spectrum::of(&samples, rate).map_err(|e| failure(&e))?;
    let modes: Vec<f64> = match model {
        Some(model) => modal_part(model)?.1.model.known_modes().iter().map(|m| m.frequency).collect(),
        None => Vec::new(),
    };
    let name = sound.file_name().unwrap_or_default().to_string_lossy();
    let title = match channel {
        1 => format!("Spectrum of {name}"),
        channel => format!("Spectrum of {name}, channel {channel}"),
    };
    SpectrumPlot { title, max_frequency: end, modes: &modes }.draw(&spectrum, canvas.as_mut());
    write_atomically(output, &canvas.encode().map_err(Failure::new)?).map_err(Failure::new)?;
    let peaks = spectrum.peaks(end, PEAK_DEPTH);
    let off = |f: f64| modes.iter().map(|m| f - m).min_by(|a, b| a.abs().total_cmp(&b.abs()));
    let mut levels: Vec<f64> = peaks.iter().map(|peak| peak.level).collect();
    levels.sort_by(|a, b| b.total_cmp(a));
    let least = levels.get(LISTED - 1).copied().unwrap_or(f64::NEG_INFINITY);
    let listed = if peaks.len() > LISTED { format!("; the highest {LISTED}") } else { String::new() };
    console.say(format_args!(
        "{}: {} within {PEAK_DEPTH} dB of the highest{listed}:",
        output.display(),
        counted(peaks.len(), "peak", "peaks")
    ));
    for peak in peaks.iter().filter(|peak| peak.level >= least) {
        let beside = off(peak.frequency).map_or(String::new(), |d| format!(", {d:+.1} Hz from a mode"));
        console.say(format_args!("{:>10.1} Hz {:>6.1} dB{beside}", peak.frequency, peak.level));
    }
    console.json(&json!({
        "picture": output.display().to_string(),
        "max_frequency_hz": end,
        "peaks": peaks.iter().map(|p| json!({
            "frequency_hz": p.frequency,
            "level_db": p.level,
            "from_mode_hz": off(p.frequency),
        })).collect::<Vec<_>>(),
    }));
    Ok(())
}

/// Peaks that are found, below the highest [dB], and most that are listed; as JSON all are.
const PEAK_DEPTH: f64 = 60.0;
const LISTED: usize = 40;

/// The samples of a channel, counted from 1, and their rate \[Hz\].
fn one_channel(path: &Path, channel: usize) -> Result<(Vec<f32>, f64), Failure> {
    let mut reader = WavReader::open(path).map_err(Failure::new)?;
    let (rate, channels) = (f64::from(reader.info().sample_rate), usize::from(reader.info().channels));
    if !(1..=channels).contains(&channel) {
        return Err(Failure::new(format_args!(
            "{}: there is no channel {channel}; it has {}",
            path.display(),
            counted(channels, "channel", "channels")
        )));
    }
    let (mut samples, mut block) = (Vec::new(), Vec::new());
    while reader.read(&mut block, 1 << 16).map_err(Failure::new)? > 0 {
        samples.extend(block.iter().skip(channel - 1).step_by(channels));
        block.clear();
    }
    Ok((samples, rate))
}

/// What to say of a file without modes.
const NO_MODES: &str = "there are no modes in it; bake them with --material NAME --parts acceleration,modal";

/// How a model radiates.
fn field(
    path: &Path,
    output: &Path,
    degree: Degree,
    frequency: Option<f64>,
    console: &Console,
) -> Result<(), Failure> {
    let mut canvas = canvas(output, field::WIDTH, field::HEIGHT)?;
    let file = read_model(path).map_err(Failure::new)?;
    let highest = file.acceleration.max_frequency(Medium::AIR.sound_speed);
    let plot = FieldPlot {
        degree: degree as usize,
        frequency: frequency.unwrap_or(0.5 * highest),
        medium: Medium::AIR,
    };
    plot.draw(&file, canvas.as_mut()).map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))?;
    write_atomically(output, &canvas.encode().map_err(Failure::new)?).map_err(Failure::new)?;
    console.say(format_args!("{}: directivity at {:.0} Hz and a push", output.display(), plot.frequency));
    let picture = output.to_string_lossy();
    console.json(&json!({ "picture": picture, "frequency_hz": plot.frequency, "max_frequency_hz": highest }));
    Ok(())
}
