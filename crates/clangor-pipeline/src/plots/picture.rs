//! Pictures of lines, text and coloured grids, as PNG or SVG.
//!
//! Coordinates are pixels from the top left corner. Text in a PNG is drawn from a font that is in the
//! program, so that no font of the system is needed; an SVG leaves the font to the viewer.

mod raster;
mod svg;

use clangor_core::glam::DVec2;

pub use raster::Raster;
pub use svg::Svg;

/// A colour: red, green and blue.
pub type Colour = [u8; 3];

/// Black.
pub const BLACK: Colour = [20, 20, 20];
/// For grids and what is in the background.
pub const GREY: Colour = [205, 205, 205];
/// White.
pub const WHITE: Colour = [255, 255, 255];

/// Which part of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Its left end.
    Left,
    /// Its middle.
    Middle,
    /// Its right end.
    Right,
}

/// Size and weight of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextStyle {
    /// What the picture shows.
    Title,
    /// All other text.
    Label,
}

/// A coloured grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Cells from left to right.
    pub columns: usize,
    /// Cells, row by row from the top.
    pub cells: Vec<Colour>,
}

impl Grid {
    /// Cells from top to bottom.
    pub fn rows(&self) -> usize {
        self.cells.len() / self.columns.max(1)
    }
}

/// What can be drawn on.
pub trait Canvas {
    /// A line through points, in pixels, of a width in pixels.
    fn line(&mut self, points: &[DVec2], width: f64, colour: Colour);

    /// A text whose middle height is at `place`.
    fn text(&mut self, place: DVec2, align: Align, style: TextStyle, text: &str);

    /// A coloured grid from its top left `corner`, stretched to `size`.
    fn grid(&mut self, corner: DVec2, size: DVec2, grid: &Grid);

    /// The file.
    ///
    /// # Errors
    /// What the encoder says.
    fn encode(&self) -> Result<Vec<u8>, PictureError>;
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The encoder failed.
    #[error("the picture cannot be encoded: {0}")]
    Encode(#[from] png::EncodingError),
}

/// A circle as a closed line.
pub fn circle(centre: DVec2, radius: f64) -> Vec<DVec2> {
    (0..=120)
        .map(|k| centre + radius * DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 120.0))
        .collect()
}

/// A rectangle as a closed line.
pub fn rectangle(corner: DVec2, size: DVec2) -> [DVec2; 5] {
    let (x, y) = (DVec2::new(size.x, 0.0), DVec2::new(0.0, size.y));
    [corner, corner + x, corner + size, corner + y, corner]
}
