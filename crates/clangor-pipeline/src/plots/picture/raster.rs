//! A picture of pixels, encoded as PNG.

use clangor_core::glam::DVec2;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::{Align, Canvas, Colour, Grid, PictureError, TextStyle, WHITE};

/// Pixels that are drawn on.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    width: usize,
    height: usize,
    pixels: Vec<Colour>,
}

impl Raster {
    /// A white picture.
    pub fn new(width: usize, height: usize) -> Self {
        Raster { width, height, pixels: vec![WHITE; width * height] }
    }

    /// Mixes a colour into a pixel; outside the picture nothing happens.
    fn blend(&mut self, x: i64, y: i64, colour: Colour, part: f64) {
        if (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y) {
            let pixel = &mut self.pixels[y as usize * self.width + x as usize];
            for (old, new) in pixel.iter_mut().zip(colour) {
                *old = (f64::from(*old) + part * (f64::from(new) - f64::from(*old))).round() as u8;
            }
        }
    }

    /// Pixels of one axis that a stretch of it touches.
    fn touched(from: f64, to: f64, length: usize) -> std::ops::Range<i64> {
        let clamp = |x: f64| x.clamp(0.0, length as f64) as i64;
        clamp(from.floor())..clamp(to.ceil())
    }
}

impl Canvas for Raster {
    fn line(&mut self, points: &[DVec2], width: f64, colour: Colour) {
        let reach = 0.5 * width + 0.5;
        for pair in points.windows(2).filter(|p| p[0].is_finite() && p[1].is_finite()) {
            let (start, along) = (pair[0], pair[1] - pair[0]);
            let (low, high) = (pair[0].min(pair[1]) - reach, pair[0].max(pair[1]) + reach);
            for y in Raster::touched(low.y, high.y, self.height) {
                for x in Raster::touched(low.x, high.x, self.width) {
                    let from = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - start;
                    let t = (from.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                    let covered = (reach - (from - t * along).length()).clamp(0.0, 1.0);
                    if covered > 0.0 {
                        self.blend(x, y, colour, covered);
                    }
                }
            }
        }
    }

    fn text(&mut self, place: DVec2, align: Align, style: TextStyle, text: &str) {
        let (weight, height) = match style {
            TextStyle::Title => (FontWeight::Bold, RasterHeight::Size20),
            TextStyle::Label => (FontWeight::Regular, RasterHeight::Size16),
        };
        let step = get_raster_width(weight, height);
        let length = (step * text.chars().count()) as f64;
        let left = match align {
            Align::Left => place.x,
            Align::Middle => place.x - 0.5 * length,
            Align::Right => place.x - length,
        };
        let top = (place.y - 0.5 * height.val() as f64).round() as i64;
        for (index, letter) in text.chars().enumerate() {
            let known = get_raster(letter, weight, height).or_else(|| get_raster('?', weight, height));
            let Some(raster) = known else { continue };
            let start = left.round() as i64 + (index * step) as i64;
            for (row, line) in raster.rows().enumerate() {
                for (column, ink) in line.iter().enumerate().filter(|(_, ink)| **ink > 0) {
                    let at = (start + column as i64, top + row as i64);
                    self.blend(at.0, at.1, super::BLACK, f64::from(*ink) / 255.0);
                }
            }
        }
    }

    fn grid(&mut self, corner: DVec2, size: DVec2, grid: &Grid) {
        let (columns, rows) = (grid.columns, grid.rows());
        for y in Raster::touched(corner.y, corner.y + size.y, self.height) {
            for x in Raster::touched(corner.x, corner.x + size.x, self.width) {
                let at = (DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - corner) / size;
                if at.min_element() >= 0.0 && at.max_element() < 1.0 {
                    let cell = (at.y * rows as f64) as usize * columns + (at.x * columns as f64) as usize;
                    self.blend(x, y, grid.cells[cell], 1.0);
                }
            }
        }
    }

    fn encode(&self) -> Result<Vec<u8>, PictureError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_grids_colour_what_they_cover() {
        let mut picture = Raster::new(40, 20);
        picture.line(&[DVec2::new(0.0, 10.5), DVec2::new(40.0, 10.5)], 1.0, [0, 0, 0]);
        assert_eq!(picture.pixels[10 * 40 + 20], [0, 0, 0]);
        assert_eq!(picture.pixels[12 * 40 + 20], WHITE);
        let grid = Grid { columns: 2, cells: vec![[1, 2, 3], [4, 5, 6]] };
        picture.grid(DVec2::ZERO, DVec2::new(10.0, 4.0), &grid);
        assert_eq!((picture.pixels[4], picture.pixels[5]), ([1, 2, 3], [4, 5, 6]));
        assert_eq!(picture.pixels[10], WHITE);
        // Far outside, and without length: nothing, and no panic.
        picture.line(&[DVec2::splat(1e9), DVec2::splat(-1e9)], 2.0, [0, 0, 0]);
        picture.line(&[DVec2::ZERO, DVec2::ZERO, DVec2::NAN], 2.0, [0, 0, 0]);
        picture.text(DVec2::new(39.0, 19.0), Align::Left, TextStyle::Title, "κ°²");
        assert!(picture.encode().unwrap().starts_with(b"\x89PNG"));
    }
}
