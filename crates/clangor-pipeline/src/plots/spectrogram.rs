//! A picture of a spectrogram, with the births and deaths of bodies above it.

use clangor_core::glam::DVec2;
use clangor_core::timeline::FractureRow;

use crate::analysis::spectrogram::Spectrogram;
use crate::plots::picture::{Align, BLACK, Canvas, Colour, GREY, Grid, TextStyle, rectangle};
use crate::plots::spectrum::tick;

/// Width of a picture in pixels.
pub const WIDTH: usize = 1280;
/// Height of a picture in pixels.
pub const HEIGHT: usize = 600;
/// Instants that are drawn, one for each pixel.
pub const COLUMNS: usize = 1160;
/// The lowest level that is drawn, against the highest \[dB\].
pub const DEPTH: f64 = 80.0;

/// Heights of the strips of deaths and births, and of the spectrogram \[pixels\].
const STRIP: f64 = 30.0;
const EXTENT: f64 = 380.0;
const DEATH: Colour = [200, 30, 30];
const BIRTH: Colour = [20, 120, 60];
/// From the lowest level to the highest.
const SCALE: [[f64; 3]; 6] = [
    [0.0, 0.0, 8.0],
    [50.0, 12.0, 90.0],
    [135.0, 33.0, 108.0],
    [214.0, 70.0, 68.0],
    [251.0, 158.0, 30.0],
    [252.0, 255.0, 200.0],
];

/// What to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrogramPlot<'a> {
    /// What the picture is called.
    pub title: String,
    /// Beginning and end of the sound \[s\].
    pub time: [f64; 2],
    /// Where it ends \[Hz\].
    pub max_frequency: f64,
    /// When bodies broke; `None` if that is not known.
    pub fractures: Option<&'a [FractureRow]>,
}

impl SpectrogramPlot<'_> {
    /// Draws a spectrogram.
    pub fn draw(&self, spectrogram: &Spectrogram, canvas: &mut dyn Canvas) {
        let (corner, extent) = (DVec2::new(80.0, 130.0), DVec2::new(COLUMNS as f64, EXTENT));
        let (right, bottom) = (corner.x + extent.x, corner.y + extent.y);
        let [begin, end] = self.time;
        let across = |t: f64| corner.x + extent.x * (t - begin) / (end - begin);
        canvas.text(DVec2::new(0.5 * WIDTH as f64, 22.0), Align::Middle, TextStyle::Title, &self.title);
        canvas.grid(corner, extent, &self.grid(spectrogram));
        canvas.line(&rectangle(corner, extent), 1.0, BLACK);
        let below = DVec2::new(corner.x + 0.5 * extent.x, bottom + 40.0);
        canvas.text(below, Align::Middle, TextStyle::Label, "time [s]");
        canvas.text(DVec2::new(4.0, corner.y - 16.0), Align::Left, TextStyle::Label, "[kHz]");
        for t in ticks(begin, end) {
            let x = across(t);
            canvas.line(&[DVec2::new(x, bottom), DVec2::new(x, bottom + 5.0)], 1.0, BLACK);
            canvas.text(DVec2::new(x, bottom + 18.0), Align::Middle, TextStyle::Label, &short(t));
        }
        for f in ticks(0.0, self.max_frequency) {
            let y = bottom - extent.y * f / self.max_frequency;
            canvas.line(&[DVec2::new(corner.x - 5.0, y), DVec2::new(corner.x, y)], 1.0, BLACK);
            let label = short(1e-3 * f);
            canvas.text(DVec2::new(corner.x - 9.0, y), Align::Right, TextStyle::Label, &label);
        }
        scale(DVec2::new(corner.x, bottom + 62.0), canvas);
        if self.fractures.is_some() {
            marks(
                &self.shown(),
                DVec2::new(corner.x, corner.y - 2.0 * STRIP - 6.0),
                extent.x,
                &across,
                canvas,
            );
        }
        let about = format!("levels down to {DEPTH:.0} dB below the highest");
        canvas.text(DVec2::new(right, bottom + 70.0), Align::Right, TextStyle::Label, &about);
    }

    /// The fractures within the picture.
    pub fn shown(&self) -> Vec<&FractureRow> {
        let [begin, end] = self.time;
        self.fractures.into_iter().flatten().filter(|row| (begin..=end).contains(&row.time)).collect()
    }

    /// Colours of all pixels: the highest power that a pixel covers.
    fn grid(&self, spectrogram: &Spectrogram) -> Grid {
        let highest = spectrogram.highest().max(f64::MIN_POSITIVE);
        let (columns, rows) = (spectrogram.columns(), EXTENT as usize);
        let bin = |f: f64| (f / spectrogram.step).round().max(0.0) as usize;
        let mut cells = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            let [low, high] =
                [rows - row - 1, rows - row].map(|edge| bin(self.max_frequency * edge as f64 / rows as f64));
            for column in 0..columns {
                let powers = spectrogram.column(column);
                let last = powers.len() - 1;
                let covered = &powers[low.min(last)..=high.clamp(low, low.max(last)).min(last)];
                let power = covered.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
                cells.push(colour(1.0 + 10.0 * (power / highest).log10() / DEPTH));
            }
        }
        Grid { columns, cells }
    }
}

