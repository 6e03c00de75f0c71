//! A picture of the spectrum of a sound, with lines where a body has modes.

use clangor_core::glam::DVec2;

use crate::analysis::spectrum::Spectrum;
use crate::plots::picture::{Align, BLACK, Canvas, Colour, GREY, TextStyle, rectangle};

/// Width of a picture in pixels.
pub const WIDTH: usize = 1280;
/// Height of a picture in pixels.
pub const HEIGHT: usize = 480;

/// The lowest level that is drawn, against the highest \[dB\].
pub const DEPTH: f64 = 80.0;
/// Lines of modes, and the curve over them.
const MODE: Colour = [235, 150, 120];
const CURVE: Colour = [30, 70, 190];

/// What to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumPlot<'a> {
    /// What the picture is called.
    pub title: String,
    /// Where it ends \[Hz\].
    pub max_frequency: f64,
    /// Frequencies of modes \[Hz\].
    pub modes: &'a [f64],
}

impl SpectrumPlot<'_> {
    /// Draws a spectrum.
    pub fn draw(&self, spectrum: &Spectrum, canvas: &mut dyn Canvas) {
        let (corner, extent) = (DVec2::new(80.0, 66.0), DVec2::new(1160.0, 340.0));
        let (right, bottom) = (corner.x + extent.x, corner.y + extent.y);
        let across = |f: f64| corner.x + extent.x * f / self.max_frequency;
        let height = |level: f64| corner.y + extent.y * (-level / DEPTH).clamp(0.0, 1.0);
        canvas.text(DVec2::new(0.5 * WIDTH as f64, 22.0), Align::Middle, TextStyle::Title, &self.title);
        let below = DVec2::new(corner.x + 0.5 * extent.x, bottom + 40.0);
        canvas.text(below, Align::Middle, TextStyle::Label, "frequency [Hz]");
        canvas.text(DVec2::new(corner.x - 8.0, 48.0), Align::Middle, TextStyle::Label, "level [dB]");
        for below in (0..=DEPTH as i32).step_by(20) {
            let y = height(-f64::from(below));
            canvas.line(&[DVec2::new(corner.x, y), DVec2::new(right, y)], 1.0, GREY);
            canvas.text(DVec2::new(corner.x - 6.0, y), Align::Right, TextStyle::Label, &(-below).to_string());
        }
        let step = tick(self.max_frequency);
        for f in (0..).map(|k| step * f64::from(k)).take_while(|f| *f <= self.max_frequency * (1.0 + 1e-9)) {
            let x = across(f);
            canvas.line(&[DVec2::new(x, bottom), DVec2::new(x, bottom + 5.0)], 1.0, BLACK);
            canvas.text(DVec2::new(x, bottom + 18.0), Align::Middle, TextStyle::Label, &format!("{f:.0}"));
        }
        for f in self.modes.iter().filter(|f| **f <= self.max_frequency) {
            let x = across(*f);
            canvas.line(&[DVec2::new(x, corner.y), DVec2::new(x, bottom)], 1.5, MODE);
        }
        canvas.line(&self.curve(spectrum, extent.x as usize, &across, &height), 1.2, CURVE);
        canvas.line(&rectangle(corner, extent), 1.0, BLACK);
        if !self.modes.is_empty() {
            let place = DVec2::new(right, 48.0);
            canvas.text(place, Align::Right, TextStyle::Label, "vertical lines: frequencies of the modes");
        }
    }

    /// The highest level in each column of the picture.
    fn curve(
        &self,
        spectrum: &Spectrum,
        columns: usize,
        across: &dyn Fn(f64) -> f64,
        height: &dyn Fn(f64) -> f64,
    ) -> Vec<DVec2> {
        let shown = spectrum.up_to(self.max_frequency);
        let highest = shown.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let together = shown.len().div_ceil(columns).max(1);
        let highest_of = |(k, chunk): (usize, &[f64])| {
            let at = (0..chunk.len()).max_by(|a, b| chunk[*a].total_cmp(&chunk[*b])).unwrap_or(0);
            let level = 20.0 * (chunk[at] / highest).max(f64::MIN_POSITIVE).log10();
            DVec2::new(across(spectrum.step * (k * together + at) as f64), height(level))
        };
        shown.chunks(together).enumerate().map(highest_of).collect()
    }
}

/// A step of 1, 2 or 5 times a power of ten, of which some ten make a length.
pub(crate) fn tick(length: f64) -> f64 {
    let decade = 10.0_f64.powf((length / 10.0).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|s| s * decade);
    steps.into_iter().find(|step| length / step <= 12.0).unwrap_or(length)
}
