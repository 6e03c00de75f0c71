//! The interior of an axisymmetric body: its thickness, and points in it.
//!
//! The equation for the surface pressure has more than one solution where the interior resonates with p = 0
//! on its surface. The field of the spurious solutions does not vanish inside. Points inside, where it must
//! vanish, select the right solution (Schenck, J. Acoust. Soc. Am. 44, 1968). A few points may all lie on
//! nodes of a resonance. Many, scattered over every part thick enough to resonate, do not.

use std::f64::consts::FRAC_PI_2;

use clangor_core::geometry::meridian::Meridian;
use glam::DVec2;

/// Fraction of π/(2ρ) below which there are no resonances.
const RESONANCE_MARGIN: f64 = 0.9;

/// Samples on each piece of the meridian for the search of the largest ball.
const PARTS: usize = 96;
/// The same for meridians of many pieces: samples in all, and fewest on a piece. The search takes the square
/// of their number.
const MOST_PARTS: usize = 768;
const LEAST_PARTS: usize = 6;

/// Wavenumber [1/m] below which the interior has no resonance, for the largest inscribed radius \[m\].
pub(super) fn first_resonance(inscribed: f64) -> f64 {
    RESONANCE_MARGIN * FRAC_PI_2 / inscribed
}

/// Radius \[m\] of the largest inscribed ball that touches the surface at one of the sampled points.
pub(super) fn inscribed_radius(meridian: &Meridian) -> f64 {
    touching_balls(meridian).into_iter().map(|(_, _, radius)| radius).fold(0.0, f64::max)
}

/// Points (r, y) inside \[m\]: `count` of them from index `skip` of a low-discrepancy sequence, where the
/// body is thicker than a fraction of the thickness that resonates at `wavenumber` [1/m].
pub(super) fn inner_points(meridian: &Meridian, wavenumber: f64, skip: usize, count: usize) -> Vec<DVec2> {
    // The fractions of the golden ratio and of √2 never meet.
    const GOLDEN: f64 = 0.618_033_988_749_895;
    const SILVER: f64 = 0.414_213_562_373_095;
    let mut balls = touching_balls(meridian);
    balls.retain(|(_, _, radius)| wavenumber * radius > 1.0);
    if balls.is_empty() {
        return Vec::new();
    }
    (skip..skip + count)
        .map(|k| {
            let (point, normal, radius) = balls[((k as f64 * GOLDEN).fract() * balls.len() as f64) as usize];
            point - normal * (radius * (0.3 + 0.7 * (k as f64 * SILVER).fract()))
        })
        .filter(|p| p.x > 0.0)
        .collect()
}

/// Surface points, their outward normals, and the radii of the largest inscribed balls that touch there.
///
/// The ball that touches at x with outward normal n and passes through q has the radius |q − x|²/(2 n·(x −
/// q)).
fn touching_balls(meridian: &Meridian) -> Vec<(DVec2, DVec2, f64)> {
    let mut points: Vec<(DVec2, DVec2)> = Vec::new();
    let parts = (MOST_PARTS / meridian.pieces().len().max(1)).clamp(LEAST_PARTS, PARTS);
    for piece in meridian.pieces() {
        points.extend((0..parts).map(|k| {
            let t = (k as f64 + 0.5) / parts as f64;
            let v = piece.velocity(t).normalize();
            (piece.point(t), DVec2::new(v.y, -v.x))
        }));
    }
    let radius_at = |(x, n): (DVec2, DVec2)| {
        points
            .iter()
            .flat_map(|(q, _)| [*q, DVec2::new(-q.x, q.y)])
            .map(|q| (q - x, n.dot(x - q)))
            .filter(|(gap, depth)| *depth > 1e-9 * gap.length())
            .map(|(gap, depth)| 0.5 * gap.length_squared() / depth)
            .fold(f64::INFINITY, f64::min)
    };
    points.iter().map(|p| (p.0, p.1, radius_at(*p))).filter(|(_, _, radius)| radius.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_and_points_are_inside() {
        let egg = Meridian::spheroid(1.0, 2.0).expect("a spheroid");
        // The true radius is 1; residual seen: 1e-4, of the points between which the surface is.
        assert!((inscribed_radius(&egg) - 1.0).abs() < 1e-3);
        let points = inner_points(&egg, 5.0, 3, 100);
        assert!(points.len() > 80);
        assert!(points.iter().all(|p| p.x > 0.0 && p.x * p.x + 0.25 * p.y * p.y < 0.999));
        assert!(inner_points(&egg, 0.5, 0, 10).is_empty());
    }
}