/// A strip of deaths and one of births, whose ticks are as long as there are many pieces.
fn marks(
    fractures: &[&FractureRow],
    corner: DVec2,
    width: f64,
    across: &dyn Fn(f64) -> f64,
    canvas: &mut dyn Canvas,
) {
    let births: u32 = fractures.iter().map(|row| row.children).sum();
    let most = fractures.iter().map(|row| row.children).max().unwrap_or(0);
    let middle = corner.y + STRIP + 1.0;
    let line = |y: f64| [DVec2::new(corner.x, y), DVec2::new(corner.x + width, y)];
    canvas.line(&line(middle), 1.0, GREY);
    for row in fractures {
        let x = across(row.time);
        let length = STRIP * f64::from(row.children).ln_1p() / f64::from(most).ln_1p();
        let cross = DVec2::new(x, middle - 0.5 * STRIP);
        for arm in [DVec2::new(4.0, 4.0), DVec2::new(4.0, -4.0)] {
            canvas.line(&[cross - arm, cross + arm], 1.5, DEATH);
        }
        canvas.line(&[DVec2::new(x, middle), DVec2::new(x, middle + length)], 1.5, BIRTH);
    }
    let legend = format!(
        "× death of a body ({}); | birth of its pieces ({births}): the longer, the more, at most {most}",
        fractures.len()
    );
    canvas.text(DVec2::new(corner.x, corner.y - 14.0), Align::Left, TextStyle::Label, &legend);
}

/// What colours mean.
fn scale(corner: DVec2, canvas: &mut dyn Canvas) {
    let cells: Vec<Colour> = (0..120).map(|k| colour(f64::from(k) / 119.0)).collect();
    canvas.grid(corner, DVec2::new(240.0, 14.0), &Grid { columns: cells.len(), cells });
    let beside = corner + DVec2::new(250.0, 7.0);
    canvas.text(beside, Align::Left, TextStyle::Label, "quiet to loud");
}

/// The colour of a part of the scale.
fn colour(part: f64) -> Colour {
    let place = part.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let from = (place as usize).min(SCALE.len() - 2);
    let part = place - from as f64;
    std::array::from_fn(|k| (SCALE[from][k] + part * (SCALE[from + 1][k] - SCALE[from][k])).round() as u8)
}

/// Round numbers between two.
fn ticks(begin: f64, end: f64) -> Vec<f64> {
    let step = tick(end - begin);
    let first = (begin / step - 1e-9).ceil() as i64;
    (first..).map(|k| k as f64 * step).take_while(|t| *t <= end + 1e-9 * step).collect()
}

/// A number without the zeros at its end.
fn short(number: f64) -> String {
    format!("{number:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
}
