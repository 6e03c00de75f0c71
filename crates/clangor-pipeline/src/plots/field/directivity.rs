//! Polar plots of |p| r in decibels, far away and close to the body.

use std::f64::consts::TAU;

use clangor_core::glam::DVec2;
use clangor_core::sound_model::acceleration::model::AccelerationModel;

use super::{FieldPlot, PLANES, Plane, WIDTH, heading, three_digits};
use crate::plots::picture::{Align, BLACK, Canvas, Colour, GREY, TextStyle, circle};

/// Distances over R, with their colours; the first is far away and sets the scale.
const DISTANCES: [(f64, Colour, &str); 2] =
    [(100.0, [31, 90, 180], "far away (100 R)"), (1.5, [215, 110, 20], "close (1.5 R)")];
/// Least level \[dB\].
const FLOOR: f64 = -40.0;
/// Directions in a plane.
const DIRECTIONS: usize = 360;
/// Radius of a plot in pixels.
const RADIUS: f64 = 150.0;
/// Height of the middle of the plots.
const MIDDLE: f64 = 300.0;

/// Draws the three planes; false for silence.
pub(super) fn draw(plot: &FieldPlot, model: &AccelerationModel, canvas: &mut dyn Canvas) -> bool {
    let wavenumber = TAU * plot.frequency * model.radius / plot.medium.sound_speed;
    // |p| r at 1 m/s² in each direction of a plane at a distance over R.
    let levels = |plane: &Plane, distance: f64| -> Vec<f64> {
        (0..=DIRECTIONS)
            .map(|k| {
                let direction = plane.at(DVec2::from_angle(TAU * k as f64 / DIRECTIONS as f64));
                let p = model.field.pressure(&plot.motion(), direction * distance, wavenumber);
                p.norm() * plot.medium.density * model.radius * distance * model.radius
            })
            .collect()
    };
    let curves = PLANES.map(|plane| DISTANCES.map(|(distance, _, _)| levels(&plane, distance)));
    let loudest = curves.iter().flat_map(|c| &c[0]).fold(0.0, |m: f64, p| m.max(*p));
    if !(loudest > 0.0 && loudest.is_finite()) {
        return false;
    }
    heading(
        canvas,
        84.0,
        &format!(
            "Directivity at {:.0} Hz (kR = {:.2}): level of |p| r, 0 dB = {} Pa m for 1 m/s²",
            plot.frequency,
            wavenumber,
            three_digits(loudest)
        ),
    );
    for (index, plane) in PLANES.iter().enumerate() {
        let centre = DVec2::new(WIDTH as f64 * (index as f64 + 0.5) / 3.0, MIDDLE);
        // Close to the body it may be louder than the scale goes.
        axes(canvas, centre);
        for ((_, colour, _), curve) in DISTANCES.iter().zip(&curves[index]) {
            let place = |(k, p): (usize, &f64)| {
                let level = 20.0 * (p / loudest).max(1e-30).log10();
                let radius = RADIUS * ((level - FLOOR) / -FLOOR).clamp(0.0, 1.2);
                let direction = DVec2::from_angle(TAU * k as f64 / DIRECTIONS as f64);
                centre + radius * DVec2::new(direction.x, -direction.y)
            };
            let points: Vec<DVec2> = curve.iter().enumerate().map(place).collect();
            canvas.line(&points, 2.0, *colour);
        }
        labels(canvas, plane, centre);
    }
    for (index, (_, colour, name)) in DISTANCES.iter().enumerate() {
        let left = DVec2::new(420.0 + 260.0 * index as f64, MIDDLE + RADIUS + 44.0);
        canvas.line(&[left, left + DVec2::new(34.0, 0.0)], 3.0, *colour);
        canvas.text(left + DVec2::new(42.0, 0.0), Align::Left, TextStyle::Label, name);
    }
    true
}

/// Rings every 10 dB, and spokes.
fn axes(canvas: &mut dyn Canvas, centre: DVec2) {
    for ring in 1..=4 {
        canvas.line(&circle(centre, RADIUS * f64::from(ring) / 4.0), 1.0, GREY);
    }
    for spoke in 0..12 {
        let direction = DVec2::from_angle(TAU * f64::from(spoke) / 12.0);
        canvas.line(&[centre, centre + RADIUS * direction], 1.0, GREY);
    }
    canvas.line(&circle(centre, RADIUS), 1.0, BLACK);
}

/// Levels of the rings and names of the axes.
fn labels(canvas: &mut dyn Canvas, plane: &Plane, centre: DVec2) {
    for ring in 1..=4 {
        let level = FLOOR + 10.0 * f64::from(ring);
        let place = centre + RADIUS * f64::from(ring) / 4.0 * DVec2::from_angle(-0.35 * TAU / 2.0);
        canvas.text(place, Align::Middle, TextStyle::Label, &format!("{level:.0}"));
    }
    let [right, up] = plane.names;
    canvas.text(centre + DVec2::new(RADIUS + 18.0, 0.0), Align::Middle, TextStyle::Label, right);
    canvas.text(centre - DVec2::new(0.0, RADIUS + 14.0), Align::Middle, TextStyle::Label, up);
    let below = centre + DVec2::new(0.0, RADIUS + 18.0);
    canvas.text(below, Align::Middle, TextStyle::Label, &format!("{right}-{up} plane, dB"));
}
