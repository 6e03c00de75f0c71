//! A plot in a picture: frame, ticks and points.

use clangor_core::glam::DVec2;
use clangor_pipeline::plots::picture::{Align, BLACK, Canvas, Colour, GREY, TextStyle, circle, rectangle};

/// A plot in a picture.
pub struct Panel {
    /// Top left corner in pixels.
    pub corner: DVec2,
    /// Width and height in pixels.
    pub extent: DVec2,
    /// Values at the left and right edge.
    pub across: [f64; 2],
    /// Values at the bottom and top edge.
    pub up: [f64; 2],
}

impl Panel {
    /// Position of a point in the picture; coordinates are logarithms on logarithmic axes.
    pub fn place(&self, x: f64, y: f64) -> DVec2 {
        let part = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        self.corner + self.extent * DVec2::new(part(x, self.across), 1.0 - part(y, self.up))
    }

    /// The frame, with a title above it.
    pub fn frame(&self, title: &str, canvas: &mut dyn Canvas) {
        canvas.line(&rectangle(self.corner, self.extent), 1.0, BLACK);
        let above = self.corner + DVec2::new(0.5 * self.extent.x, -16.0);
        canvas.text(above, Align::Middle, TextStyle::Label, title);
    }

    /// A tick with its label below the frame.
    pub fn tick_below(&self, x: f64, label: &str, canvas: &mut dyn Canvas) {
        let at = self.place(x, self.up[0]);
        canvas.line(&[at, at + DVec2::new(0.0, 5.0)], 1.0, BLACK);
        canvas.text(at + DVec2::new(0.0, 18.0), Align::Middle, TextStyle::Label, label);
    }

    /// A line across with its label at the left of the frame.
    pub fn tick_left(&self, y: f64, label: &str, canvas: &mut dyn Canvas) {
        let at = self.place(self.across[0], y);
        canvas.line(&[at, self.place(self.across[1], y)], 0.5, GREY);
        canvas.text(at - DVec2::new(6.0, 0.0), Align::Right, TextStyle::Label, label);
    }

    /// A dot.
    pub fn dot(&self, x: f64, y: f64, colour: Colour, canvas: &mut dyn Canvas) {
        canvas.line(&circle(self.place(x, y), 2.0), 2.0, colour);
    }
}
