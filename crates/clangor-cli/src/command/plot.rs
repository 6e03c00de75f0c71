//! `clangor plot`: pictures.

use std::path::Path;

use clangor::medium::Medium;
use clangor_pipeline::atomic_file::write_atomically;
use clangor_pipeline::field_plot::{FieldPlot, HEIGHT, WIDTH};
use clangor_pipeline::picture::{Canvas, Raster, Svg};
use clangor_pipeline::sound_models::read_model;
use serde_json::json;

use crate::arguments::{Degree, Picture, Plot};
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn run(options: &Plot, console: &Console) -> Result<(), Failure> {
    match &options.picture {
        Picture::Field { model, output, degree, frequency } => {
            field(model, output, *degree, *frequency, console)
        }
    }
}

/// How a model radiates.
fn field(
    path: &Path,
    output: &Path,
    degree: Degree,
    frequency: Option<f64>,
    console: &Console,
) -> Result<(), Failure> {
    let mut canvas: Box<dyn Canvas> = match output.extension().and_then(|e| e.to_str()) {
        Some("png") => Box::new(Raster::new(WIDTH, HEIGHT)),
        Some("svg") => Box::new(Svg::new(WIDTH, HEIGHT)),
        _ => return Err(Failure::new("the output must end in .png or .svg")),
    };
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
