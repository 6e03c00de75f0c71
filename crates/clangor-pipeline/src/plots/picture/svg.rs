//! A picture as SVG text.

use clangor_core::glam::DVec2;

use super::{Align, Canvas, Colour, Grid, PictureError, Raster, TextStyle};

/// An SVG that is drawn on.
#[derive(Clone, Debug, PartialEq)]
pub struct Svg {
    width: usize,
    height: usize,
    elements: Vec<Element>,
}

/// What was drawn.
#[derive(Clone, Debug, PartialEq)]
enum Element {
    Text(String),
    Grid { corner: DVec2, size: DVec2, grid: Grid },
}

impl Svg {
    /// A white picture.
    pub fn new(width: usize, height: usize) -> Self {
        Svg { width, height, elements: Vec::new() }
    }
}

impl Canvas for Svg {
    fn line(&mut self, points: &[DVec2], width: f64, colour: Colour) {
        let place = |p: &DVec2| format!("{:.2},{:.2}", p.x, p.y);
        let places: Vec<String> = points.iter().filter(|p| p.is_finite()).map(place).collect();
        let [r, g, b] = colour;
        self.elements.push(Element::Text(format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"rgb({r},{g},{b})\" stroke-width=\"{width}\"/>",
            places.join(" ")
        )));
    }

    fn text(&mut self, place: DVec2, align: Align, style: TextStyle, text: &str) {
        let anchor = match align {
            Align::Left => "start",
            Align::Middle => "middle",
            Align::Right => "end",
        };
        let (size, weight) = match style {
            TextStyle::Title => (17, "bold"),
            TextStyle::Label => (13, "normal"),
        };
        let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        self.elements.push(Element::Text(format!(
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" dominant-baseline=\"central\" \
             font-size=\"{size}\" font-weight=\"{weight}\">{text}</text>",
            place.x, place.y
        )));
    }

    fn grid(&mut self, corner: DVec2, size: DVec2, grid: &Grid) {
        self.elements.push(Element::Grid { corner, size, grid: grid.clone() });
    }

    fn encode(&self) -> Result<Vec<u8>, PictureError> {
        let (width, height) = (self.width, self.height);
        let mut lines = vec![
            format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
                 viewBox=\"0 0 {width} {height}\" font-family=\"monospace\" fill=\"rgb(20,20,20)\">"
            ),
            format!("<rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>"),
        ];
        for element in &self.elements {
            lines.push(match element {
                Element::Text(text) => text.clone(),
                Element::Grid { corner, size, grid } => {
                    let mut cells = Raster::new(grid.columns, grid.rows());
                    cells.grid(DVec2::ZERO, DVec2::new(grid.columns as f64, grid.rows() as f64), grid);
                    format!(
                        "<image x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" \
                         preserveAspectRatio=\"none\" \
                         style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>",
                        corner.x,
                        corner.y,
                        size.x,
                        size.y,
                        base64(&cells.encode()?)
                    )
                }
            });
        }
        lines.push("</svg>\n".into());
        Ok(lines.join("\n").into_bytes())
    }
}

/// Base64 of RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let bits = three.iter().fold(0u32, |sum, b| sum << 8 | u32::from(*b)) << (8 * (3 - three.len()));
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k)) as usize & 63];
            out.push(if k <= three.len() { char::from(letter) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_follows_its_standard() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in cases {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn text_is_escaped_and_grids_are_inside() {
        let mut picture = Svg::new(100, 50);
        picture.text(DVec2::new(10.0, 10.0), Align::Left, TextStyle::Label, "a < b & c");
        picture.grid(DVec2::ZERO, DVec2::splat(20.0), &Grid { columns: 1, cells: vec![[1, 2, 3]] });
        let text = String::from_utf8(picture.encode().unwrap()).unwrap();
        assert!(text.contains("a &lt; b &amp; c") && text.matches("<image").count() == 1, "{text}");
    }
}
