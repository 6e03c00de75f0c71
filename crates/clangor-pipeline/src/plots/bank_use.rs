//! A picture of which ellipsoids of a bank stand for how many pieces, as \[FRAC\] Fig. 9.
//!
//! Normalised ellipsoids a ≤ b ≤ c are a triangle between disc, needle and ball. It is drawn in the
//! coordinates a/c and b/c: discs have (0, 1), needles (0, 0), balls (1, 1). What is thin is all near a/c =
//! 0, so that this axis goes with the logarithm.

use clangor_core::glam::DVec2;

use crate::plots::picture::{Align, BLACK, Canvas, Colour, GREY, TextStyle, circle, rectangle};
use crate::stages::fracture_report::{EllipsoidUse, PiecesRinging};

/// Width of a picture in pixels.
pub const WIDTH: usize = 1000;
/// Height of a picture in pixels.
pub const HEIGHT: usize = 620;

/// Least ratio of semi-axes that is drawn.
const THINNEST: f64 = 0.01;
/// Radius of the circle of one piece \[pixels\].
const RADIUS: f64 = 5.0;
/// Colours of the lightest and the heaviest pieces.
const LIGHT: [f64; 3] = [40.0, 80.0, 200.0];
const HEAVY: [f64; 3] = [210.0, 40.0, 30.0];

/// Draws how a bank was used; `bank` has the normalised semi-axes of all its ellipsoids.
pub fn draw(title: &str, ringing: &PiecesRinging, bank: &[[f64; 3]], canvas: &mut dyn Canvas) {
    let (corner, extent) = (DVec2::new(90.0, 90.0), DVec2::new(860.0, 440.0));
    let (right, bottom) = (corner.x + extent.x, corner.y + extent.y);
    let place = |[a, b, c]: [f64; 3]| {
        let across = (a / c).max(THINNEST).log10() / THINNEST.log10();
        DVec2::new(right - extent.x * across, bottom - extent.y * b / c)
    };
    canvas.text(DVec2::new(0.5 * WIDTH as f64, 22.0), Align::Middle, TextStyle::Title, title);
    let about = format!(
        "{} pieces as {} ellipsoids; areas go with their number, colour with the mean mass",
        ringing.proxy_pieces,
        ringing.ellipsoids.len()
    );
    canvas.text(DVec2::new(0.5 * WIDTH as f64, 50.0), Align::Middle, TextStyle::Label, &about);
    canvas.line(&rectangle(corner, extent), 1.0, BLACK);
    // Where a = b: nothing is below.
    let edge: Vec<DVec2> =
        (0..=60).map(|k| THINNEST.powf(f64::from(k) / 60.0)).map(|a| place([a, a, 1.0])).collect();
    canvas.line(&edge, 1.0, GREY);
    for (name, at, align, aside) in [
        ("discs", [THINNEST, 1.0, 1.0], Align::Left, DVec2::new(4.0, -10.0)),
        ("needles", [THINNEST, THINNEST, 1.0], Align::Left, DVec2::new(8.0, -12.0)),
        ("ball", [1.0, 1.0, 1.0], Align::Right, DVec2::new(0.0, -10.0)),
    ] {
        canvas.text(place(at) + aside, align, TextStyle::Label, name);
    }
    for ratio in [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0] {
        let x = place([ratio, 1.0, 1.0]).x;
        canvas.line(&[DVec2::new(x, bottom), DVec2::new(x, bottom + 5.0)], 1.0, BLACK);
        canvas.text(DVec2::new(x, bottom + 18.0), Align::Middle, TextStyle::Label, &ratio.to_string());
    }
    for ratio in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let y = place([THINNEST, ratio, 1.0]).y;
        canvas.line(&[DVec2::new(corner.x - 5.0, y), DVec2::new(corner.x, y)], 1.0, BLACK);
        canvas.text(DVec2::new(corner.x - 9.0, y), Align::Right, TextStyle::Label, &ratio.to_string());
    }
    let below = DVec2::new(corner.x + 0.5 * extent.x, bottom + 42.0);
    canvas.text(below, Align::Middle, TextStyle::Label, "a/c, thickness over length");
    canvas.text(DVec2::new(corner.x - 60.0, corner.y - 14.0), Align::Left, TextStyle::Label, "b/c");
    for axes in bank {
        canvas.line(&circle(place(*axes), 2.0), 1.0, BLACK);
    }
    let mean = |e: &EllipsoidUse| e.masses.iter().sum::<f64>() / e.masses.len().max(1) as f64;
    let masses = ringing.ellipsoids.iter().map(mean);
    let (lightest, heaviest) =
        masses.fold((f64::INFINITY, 0.0_f64), |(low, high), m| (low.min(m), high.max(m)));
    // The largest first, so that none is hidden.
    let mut ellipsoids: Vec<&EllipsoidUse> = ringing.ellipsoids.iter().collect();
    ellipsoids.sort_by_key(|e| std::cmp::Reverse(e.masses.len()));
    for ellipsoid in ellipsoids {
        let radius = RADIUS * (ellipsoid.masses.len() as f64).sqrt();
        let part = (mean(ellipsoid) / lightest).ln() / (heaviest / lightest).ln();
        let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
        let colour: Colour = std::array::from_fn(|k| (LIGHT[k] + part * (HEAVY[k] - LIGHT[k])).round() as u8);
        let centre = place(ellipsoid.semi_axes);
        // A line as wide as its circle fills it.
        canvas.line(&circle(centre, 0.5 * radius), radius, colour);
        if ellipsoid.masses.len() > 1 {
            let label = ellipsoid.masses.len().to_string();
            canvas.text(centre + DVec2::new(radius + 4.0, 0.0), Align::Left, TextStyle::Label, &label);
        }
    }
    if heaviest > 0.0 {
        let scale = format!("blue {:.2} g to red {:.2} g", 1e3 * lightest, 1e3 * heaviest);
        canvas.text(DVec2::new(right, bottom + 66.0), Align::Right, TextStyle::Label, &scale);
    }
    let hollow = "small circles: the ellipsoids of the bank";
    canvas.text(DVec2::new(corner.x, bottom + 66.0), Align::Left, TextStyle::Label, hollow);
}
