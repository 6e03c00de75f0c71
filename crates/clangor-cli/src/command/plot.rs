//! `clangor plot`: pictures.

use std::path::Path;

use clangor::medium::Medium;
use clangor_pipeline::atomic_file::write_atomically;
use clangor_pipeline::field_plot::{self, FieldPlot};
use clangor_pipeline::mode_plot::{self, ModePlot};
use clangor_pipeline::picture::{Canvas, Raster, Svg};
use clangor_pipeline::sound_models::{SoundFile, read_model, read_sound_file};
use serde_json::json;

use crate::arguments::{Degree, Picture, Plot};
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn run(options: &Plot, console: &Console) -> Result<(), Failure> {
    match &options.picture {
        Picture::Field { model, output, degree, frequency } => {
            field(model, output, *degree, *frequency, console)
        }
        Picture::Modes { model, output, first } => modes(model, output, *first, console),
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
    let mut canvas = canvas(output, mode_plot::WIDTH, mode_plot::HEIGHT)?;
    let (name, part) = match read_sound_file(path).map_err(Failure::new)? {
        SoundFile::Modal(file) => (file.solid.name, Some(file.modal)),
        SoundFile::Model(file) => (file.solid.name, file.modal),
        SoundFile::Published(file) => (file.solid.name, None),
        SoundFile::Bank(_) => (String::new(), None),
    };
    let part = part.ok_or_else(|| Failure::new(format_args!("{}: {NO_MODES}", path.display())))?;
    let plot = ModePlot { name: format!("{name}, {}", part.origin.material), first };
    let drawn = plot
        .draw(&part.model, part.origin.first_frequency, canvas.as_mut())
        .map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))?;
    write_atomically(output, &canvas.encode().map_err(Failure::new)?).map_err(Failure::new)?;
    let last = first + drawn - 1;
    console.say(format_args!("{}: modes {first} to {last} of {}", output.display(), part.model.modes.len()));
    console
        .json(&json!({ "picture": output, "first": first, "last": last, "modes": part.model.modes.len() }));
    Ok(())
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
    let mut canvas = canvas(output, field_plot::WIDTH, field_plot::HEIGHT)?;
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
    console.json(&json!({ "picture": output, "frequency_hz": plot.frequency, "max_frequency_hz": highest }));
    Ok(())
}
