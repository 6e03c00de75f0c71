//! Rayleigh's integral over a plane whose motion depends only on the distance from one point:
//!
//! ```text
//! p(x, t) = ρ/2π ∫ a(r, t − |x−y|/c) / |x−y| dS,   r = |y|
//! ```
//!
//! A direct sum over the surface, for checks: [`direction`](super::direction) computes the pressure of the
//! ground.

use std::f64::consts::{PI, TAU};

use crate::medium::Medium;

/// Resolution of the sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceGrid {
    /// Radius up to which the plane moves \[m\].
    pub radius: f64,
    /// Number of rings.
    pub rings: usize,
    /// Points on one half of each ring.
    pub points: usize,
}

/// The pressure \[Pa\] at height `above` \[m\], `across` \[m\] from the axis, at a time \[s\], over a plane
/// of normal acceleration `acceleration(r, t)` [m/s²]; by the midpoint rule, r = radius × s² to gather points
/// at the centre.
pub fn rayleigh_integral(
    medium: &Medium,
    (across, above): (f64, f64),
    time: f64,
    grid: &SurfaceGrid,
    acceleration: &dyn Fn(f64, f64) -> f64,
) -> f64 {
    let mut sum = 0.0;
    for ring in 0..grid.rings {
        let s = (ring as f64 + 0.5) / grid.rings as f64;
        let r = grid.radius * s * s;
        let width = 2.0 * grid.radius * s / grid.rings as f64;
        for point in 0..grid.points {
            let angle = PI * (point as f64 + 0.5) / grid.points as f64;
            let square = across * across + r * r - 2.0 * across * r * angle.cos() + above * above;
            let distance = square.sqrt();
            sum += acceleration(r, time - distance / medium.sound_speed) / distance * r * width;
        }
    }
    medium.density / TAU * sum * TAU / grid.points as f64
}
