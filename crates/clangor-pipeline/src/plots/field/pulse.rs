//! The pressure in a plane through the body at some instants after a short push.
//!
//! The push is a Gaussian of time, a(t) = e^{−t²/(2T²)} × 1 m/s², as short as the model's band allows: T =
//! 3.5 R/(c κ_max), so that 0.2 % of its spectrum is beyond. With the field H(κ) at a point
//!
//! ```text
//! p(t) = (1/π) Re ∫₀^κmax H(κ) T √(2π) e^{−κ²T²/2} e^{iκt} dκ,    t in R/c
//! ```

use std::f64::consts::{PI, TAU};

use clangor_core::glam::{DVec2, DVec3};
use clangor_core::sound_model::files::model_file::ModelFile;
use num_complex::Complex64;
use rayon::prelude::*;

use super::{FieldPlot, PLANES, Plane, WIDTH, heading, three_digits};
use crate::plots::picture::{Align, BLACK, Canvas, Colour, Grid, TextStyle, rectangle};

/// Half the width of the region that is shown, over R.
const REACH: f64 = 4.0;
/// Instants after the middle of the push, in R/c.
const INSTANTS: [f64; 3] = [1.5, 2.75, 4.0];
/// Cells along an edge.
const CELLS: usize = 110;
/// Edge of a panel in pixels.
const EDGE: f64 = 320.0;
/// Top of the panels.
const TOP: f64 = 560.0;
/// Band of the model over the width of the push.
const BAND: f64 = 3.5;
/// Distance from one colour bar's tick to the next, as a fraction of the largest pressure; colours follow its
/// root.
const TICKS: [f64; 5] = [-1.0, -0.25, 0.0, 0.25, 1.0];

/// Draws the instants; false for silence.
pub(super) fn draw(plot: &FieldPlot, file: &ModelFile, canvas: &mut dyn Canvas) -> bool {
    let model = &file.acceleration;
    let plane = shown_plane(plot.degree);
    let width = BAND / model.field.max_wavenumber;
    let unit = plot.medium.density * model.radius;
    let cell = 2.0 * REACH / CELLS as f64;
    let place = |index: usize| {
        let (column, row) = ((index % CELLS) as f64, (index / CELLS) as f64);
        DVec2::new(-REACH + (column + 0.5) * cell, REACH - (row + 0.5) * cell)
    };
    let pressures: Vec<[f64; INSTANTS.len()]> = (0..CELLS * CELLS)
        .into_par_iter()
        .map(|index| {
            let x = plane.at(place(index));
            // The field of the multipoles ends at the bounding sphere.
            if x.length() < 1.0 {
                return [f64::NAN; INSTANTS.len()];
            }
            pressures_at(plot, file, x, width).map(|p| unit * p)
        })
        .collect();
    let largest = pressures.iter().flatten().fold(0.0f64, |m, p| if p.abs() > m { p.abs() } else { m });
    if largest == 0.0 {
        return false;
    }
    let microseconds = 1e6 * model.radius / plot.medium.sound_speed;
    heading(
        canvas,
        528.0,
        &format!(
            "Pressure around the body after a push of Gaussian shape, {} µs wide at half height, 1 m/s² at \
             its peak",
            three_digits(2.0 * (2.0 * 2f64.ln()).sqrt() * width * microseconds)
        ),
    );
    for (panel, instant) in INSTANTS.iter().enumerate() {
        let corner = DVec2::new(60.0 + 380.0 * panel as f64, TOP);
        let colours = pressures.iter().map(|p| match p[panel] {
            p if p.is_finite() => colour(p / largest),
            _ => INSIDE,
        });
        canvas.grid(corner, DVec2::splat(EDGE), &Grid { columns: CELLS, cells: colours.collect() });
        outline(canvas, file, &plane, corner);
        axes(canvas, &plane, corner);
        let title = format!("t = {} µs ({instant} R/c)", three_digits(instant * microseconds));
        let below = corner + DVec2::new(0.5 * EDGE, EDGE + 42.0);
        canvas.text(below, Align::Middle, TextStyle::Label, &title);
    }
    colour_bar(canvas, largest);
    true
}

/// p over ρ R at the instants, at `x` in units of R.
fn pressures_at(plot: &FieldPlot, file: &ModelFile, x: DVec3, width: f64) -> [f64; INSTANTS.len()] {
    let field = &file.acceleration.field;
    let values = field.at_nodes(&plot.motion(), x);
    // The sum over frequencies repeats itself after 2π/dκ, by when everything must be over.
    let lasting = 2.0 * REACH + field.ring_time + 10.0 * width;
    let count = ((field.max_wavenumber * lasting / TAU).ceil() as usize).max(48);
    let step = field.max_wavenumber / count as f64;
    let mut sums = [0.0; INSTANTS.len()];
    for k in 0..count {
        let wavenumber = step * (k as f64 + 0.5);
        let push = width * TAU.sqrt() * (-0.5 * (wavenumber * width).powi(2)).exp();
        let h = field.interpolate(Complex64::new(0.0, wavenumber), &values) * (push * step / PI);
        for (sum, instant) in sums.iter_mut().zip(INSTANTS) {
            *sum += (h * Complex64::cis(wavenumber * (instant - x.length()))).re;
        }
    }
    sums
}

