//! A picture of how a sound model radiates: the directivity in three planes, and the pressure around the body
//! at some instants after a short push.

mod directivity;
mod pulse;

use clangor_core::glam::{DVec2, DVec3};
use clangor_core::medium::Medium;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use clangor_core::sound_model::files::model_file::ModelFile;

use crate::plots::picture::{Align, BLACK, Canvas, TextStyle};

/// Width of a picture in pixels.
pub const WIDTH: usize = 1280;
/// Height of a picture in pixels.
pub const HEIGHT: usize = 960;

/// What to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPlot {
    /// Which motion: 0–2 translation along x, y, z, 3–5 rotation about x, y, z.
    pub degree: usize,
    /// Frequency of the directivity \[Hz\].
    pub frequency: f64,
    /// What carries the sound.
    pub medium: Medium,
}

/// Why a picture cannot be drawn.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlotError {
    /// A frequency that the model does not know.
    #[error("the model is known to {highest:.0} Hz, and {frequency} Hz is beyond")]
    BeyondBand {
        /// Frequency asked for \[Hz\].
        frequency: f64,
        /// Highest of the model \[Hz\].
        highest: f64,
    },
    /// A motion that makes no sound.
    #[error("{name} makes no sound: the body is too symmetric")]
    Silent {
        /// The motion.
        name: &'static str,
    },
}

/// Names of the motions.
const MOTIONS: [&str; RIGID_DOFS] = [
    "translation along x",
    "translation along y",
    "translation along z",
    "rotation about x",
    "rotation about y",
    "rotation about z",
];

/// A plane through the centre of mass: the axes to the right and upwards, and their names.
#[derive(Clone, Copy)]
struct Plane {
    right: DVec3,
    up: DVec3,
    names: [&'static str; 2],
}

const PLANES: [Plane; 3] = [
    Plane { right: DVec3::X, up: DVec3::Y, names: ["x", "y"] },
    Plane { right: DVec3::Z, up: DVec3::Y, names: ["z", "y"] },
    Plane { right: DVec3::X, up: DVec3::Z, names: ["x", "z"] },
];

impl Plane {
    /// A point of the plane.
    fn at(&self, place: DVec2) -> DVec3 {
        self.right * place.x + self.up * place.y
    }
}

impl FieldPlot {
    /// Draws a model.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self, file: &ModelFile, canvas: &mut dyn Canvas) -> Result<(), PlotError> {
        let model = &file.acceleration;
        let highest = model.max_frequency(self.medium.sound_speed);
        // The rounding of a frequency that was printed and typed again.
        if !(self.frequency > 0.0 && self.frequency <= highest * (1.0 + 1e-6)) {
            return Err(PlotError::BeyondBand { frequency: self.frequency, highest });
        }
        let motion = MOTIONS[self.degree];
        let title = format!("Acceleration noise of {}: {motion}", file.solid.name);
        canvas.text(DVec2::new(0.5 * WIDTH as f64, 24.0), Align::Middle, TextStyle::Title, &title);
        let about = format!(
            "bounding radius R = {} mm, field known to {:.0} Hz (kR = {:.2}); the rotation has R times its \
             angular acceleration = 1 m/s²",
            three_digits(model.radius * 1e3),
            highest,
            model.field.max_wavenumber
        );
        let about = match self.degree {
            0..3 => about.split(';').next().unwrap_or_default(),
            _ => &about,
        };
        canvas.text(DVec2::new(0.5 * WIDTH as f64, 50.0), Align::Middle, TextStyle::Label, about);
        let drawn = directivity::draw(self, model, canvas) && pulse::draw(self, file, canvas);
        if drawn { Ok(()) } else { Err(PlotError::Silent { name: motion }) }
    }

    /// The motion at 1 m/s².
    fn motion(&self) -> [f64; RIGID_DOFS] {
        std::array::from_fn(|i| if i == self.degree { 1.0 } else { 0.0 })
    }
}

/// A heading over a row of pictures.
fn heading(canvas: &mut dyn Canvas, y: f64, text: &str) {
    canvas.text(DVec2::new(0.5 * WIDTH as f64, y), Align::Middle, TextStyle::Label, text);
    canvas.line(&[DVec2::new(40.0, y + 14.0), DVec2::new(WIDTH as f64 - 40.0, y + 14.0)], 0.7, BLACK);
}

/// A number with three significant digits.
fn three_digits(number: f64) -> String {
    let decade = number.abs().log10().floor();
    if (-3.0..5.0).contains(&decade) {
        format!("{number:.*}", (2.0 - decade).max(0.0) as usize)
    } else {
        format!("{number:.2e}")
    }
}
