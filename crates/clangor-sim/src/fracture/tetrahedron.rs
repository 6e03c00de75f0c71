//! Volume and shape of a tetrahedron.

use clangor_core::glam::DVec3;

/// Six times the volume, positive if the last corner sees the others clockwise.
pub(super) fn six_volumes([a, b, c, d]: [DVec3; 4]) -> f64 {
    (b - a).cross(c - a).dot(d - a)
}

/// Shape of a tetrahedron: 12 (3V)^(2/3) / Σ edge², which is 1 for the regular one and 0 or less for a flat
/// one.
pub(super) fn shape(corners: [DVec3; 4]) -> f64 {
    let [a, b, c, d] = corners;
    let volume = six_volumes(corners) / 6.0;
    let squares: f64 =
        [b - a, c - a, d - a, c - b, d - b, d - c].into_iter().map(DVec3::length_squared).sum();
    12.0 * (3.0 * volume.abs()).powf(2.0 / 3.0) * volume.signum() / squares
}