/// The plane of a translation holds its axis; that of a rotation is across it.
fn shown_plane(degree: usize) -> Plane {
    match degree {
        0 | 1 | 5 => PLANES[0],
        2 | 3 => PLANES[1],
        _ => PLANES[2],
    }
}

/// Inside the bounding sphere.
const INSIDE: Colour = [232, 232, 225];

/// Red above, blue below, white at zero, by the root of the pressure over the largest.
fn colour(part: f64) -> Colour {
    let depth = part.abs().sqrt().min(1.0);
    let end: [f64; 3] = if part > 0.0 { [178.0, 24.0, 43.0] } else { [33.0, 80.0, 170.0] };
    end.map(|e| (255.0 + (e - 255.0) * depth).round() as u8)
}

/// The section of the body's surface, or of the sphere that it is.
fn outline(canvas: &mut dyn Canvas, file: &ModelFile, plane: &Plane, corner: DVec2) {
    let radius = file.acceleration.radius;
    let pixel = |x: DVec2| corner + EDGE * DVec2::new(0.5 + 0.5 * x.x / REACH, 0.5 - 0.5 * x.y / REACH);
    let Some(mesh) = &file.solid.surface else {
        canvas.line(&crate::plots::picture::circle(pixel(DVec2::ZERO), 0.5 * EDGE / REACH), 1.5, BLACK);
        return;
    };
    let normal = plane.right.cross(plane.up);
    for triangle in 0..mesh.triangles.len() {
        let corners = mesh.corners(triangle).map(|v| v / radius);
        let heights = corners.map(|v| v.dot(normal));
        let mut crossings = Vec::with_capacity(2);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if (heights[i] < 0.0) != (heights[j] < 0.0) {
                let x = corners[i] + (corners[j] - corners[i]) * (heights[i] / (heights[i] - heights[j]));
                crossings.push(pixel(DVec2::new(x.dot(plane.right), x.dot(plane.up))));
            }
        }
        canvas.line(&crossings, 1.5, BLACK);
    }
}

/// Frame, ticks in units of R and names of axes.
fn axes(canvas: &mut dyn Canvas, plane: &Plane, corner: DVec2) {
    canvas.line(&rectangle(corner, DVec2::splat(EDGE)), 1.0, BLACK);
    for tick in [-4, -2, 0, 2, 4] {
        let part = EDGE * (0.5 + 0.5 * f64::from(tick) / REACH);
        let below = corner + DVec2::new(part, EDGE);
        canvas.line(&[below, below + DVec2::new(0.0, 4.0)], 1.0, BLACK);
        canvas.text(below + DVec2::new(0.0, 13.0), Align::Middle, TextStyle::Label, &tick.to_string());
        let left = corner + DVec2::new(0.0, EDGE - part);
        canvas.line(&[left, left - DVec2::new(4.0, 0.0)], 1.0, BLACK);
        canvas.text(left - DVec2::new(7.0, 0.0), Align::Right, TextStyle::Label, &tick.to_string());
    }
    let [right, up] = plane.names;
    let below = corner + DVec2::new(0.875 * EDGE, EDGE + 13.0);
    canvas.text(below, Align::Middle, TextStyle::Label, &format!("{right}/R"));
    let left = corner + DVec2::new(-7.0, 0.125 * EDGE);
    canvas.text(left, Align::Right, TextStyle::Label, &format!("{up}/R"));
}

/// The bar of colours at the right, with pressures.
fn colour_bar(canvas: &mut dyn Canvas, largest: f64) {
    let (corner, size) = (DVec2::new(WIDTH as f64 - 112.0, TOP), DVec2::new(18.0, EDGE));
    const STEPS: usize = 200;
    let signed_square = |depth: f64| depth * depth.abs();
    let cells = (0..STEPS).map(|k| colour(signed_square(1.0 - 2.0 * (k as f64 + 0.5) / STEPS as f64)));
    canvas.grid(corner, size, &Grid { columns: 1, cells: cells.collect() });
    canvas.line(&rectangle(corner, size), 1.0, BLACK);
    for part in TICKS {
        let depth = part.signum() * f64::abs(part).sqrt();
        let place = corner + DVec2::new(size.x, size.y * 0.5 * (1.0 - depth));
        canvas.line(&[place, place + DVec2::new(4.0, 0.0)], 1.0, BLACK);
        let text = if part == 0.0 { "0".into() } else { three_digits(1e3 * part * largest) };
        canvas.text(place + DVec2::new(8.0, 0.0), Align::Left, TextStyle::Label, &text);
    }
    let above = corner + DVec2::new(0.5 * size.x, size.y + 18.0);
    canvas.text(above, Align::Middle, TextStyle::Label, "p [mPa]");
}
